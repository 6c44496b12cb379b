"""S-03 temperature offset: an error of the cold junction or of the calibration.

    Tm = T + o

0.1 to 1 K for type K and T thermocouples with common amplifiers.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import SHOWN_TEMPERATURE


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Add the offset."""
    q[SHOWN_TEMPERATURE] += c[0]


EFFECT = Effect(
    name='temperature_offset',
    row='S-03',
    stage='sensor',
    equation='Tm = T + o',
    source='tolerance of thermocouple and amplifier',
    parameters=(Parameter('o', 0.5, 'K', -30.0, 30.0, 'offset', 'estimated: 0.1 to 1 K'),),
    hooks={'sensor': sensor},
    strength='o',
    circumstance=True,  # a cold junction is off by another amount after each start
)
