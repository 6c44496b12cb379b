"""Free stroke: an unlisted law of the length, given as a table; for cooling another may be given.

    H -> H + f(x),   x a temperature, its rate, the current, power, force or the time
    f = fh while it heats, fc while it cools; after a reversal one changes into the other within about 10 K

``value`` is fh, and also fc unless ``cooling`` is given. The change from one branch to the other depends on the path of
the temperature and not on time (Duhem). It begins as after cooling.

Current and power are those that the source is set to, through R(T): the length is known before what really flows. The
rate is that over the instant before, for what the heat will do is known only after the length.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Column, Effect, Freedom
from tcp_muscle_ros.muscle.electrical import joule_heating, resistance_at, source_current
from tcp_muscle_ros.muscle.quantities import (
    COMMAND,
    CORE_TEMPERATURE,
    CURRENT,
    EXTRA,
    FORCE,
    KIND,
    POWER,
    TEMPERATURE,
    TEMPERATURE_RATE,
    TIME,
)

TRAVEL = 10.0  # K, over which a turn changes branch
_DRIVERS = law.drivers('temperature', 'force', 'time', 'temperature_rate', 'current', 'power')
_PLACES = (CORE_TEMPERATURE, FORCE, TIME, TEMPERATURE_RATE, CURRENT, POWER)
BY_TEMPERATURE, BY_FORCE, _, BY_RATE, BY_CURRENT, BY_POWER = range(len(_PLACES))  # places of drivers
_MEANING = 'elongation there'
_COOLING_MEANING = 'elongation there while it cools'
_COOLING = law.OWN
PIECES = _COOLING + law.KNOTS
_COOLING_PIECES = PIECES + law.PREPARED
READY = _COOLING_PIECES + law.PREPARED  # 1 where the law is on: what is read without hooks asks it (statics.py)
_TWO = READY + 1  # 1 where cooling has values of its own
_CHOICE, _SHARE, _VALUE = law.DRIVER, law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark
_DEFAULT = (0.001, 0.0, -0.001, -0.004)


@inner
def _asked(q: Array, c: Array, p: Array, s: Array) -> float:
    """What drives the law, as far as it is known before the length is."""
    value: float = _driver(q, c, PIECES)
    if c[_CHOICE] == BY_RATE:
        value = s[2]
    elif c[_CHOICE] == BY_CURRENT:
        value = source_current(q[KIND], q[COMMAND], resistance_at(p, q[TEMPERATURE]))
    elif c[_CHOICE] == BY_POWER:
        value = joule_heating(q[KIND], q[COMMAND], resistance_at(p, q[TEMPERATURE]))
    return value


@inner
def _branch(temperature: float, s: Array) -> float:
    """1 heating, -1 cooling, and between them after a turn."""
    way = temperature - s[0]
    goal = 1.0 if way > 0.0 else -1.0
    value: float = goal + (s[1] - goal) * exp(-abs(way) / TRAVEL)
    return value


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The elongation that the law adds."""
    x = _asked(q, c, p, s)
    value = _curve(c, 0, PIECES, x)
    if c[_TWO] > 0.0:
        cooling = 0.5 * (1.0 - _branch(q[CORE_TEMPERATURE], s))
        value += cooling * (_curve(c, 0, _COOLING_PIECES, x) - value)
    q[EXTRA] += c[_SHARE] * value


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, _asked(q, c, p, s))


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """As after cooling: a muscle in use was hotter before."""
    s[0], s[1] = q[CORE_TEMPERATURE], -1.0
    s[2], s[3] = 0.0, q[TIME]


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The temperature has gone its way."""
    s[1] = _branch(q[CORE_TEMPERATURE], s)
    if q[TIME] > s[3]:
        s[2] = (q[CORE_TEMPERATURE] - s[0]) / (q[TIME] - s[3])
    s[3] = q[TIME]
    s[0] = q[CORE_TEMPERATURE]


def _prepare(c: Array) -> None:
    law.prepare(c, _VALUE, PIECES, _PLACES)
    law.prepare(c, _COOLING, _COOLING_PIECES, _PLACES)
    n = int(c[law.COUNT])
    c[READY] = 1.0
    c[_TWO] = float((c[_VALUE : _VALUE + n] != c[_COOLING : _COOLING + n]).any())


EFFECT = Effect(
    name='free_stroke',
    row='',
    stage='mechanical',
    equation='H + f(x), f = fh heating, fc cooling',
    source='a table',
    parameters=(
        *law.table(tuple(_DRIVERS), (273.15, 313.15, 353.15, 393.15), _DEFAULT, 'm', -0.5, 0.5, _MEANING),
        *law.series('cooling', _DEFAULT, 'm', -0.5, 0.5, _COOLING_MEANING),
    ),
    hooks={'extra': extra, 'sensor': sensor, 'initial': initial, 'commit': commit},
    strength='share',
    states=('turned_at', 'branch', 'rate', 'last_time'),
    listed=False,
    columns=(
        *law.columns('m', _MEANING),
        Column('cooling', 'm', _COOLING_MEANING, law.members('cooling'), 'knots', follows='value'),
    ),
    prepared=2 * law.PREPARED + 2,
    prepare=_prepare,
    # Of a current it would be tried beside every effect that a switch shows, which no suite has been run for.
    # A stroke is what shortens the muscle; the table is of what lengthens it.
    free=Freedom(_DRIVERS, width=3e-3, bend=1e-3, untried=frozenset({'current'}), of='length'),
)
