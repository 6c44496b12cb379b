"""S-02 thermocouple gain: the wires conduct heat away, and the bead shows less than the fibre's excess.

    Tm = Tinf + g (T - Tinf)

Two legs of 127 um conduct 1.6e-4 W/K.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, SHOWN_TEMPERATURE


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the excess temperature."""
    q[SHOWN_TEMPERATURE] += (c[0] - 1.0) * (q[SHOWN_TEMPERATURE] - q[AMBIENT])


EFFECT = Effect(
    name='thermocouple_gain',
    row='S-02',
    stage='sensor',
    equation='Tm = Tinf + g (T - Tinf)',
    source='stem conduction of the wires',
    parameters=(Parameter('g', 0.93, '1', 0.5, 1.1, 'shown over true excess temperature', 'estimated: 0.85 to 1'),),
    hooks={'sensor': sensor},
    strength='g',
    none=1.0,
    one_way=True,
)
