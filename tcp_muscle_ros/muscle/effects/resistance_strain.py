"""E-01 resistance-strain coupling: stretching the coil raises the resistance (piezoresistive self-sensing).

    R -> R (1 + GF (exp(n e) - 1)/n),   e = (H - H0)/H0

GF on coil strain: 0.05 to 2 between yarns (van der Weijde et al. 2016 use the same coupling for self-sensing). n = 0 is
linear; where the current crosses gaps between conductors, the resistance goes with an exponential of the strain.
"""

from math import expm1

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import LENGTH, RESISTANCE
from tcp_muscle_ros.muscle.table import INDEX

_H0 = INDEX['H0']
_NEARLY = 1e-3  # of n: there the law is its series, whose slope in n does not vanish at 0


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the resistance by the coil strain."""
    strain = (q[LENGTH] - p[_H0]) / p[_H0]
    if abs(c[1]) > _NEARLY:
        strain = expm1(c[1] * strain) / c[1]
    else:
        strain *= 1.0 + 0.5 * c[1] * strain
    q[RESISTANCE] *= 1.0 + c[0] * strain


EFFECT = Effect(
    name='resistance_strain',
    row='E-01',
    stage='electrical',
    equation='R (1 + GF (exp(n e) - 1)/n), e = (H - H0)/H0',
    source='van der Weijde et al. 2016',
    parameters=(
        Parameter('GF', 0.15, '1', -3.0, 5.0, 'gauge factor on coil strain', 'estimated: 0.05 to 2'),
        Parameter('n', 0.0, '1', -6.0, 6.0, 'curvature: 0 is linear', 'a free choice', bends=True),
    ),
    hooks={'resistance': resistance},
    strength='GF',
)
