"""S-04 displacement drift: the laser warms up, or its stand does.

    xm = x + r t

0.1 to 1 mm in 200 s.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import SHOWN_LENGTH, TIME


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """A displacement that grows is a length that falls."""
    q[SHOWN_LENGTH] -= c[0] * q[TIME]


EFFECT = Effect(
    name='displacement_drift',
    row='S-04',
    stage='sensor',
    equation='xm = x + r t',
    source='warm-up of laser sensors',
    parameters=(Parameter('r', 2.5e-6, 'm/s', -1e-3, 1e-3, 'drift', 'estimated: 0.1 to 1 mm in 200 s'),),
    hooks={'sensor': sensor},
    strength='r',
    circumstance=True,
)
