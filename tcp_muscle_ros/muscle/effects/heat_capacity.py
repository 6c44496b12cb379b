"""T-07 heat capacity: nylon's heat capacity rises with the temperature, most of all at the glass transition.

    C -> C (1 + c w (tanh((T - Tg)/w) - tanh((T0 - Tg)/w))),   held within 0.2 to 5 times C

For a w far larger than the range of temperatures this is C (1 + c (T - T0)); for a small w it is a step by 2 c w at Tg.
Nylon 6,6: 0.2 to 0.4 % per kelvin (tables of polymer heat capacities), a step of 5 to 20 % at the transition.
"""

from math import tanh

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CAPACITY, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_T0 = INDEX['T0']


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the capacity."""
    rise = c[0] * c[2] * (tanh((q[TEMPERATURE] - c[1]) / c[2]) - tanh((p[_T0] - c[1]) / c[2]))
    q[CAPACITY] *= min(max(1.0 + rise, 0.2), 5.0)


EFFECT = Effect(
    name='heat_capacity',
    row='T-07',
    stage='thermal',
    equation='C (1 + c w (tanh((T - Tg)/w) - tanh((T0 - Tg)/w)))',
    source='heat capacity tables of nylon 6,6',
    parameters=(
        Parameter('c', 0.003, '1/K', -0.01, 0.05, 'relative rise of C per kelvin at Tg', 'nylon 6,6: 0.2 to 0.4 %/K'),
        Parameter(
            'Tg',
            50.0 + ZERO_CELSIUS,
            'K',
            20.0 + ZERO_CELSIUS,
            120.0 + ZERO_CELSIUS,
            'where it rises most',
            'the glass transition of nylon 6,6',
            absolute=True,
            crossed='fibre_temperature',
            around='w',
        ),
        Parameter('w', 40.0, 'K', 2.0, 500.0, 'half width of the rise', 'a free choice'),
    ),
    hooks={'heat': heat},
    strength='c',
    fastest_rate=lambda c, p: float(3.0 / c[2]),
)
