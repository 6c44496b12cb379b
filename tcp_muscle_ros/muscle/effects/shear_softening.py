"""M-05 shear softening: a coil's stiffness follows the shear modulus G, which softens otherwise than Young's modulus E.

    with E:         k = k0 (E(T)/E(T0))^(1 - b (1 + m (T - T0)/50 K))
    at Tg:          k = k0 E(T)/E(T0) h(T)/h(T0),   h = 1 - b / (1 + exp(-(T - Tg)/w))

Choy et al. 1984, drawn nylon, 40 to 90 degC: E falls to 0.655, G to 0.78, so b = 1 - ln 0.78 / ln 0.655 = 0.41. The
ratio need not be constant: with m < 0, G follows E more closely the hotter it is. Or G loses the
share b more than E where its glass changes, within a few K of a Tg of its own. The paper's equation 10 takes both as
one (isotropic).
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, RATIO
from tcp_muscle_ros.muscle.table import INDEX

_T0, _SPAN = INDEX['T0'], 50.0
_LEAST = 0.05  # of the stiffness, that every coil keeps


@inner
def _held(c: Array, temperature: float) -> float:
    """h, which is 1 far below Tg."""
    value: float = 1.0 - c[0] / (1.0 + exp(min((c[3] - temperature) / c[4], 500.0)))
    return max(value, _LEAST)


def softening(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """From the ratio of E to that of G."""
    if c[2] < 0.5:
        q[RATIO] **= 1.0 - c[0] * (1.0 + c[1] * (q[CORE_TEMPERATURE] - p[_T0]) / _SPAN)
    else:
        q[RATIO] *= _held(c, q[CORE_TEMPERATURE]) / _held(c, p[_T0])


EFFECT = Effect(
    name='shear_softening',
    row='M-05',
    stage='mechanical',
    equation='k0 (E(T)/E(T0))^(1 - b (1 + m (T - T0)/50 K)), or E(T)/E(T0) times a step of 1 - b at Tg',
    source='Choy et al. 1984',
    parameters=(
        Parameter(
            'b', 0.41, '1', -1.0, 1.5, 'with E: share of its softening that G lacks; at Tg: share of G lost',
            'Choy et al. 1984: 0.41',
        ),
        Parameter('m', 0.0, '1', -2.0, 2.0, 'how that grows within 50 K', 'a free choice', only=('where', 0)),
        Parameter(
            'where', 0.0, '1', 0.0, 1.0, 'where G differs from E: 0 all along with it, 1 at Tg',
            'a free choice',
            choices=('with E', 'at Tg'), fitted=False,
        ),
        Parameter(
            'Tg', 45.0 + ZERO_CELSIUS, 'K', 0.0 + ZERO_CELSIUS, 150.0 + ZERO_CELSIUS, 'middle of the step',
            'glass transition of dry nylon 6,6: 40 to 50 degC',
            absolute=True, crossed='fibre_temperature', only=('where', 1),
        ),
        Parameter('w', 6.0, 'K', 1.0, 30.0, 'width of the step', 'a free choice', only=('where', 1)),
    ),
    hooks={'softening': softening},
    strength='b',
)  # fmt: skip
