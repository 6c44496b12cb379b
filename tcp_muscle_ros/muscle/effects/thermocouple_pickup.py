"""Thermocouple pickup: the bead touches a wire that carries current, and the meter takes its voltage for heat.

    Tm = T + k i

Across a bead of 0.2 mm on a muscle of 28 ohm/m, 0.27 A make 1.5 mV, and type K gives 41 uV/K: a fortieth of it between
the two wires is a kelvin. A loop over the ground of the supply shows the same.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CURRENT, SHOWN_TEMPERATURE


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Add what the current makes."""
    q[SHOWN_TEMPERATURE] += c[0] * q[CURRENT]


EFFECT = Effect(
    name='thermocouple_pickup',
    row='',
    stage='sensor',
    equation='Tm = T + k i',
    source='voltage of the muscle along a bead of 0.1 to 0.3 mm, 41 uV/K (type K)',
    parameters=(Parameter('k', 3.0, 'K/A', -60.0, 60.0, 'shown for each ampere', 'estimated: 0.5 to 20 K/A'),),
    hooks={'sensor': sensor},
    strength='k',
)
