"""T-08 latent heat: a transition absorbs heat within a range of temperatures.

    C -> C + c exp(-((T - Tm) / w)^2 / 2)

The heat of the transition is c w sqrt(2 pi). Nylon 6,6 melts near 260 degC and none is reported below 120 degC; other
fibres, additives and moisture have one.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CAPACITY, TEMPERATURE


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Raise the capacity within the band."""
    z = (q[TEMPERATURE] - c[1]) / c[2]
    q[CAPACITY] += c[0] * exp(-0.5 * z * z)


EFFECT = Effect(
    name='latent_heat',
    row='T-08',
    stage='thermal',
    equation='C + c exp(-((T - Tm)/w)^2 / 2)',
    source='apparent heat capacity of a transition',
    parameters=(
        Parameter('c', 0.04, 'J/K', 0.0, 1.0, 'height of the peak', 'estimated: a quarter of C'),
        Parameter(
            'Tm',
            60.0 + ZERO_CELSIUS,
            'K',
            20.0 + ZERO_CELSIUS,
            150.0 + ZERO_CELSIUS,
            'middle of the band',
            'a free choice',
            absolute=True,
            crossed='fibre_temperature',
        ),
        Parameter('w', 6.0, 'K', 1.0, 40.0, 'standard width of the band', 'a free choice'),
    ),
    hooks={'heat': heat},
    strength='c',
    unexpected=True,
    fastest_rate=lambda c, p: float(6.0 / c[2]),
)
