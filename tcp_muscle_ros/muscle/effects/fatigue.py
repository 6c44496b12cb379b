"""M-12 fatigue: the stroke shrinks with the logarithm of the cycles.

    B -> B (1 - c ln(1 + n0 + n)),   dn/dt = |dT/dt| / (2 * 50 K)

n counts cycles by the travel of the temperature, 50 K up and 50 K down; n0 are those before. 1 to 5 % per 1000 cycles
is c = 0.0015 to 0.007.
"""

from math import log1p

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import SWING, Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import GAIN, TEMPERATURE_RATE


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the stroke gain."""
    q[GAIN] *= max(1.0 - c[0] * log1p(c[1] + s[0]), 0.0)


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Count the travel."""
    ds[0] = abs(q[TEMPERATURE_RATE]) / (2.0 * SWING)


EFFECT = Effect(
    name='fatigue',
    row='M-12',
    stage='mechanical',
    equation='B (1 - c ln(1 + n0 + n)), n cycles of 50 K',
    source='logarithmic loss of stroke',
    parameters=(
        Parameter('c', 0.004, '1', -0.1, 0.1, 'loss per e-fold of cycles', 'estimated: 1 to 5 % per 1000'),
        Parameter('n0', 0.0, '1', 0.0, 1e9, 'cycles before', 'a new muscle; earlier recordings', fitted=False),
    ),
    hooks={'contraction': contraction, 'rates': rates},
    strength='c',
    age='n0',
    states=('cycles',),
)
