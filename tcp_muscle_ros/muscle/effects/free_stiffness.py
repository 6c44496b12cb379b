"""Free stiffness: an unlisted law of the stiffness, given as a table.

    k -> k (1 + f(x)),   x a temperature, force or the time; never below k/20

Of a force it is the secant: the elongation under F is F/(k (1 + f(F))).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Effect, Freedom
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, ELASTIC, FORCE, RATIO, TIME

_DRIVERS = law.drivers('temperature', 'force', 'time')
_PLACES = (CORE_TEMPERATURE, FORCE, TIME)
BY_TEMPERATURE, BY_FORCE = range(2)  # places of drivers
_MEANING = 'relative rise of k there'
PIECES, LEAST = law.OWN, 0.05
READY = PIECES + law.PREPARED  # 1 where the law is on: what is read without hooks asks it (statics.py)
_CHOICE, _SHARE, _VALUE = law.DRIVER, law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


def softening(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the stiffness for all that asks it."""
    if c[_CHOICE] != BY_FORCE:
        rise = c[_SHARE] * _curve(c, 0, PIECES, _driver(q, c, PIECES))
        q[RATIO] *= max(1.0 + rise, LEAST)


def elasticity(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The force is known only now."""
    if c[_CHOICE] == BY_FORCE:
        q[ELASTIC] /= max(1.0 + c[_SHARE] * _curve(c, 0, PIECES, q[FORCE]), LEAST)


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, _driver(q, c, PIECES))


def _prepare(c: Array) -> None:
    law.prepare(c, _VALUE, PIECES, _PLACES)
    c[READY] = 1.0


EFFECT = Effect(
    name='free_stiffness',
    row='',
    stage='mechanical',
    equation='k (1 + f(x))',
    source='a table',
    parameters=law.table(
        tuple(_DRIVERS), (273.15, 313.15, 353.15, 393.15), (0.0, -0.05, -0.1, -0.25), '1', -0.95, 20.0, _MEANING
    ),
    hooks={'softening': softening, 'elasticity': elasticity, 'sensor': sensor},
    strength='share',
    listed=False,
    columns=law.columns('1', _MEANING),
    prepared=law.PREPARED + 1,
    prepare=_prepare,
    free=Freedom(_DRIVERS, width=0.2, bend=0.1, by_loads=True),
)
