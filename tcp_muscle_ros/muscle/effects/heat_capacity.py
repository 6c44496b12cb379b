"""T-07 heat capacity: nylon takes up more heat per kelvin when hot.

    C -> C (1 + c (T - T0)),   held within 0.2 to 5 times C

Nylon 6,6: 0.2 to 0.4 % per kelvin (tables of polymer heat capacities).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CAPACITY, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_T0 = INDEX['T0']


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the capacity."""
    q[CAPACITY] *= min(max(1.0 + c[0] * (q[TEMPERATURE] - p[_T0]), 0.2), 5.0)


EFFECT = Effect(
    name='heat_capacity',
    row='T-07',
    stage='thermal',
    equation='C (1 + c (T - T0))',
    source='heat capacity tables of nylon 6,6',
    parameters=(
        Parameter('c', 0.003, '1/K', -0.01, 0.02, 'relative rise of C per kelvin', 'nylon 6,6: 0.2 to 0.4 %/K'),
    ),
    hooks={'heat': heat},
    strength='c',
)
