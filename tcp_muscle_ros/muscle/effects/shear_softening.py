"""M-05 shear softening: a coil's stiffness follows the shear modulus G, which softens less than Young's modulus E.

    k = k0 (E(T)/E(T0))^(1 - b)

Choy et al. 1984, drawn nylon, 40 to 90 degC: E falls to 0.655, G to 0.78, so b = 1 - ln 0.78 / ln 0.655 = 0.41.
The paper's equation 10 takes both as one (isotropic).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import RATIO


def softening(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """From the ratio of E to that of G."""
    q[RATIO] **= 1.0 - c[0]


EFFECT = Effect(
    name='shear_softening',
    row='M-05',
    stage='mechanical',
    equation='k0 (E(T)/E(T0))^(1 - b)',
    source='Choy et al. 1984',
    parameters=(
        Parameter('b', 0.41, '1', -1.0, 1.5, 'share of the softening of E that G lacks', 'Choy et al. 1984: 0.41'),
    ),
    hooks={'softening': softening},
    strength='b',
)
