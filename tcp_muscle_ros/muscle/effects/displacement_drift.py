"""S-04 displacement drift: the laser warms up, or its stand sways with the room.

    xm = x + r t (1 + (1 - z) (b + c (1 - 2 z))),   z = min(t / tau, 1)

0.1 to 1 mm in 200 s. The mean rate is r; b bends the course, c gives it an S shape. With b = c = 0 it is a ramp; with
b = 1 it slows down towards tau, as a laser that warms up.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.course import mean_rate
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import SHOWN_LENGTH, TIME


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """A displacement that grows is a length that falls."""
    z = min(q[TIME] / c[3], 1.0)
    q[SHOWN_LENGTH] -= c[0] * q[TIME] * mean_rate(z, c[1], c[2])


EFFECT = Effect(
    name='displacement_drift',
    row='S-04',
    stage='sensor',
    equation='xm = x + r t (1 + (1 - z) (b + c (1 - 2 z))), z = t / tau',
    source='warm-up of laser sensors',
    parameters=(
        Parameter('r', 2.5e-6, 'm/s', -1e-3, 1e-3, 'mean drift', 'estimated: 0.1 to 1 mm in 200 s'),
        Parameter('b', 0.0, '1', -20.0, 20.0, 'bend of the course, relative to the drift', 'a free choice'),
        Parameter('c', 0.0, '1', -40.0, 40.0, 'S shape of the course, relative to the drift', 'a free choice'),
        Parameter('tau', 200.0, 's', 10.0, 1e5, 'how long it bends', 'estimated: minutes', fitted=False),
    ),
    hooks={'sensor': sensor},
    strength='r',
    like_slips=True,
    circumstance=True,
    whole='tau',
)
