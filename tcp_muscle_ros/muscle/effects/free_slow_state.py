"""Free slow state: a length that follows a quantity with a lag, by an unlisted law, given as a table.

    dz/dt = (f(x) - z) / tau,   H -> H + z,   x any of temperature, its rate, current, power, length, force, time

A muscle that has long rested starts with z = f(x).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Effect, Freedom
from tcp_muscle_ros.muscle.effects.lag import SHORTEST
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import (
    CORE_TEMPERATURE,
    CURRENT,
    EXTRA,
    FORCE,
    LENGTH,
    POWER,
    TEMPERATURE_RATE,
    TIME,
)

_DRIVERS = law.drivers('temperature', 'temperature_rate', 'current', 'power', 'length', 'force', 'time')
_PLACES = (CORE_TEMPERATURE, TEMPERATURE_RATE, CURRENT, POWER, LENGTH, FORCE, TIME)
_BY_RATE = 1  # place of the driver that no instant knows by itself
_MEANING = 'elongation there, given time'
_TAU = law.OWN
_PIECES = _TAU + 1
_CHOICE, _SHARE, _VALUE = law.DRIVER, law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


@inner
def _wanted(c: Array, x: float) -> float:
    """Where the state goes."""
    value: float = c[_SHARE] * _curve(c, 0, _PIECES, x)
    return value


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The elongation so far."""
    q[EXTRA] += s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The state approaches its law."""
    ds[0] = (_wanted(c, _driver(q, c, _PIECES)) - s[0]) / c[_TAU]
    ds[1] = 0.0


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest: arrived, and no temperature changes."""
    s[0] = _wanted(c, 0.0 if c[_CHOICE] == _BY_RATE else _driver(q, c, _PIECES))
    s[1] = 0.0


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep the rate of this instant."""
    s[1] = q[TEMPERATURE_RATE]


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, s[1] if c[_CHOICE] == _BY_RATE else _driver(q, c, _PIECES))


EFFECT = Effect(
    name='free_slow_state',
    row='',
    stage='mechanical',
    equation='dz/dt = (f(x) - z) / tau, H + z',
    source='a table',
    parameters=(
        *law.table(
            tuple(_DRIVERS), (273.15, 313.15, 353.15, 393.15), (0.0005, 0.0, -0.001, -0.003), 'm', -0.5, 0.5, _MEANING
        ),
        Parameter('tau', 5.0, 's', SHORTEST, 1e4, 'time that it takes', 'an example'),
    ),
    hooks={'extra': extra, 'rates': rates, 'initial': initial, 'commit': commit, 'sensor': sensor},
    strength='share',
    states=('elongation', 'last_rate'),
    fastest_rate=lambda c, p: float(1.0 / c[_TAU]),
    listed=False,
    columns=law.columns('m', _MEANING),
    prepared=law.PREPARED,
    prepare=lambda c: law.prepare(c, _VALUE, _PIECES, _PLACES),
    free=Freedom(_DRIVERS, width=3e-3, bend=1e-3, lag='tau', of='slow part of the length'),
)
