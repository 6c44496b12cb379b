"""M-06 load-dependent stroke: a coil that the load has stretched contracts less for the same untwist.

    B -> B / (1 + b u0 (u / u0)^n),   u = F / (k0 H0), u0 = 0.2

b = 1 and n = 1 is B = L0^2/H(F) with the length under load in place of H0 (equation 16): 8, 15, 22 % less at 30, 60,
100 g. The decrease may grow faster or more slowly than the load; at 70 g it is the same for all n.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import FORCE, GAIN
from tcp_muscle_ros.muscle.table import INDEX

_K0, _H0 = INDEX['k0'], INDEX['H0']
_OPENED = 0.2  # the share by which 70 g open the coil


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the stroke gain by the load."""
    opened = q[FORCE] / (p[_K0] * p[_H0])
    q[GAIN] /= max(1.0 + c[0] * _OPENED * max(opened / _OPENED, 0.0) ** c[1], 0.1)


EFFECT = Effect(
    name='load_stroke',
    row='M-06',
    stage='mechanical',
    equation='B / (1 + b u0 (u/u0)^n), u = F/(k0 H0)',
    source='equation 16 with the length under load',
    parameters=(
        Parameter('b', 1.0, '1', -2.0, 5.0, 'share of the geometric fall', 'L0^2/H(F) gives 1'),
        Parameter('n', 1.0, '1', 0.3, 3.0, 'how the fall grows with the load', 'a free choice'),
    ),
    hooks={'contraction': contraction},
    strength='b',
)
