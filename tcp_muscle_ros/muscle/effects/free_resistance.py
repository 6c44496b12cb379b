"""Free resistance: an unlisted law of the resistance, given as a table.

    R -> R (1 + f(x)),   x a temperature, length, force or the time; never below R/20

f is a natural cubic spline through a table (``free_law.py``). Beyond the table f is
linear, and the muscle reports it.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Effect, Freedom
from tcp_muscle_ros.muscle.quantities import FORCE, LENGTH, RESISTANCE, TEMPERATURE, TIME

_DRIVERS = law.drivers('temperature', 'length', 'force', 'time')
_PLACES = (TEMPERATURE, LENGTH, FORCE, TIME)
_MEANING = 'relative rise of R there'
PIECES, LEAST = law.OWN, 0.05
_SHARE, _VALUE = law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the resistance."""
    rise = c[_SHARE] * _curve(c, 0, PIECES, _driver(q, c, PIECES))
    q[RESISTANCE] *= max(1.0 + rise, LEAST)


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, _driver(q, c, PIECES))


EFFECT = Effect(
    name='free_resistance',
    row='',
    stage='electrical',
    equation='R (1 + f(x))',
    source='a table',
    parameters=law.table(
        tuple(_DRIVERS), (273.15, 313.15, 353.15, 393.15), (0.0, 0.0, 0.02, 0.06), '1', -0.9, 10.0, _MEANING
    ),
    hooks={'resistance': resistance, 'sensor': sensor},
    strength='share',
    listed=False,
    columns=law.columns('1', _MEANING),
    prepared=law.PREPARED,
    prepare=lambda c: law.prepare(c, _VALUE, PIECES, _PLACES),
    free=Freedom(_DRIVERS, width=0.05, bend=0.02),
)
