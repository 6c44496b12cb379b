"""Displacement offset: the zero of the laser is not the muscle at rest.

xm = x + o
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import SHOWN_LENGTH


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """A larger displacement is a smaller length."""
    q[SHOWN_LENGTH] -= c[0]


EFFECT = Effect(
    name='displacement_offset',
    row='',
    stage='sensor',
    equation='xm = x + o',
    source='zero of the sensor',
    parameters=(Parameter('o', 0.0005, 'm', -0.1, 0.1, 'offset', 'a free choice'),),
    hooks={'sensor': sensor},
    strength='o',
)
