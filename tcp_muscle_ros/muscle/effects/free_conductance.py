"""Free conductance: an unlisted law of the conductance, given as a table.

    hA -> hA (1 + f(x)),   x a temperature, current, power, length, force or the time; never below hA/20

f is a natural cubic spline through a table (``free_law.py``). Beyond the table f is
linear, and the muscle reports it.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Effect, Freedom
from tcp_muscle_ros.muscle.quantities import CONDUCTANCE, CURRENT, FORCE, LENGTH, POWER, TEMPERATURE, TIME
from tcp_muscle_ros.muscle.table import INDEX

_DRIVERS = law.drivers('temperature', 'current', 'power', 'length', 'force', 'time')
_PLACES = (TEMPERATURE, CURRENT, POWER, LENGTH, FORCE, TIME)
_MEANING = 'relative rise of hA there'
_PIECES, _LEAST = law.OWN, 0.05
_SHARE, _VALUE = law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance."""
    rise = c[_SHARE] * _curve(c, 0, _PIECES, _driver(q, c, _PIECES))
    q[CONDUCTANCE] *= max(1.0 + rise, _LEAST)


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, _driver(q, c, _PIECES))


EFFECT = Effect(
    name='free_conductance',
    row='',
    stage='thermal',
    equation='hA (1 + f(x))',
    source='a table',
    parameters=law.table(
        tuple(_DRIVERS), (273.15, 313.15, 353.15, 393.15), (-0.05, 0.05, 0.25, 0.35), '1', -0.95, 20.0, _MEANING
    ),
    hooks={'heat': heat, 'sensor': sensor},
    strength='share',
    fastest_rate=lambda c, p: float(2.0 * (1.0 + law.largest(c)) * p[INDEX['hA']] / p[INDEX['C']]),
    listed=False,
    columns=law.columns('1', _MEANING),
    prepared=law.PREPARED,
    prepare=lambda c: law.prepare(c, _VALUE, _PIECES, _PLACES),
    free=Freedom(_DRIVERS, width=0.3, bend=0.1),
)
