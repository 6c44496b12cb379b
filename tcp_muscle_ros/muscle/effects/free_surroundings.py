"""Free surroundings: what the muscle loses its heat to warms with it, with a lag, by an unlisted law, given as a table.

    dz/dt = (f(x) - z) / tau,   Tinf -> Tinf + z,   x any of temperature, current, power, length, force

A body that the muscle leans on, or the air of a housing, takes heat and gives it back later; seen from the muscle, its
surroundings are warmer. A muscle that has long rested starts with z = f(x).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Effect, Freedom
from tcp_muscle_ros.muscle.effects.lag import SHORTEST
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, CURRENT, FORCE, LENGTH, POWER, TEMPERATURE

_DRIVERS = law.drivers('temperature', 'current', 'power', 'length', 'force')
_PLACES = (TEMPERATURE, CURRENT, POWER, LENGTH, FORCE)
_MEANING = 'warming of the surroundings there, given time'
_TAU = law.OWN
_PIECES = _TAU + 1
_SHARE, _VALUE = law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


@inner
def _wanted(q: Array, c: Array) -> float:
    """Where the surroundings go."""
    value: float = c[_SHARE] * _curve(c, 0, _PIECES, _driver(q, c, _PIECES))
    return value


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Shift the ambient temperature by what it has warmed so far."""
    q[AMBIENT] += s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The surroundings approach their law."""
    ds[0] = (_wanted(q, c) - s[0]) / c[_TAU]


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest: arrived."""
    s[0] = _wanted(q, c)


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, _driver(q, c, _PIECES))


EFFECT = Effect(
    name='free_surroundings',
    row='',
    stage='thermal',
    equation='dz/dt = (f(x) - z) / tau, Tinf + z',
    source='a table',
    parameters=(
        *law.table(
            tuple(_DRIVERS), (273.15, 293.15, 353.15, 393.15), (0.0, 0.0, 2.0, 3.5), 'K', -100.0, 100.0, _MEANING
        ),
        Parameter('tau', 60.0, 's', SHORTEST, 1e4, 'time that it takes', 'an example'),
    ),
    hooks={'surroundings': surroundings, 'rates': rates, 'initial': initial, 'sensor': sensor},
    strength='share',
    states=('warming',),
    fastest_rate=lambda c, p: float(1.0 / c[_TAU]),
    listed=False,
    columns=law.columns('K', _MEANING),
    prepared=law.PREPARED,
    prepare=lambda c: law.prepare(c, _VALUE, _PIECES, _PLACES),
    free=Freedom(_DRIVERS, width=5.0, bend=2.0, lag='tau'),
)
