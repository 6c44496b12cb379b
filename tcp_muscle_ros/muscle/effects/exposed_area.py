"""T-06 exposed area: an open coil loses more heat than a closed one.

    hA -> hA (H / H0)^e

From open to closed the conductance changes by about 20 %.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CONDUCTANCE, LENGTH
from tcp_muscle_ros.muscle.table import INDEX

_H0 = INDEX['H0']
_PACKED = 0.05  # of H0, below which no coil can be packed


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance by the length."""
    q[CONDUCTANCE] *= max(q[LENGTH] / p[_H0], _PACKED) ** c[0]


EFFECT = Effect(
    name='exposed_area',
    row='T-06',
    stage='thermal',
    equation='hA (H / H0)^e',
    source='geometry of the coil',
    parameters=(Parameter('e', 0.5, '1', -2.0, 2.0, 'elasticity of hA to length', 'estimated: 20 % open to packed'),),
    hooks={'heat': heat},
    strength='e',
)
