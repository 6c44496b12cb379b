"""M-05 shear softening: a coil's stiffness follows the shear modulus G, which softens less than Young's modulus E.

    k = k0 (E(T)/E(T0))^(1 - b (1 + m (T - T0)/50 K))

Choy et al. 1984, drawn nylon, 40 to 90 degC: E falls to 0.655, G to 0.78, so b = 1 - ln 0.78 / ln 0.655 = 0.41. The
ratio need not be constant: with m < 0, G follows E more closely the hotter it is. The paper's equation 10 takes
both as one (isotropic).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, RATIO
from tcp_muscle_ros.muscle.table import INDEX

_T0, _SPAN = INDEX['T0'], 50.0


def softening(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """From the ratio of E to that of G."""
    q[RATIO] **= 1.0 - c[0] * (1.0 + c[1] * (q[CORE_TEMPERATURE] - p[_T0]) / _SPAN)


EFFECT = Effect(
    name='shear_softening',
    row='M-05',
    stage='mechanical',
    equation='k0 (E(T)/E(T0))^(1 - b (1 + m (T - T0)/50 K))',
    source='Choy et al. 1984',
    parameters=(
        Parameter('b', 0.41, '1', -1.0, 1.5, 'share of the softening of E that G lacks', 'Choy et al. 1984: 0.41'),
        Parameter('m', 0.0, '1', -2.0, 2.0, 'how that grows within 50 K', 'a free choice'),
    ),
    hooks={'softening': softening},
    strength='b',
)
