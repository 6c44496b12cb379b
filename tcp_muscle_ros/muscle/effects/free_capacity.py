"""Free capacity: an unlisted law of the heat capacity, given as a table.

    C -> C (1 + f(x)),   x a temperature, length, force or the time; held within 0.2 to 5 times C

f is a natural cubic spline through a table (``free_law.py``). Beyond the table f is
linear, and the muscle reports it.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects import free_law as law
from tcp_muscle_ros.muscle.effects.effect import Effect, Freedom
from tcp_muscle_ros.muscle.quantities import CAPACITY, FORCE, LENGTH, TEMPERATURE, TIME
from tcp_muscle_ros.muscle.table import INDEX

_DRIVERS = law.drivers('temperature', 'length', 'force', 'time')
_PLACES = (TEMPERATURE, LENGTH, FORCE, TIME)
_MEANING = 'relative rise of C there'
_PIECES, _LEAST, _MOST = law.OWN, 0.2, 5.0
_SHARE, _VALUE = law.SHARE, law.VALUE
_curve, _driver, _mark = law.curve, law.driver, law.mark


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the capacity."""
    rise = c[_SHARE] * _curve(c, 0, _PIECES, _driver(q, c, _PIECES))
    q[CAPACITY] *= min(max(1.0 + rise, _LEAST), _MOST)


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Is the table asked outside its range?"""
    _mark(q, c, _driver(q, c, _PIECES))


EFFECT = Effect(
    name='free_capacity',
    row='',
    stage='thermal',
    equation='C (1 + f(x))',
    source='a table',
    parameters=law.table(
        tuple(_DRIVERS), (273.15, 313.15, 353.15, 393.15), (-0.05, 0.05, 0.2, 0.3), '1', -0.8, 4.0, _MEANING
    ),
    hooks={'heat': heat, 'sensor': sensor},
    strength='share',
    fastest_rate=lambda c, p: float(4.0 * p[INDEX['hA']] / p[INDEX['C']] / max(1.0 + law.smallest(c), _LEAST)),
    listed=False,
    columns=law.columns('1', _MEANING),
    prepared=law.PREPARED,
    prepare=lambda c: law.prepare(c, _VALUE, _PIECES, _PLACES),
    free=Freedom(_DRIVERS, width=0.2, bend=0.1),
)
