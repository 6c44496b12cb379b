"""M-08 kink of the contraction coefficient: little motion below the glass transition, steep above, or the reverse.

    T_drive = T - b integral from T0 to T of (1 - S((T' - Tg)/w)) dT',   S(z) = 1 / (1 + exp(-z)),  w = 4 K

Below Tg the muscle contracts 1 - b times as much per kelvin as above: less with b > 0, more with b < 0. Axial expansion
of nylon 6,6: -0.25e-4 1/K up to 50 degC, -0.81e-4 at 80 degC.
"""

from math import exp, log1p

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, DRIVING_TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

EDGE = 4.0  # K
_T0 = INDEX['T0']


@inner
def _above(temperature: float) -> float:
    """The integral of S: 0 far below, the excess far above."""
    z = temperature / EDGE
    value: float = EDGE * (max(z, 0.0) + log1p(exp(-abs(z))))
    return value


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Take back the share of the motion below the kink, or add it."""
    t = q[CORE_TEMPERATURE]
    q[DRIVING_TEMPERATURE] -= c[0] * (t - p[_T0] - _above(t - c[1]) + _above(p[_T0] - c[1]))


EFFECT = Effect(
    name='cte_kink',
    row='M-08',
    stage='mechanical',
    equation='T_drive = T - b int (1 - S((T - Tg)/w)) dT',
    source='axial expansion of drawn nylon 6,6',
    parameters=(
        Parameter(
            'b',
            0.50,
            '1',
            -1.0,
            1.0,
            'motion a kelvin below the kink: by this share less than above, or more where negative',
            'nylon 6,6: 0.7',
        ),
        Parameter(
            'Tg',
            50.0 + ZERO_CELSIUS,
            'K',
            20.0 + ZERO_CELSIUS,
            100.0 + ZERO_CELSIUS,
            'temperature of the kink',
            'estimated: 40 to 60 degC',
            absolute=True,
            crossed='fibre_temperature',
        ),
    ),
    hooks={'contraction': contraction},
    strength='b',
)
