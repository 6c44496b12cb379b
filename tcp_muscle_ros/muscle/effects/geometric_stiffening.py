"""M-07 geometric stiffening: the coil as an inextensible Kirchhoff-Love rod with a fixed number of turns.

    F = k0 L0 [(sin b - sin b0) + r (cos b0 - cos b) tan b] / (1 + r tan^2 b0),   sin b = H/L0,   r = EI/GJ = 1 + mu

scaled by E(T)/E(T0). The initial slope is k0; at 1 N the elongation is 6 % below the linear spring's, at 2 N 12 %.
Without bending stiffness (mu = -1) it is the linear spring. Energy U = (L/2)(2 pi N/L)^2 [EI (cos b - cos b0)^2 +
GJ (sin b - sin b0)^2] (Love 1892); in place of the paper's equation 19, see docs/paper.md.
"""

from math import sqrt

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import ELASTIC, FORCE, RATIO
from tcp_muscle_ros.muscle.table import INDEX

_L0, _H0, _K0 = INDEX['L0'], INDEX['H0'], INDEX['k0']


@inner
def love_force(p: Array, ratio: float, height: float) -> tuple[float, float]:
    """Force (N) and its slope (N/m) at a cold coil height (m); ``ratio`` = EI/GJ."""
    sine0 = p[_H0] / p[_L0]
    cosine0 = sqrt(1.0 - sine0 * sine0)
    sine = height / p[_L0]
    cosine = sqrt(1.0 - sine * sine)
    scale = p[_K0] * p[_L0] / (1.0 + ratio * (sine0 / cosine0) ** 2)
    tangent = sine / cosine
    force = scale * ((sine - sine0) + ratio * (cosine0 - cosine) * tangent)
    slope = scale / p[_L0] * (1.0 + ratio * (tangent * tangent + (cosine0 - cosine) / cosine**3))
    return force, slope


def elasticity(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The elongation that the rod needs for this force: Newton, kept between the last bounds."""
    wanted = q[FORCE] / q[RATIO]
    low, high = 0.0, (p[_L0] - p[_H0]) * (1.0 - 1e-9)
    elongation = min(wanted / p[_K0], 0.5 * high)
    for _ in range(60):
        force, slope = love_force(p, 1.0 + c[0], p[_H0] + elongation)
        error = force - wanted
        if error > 0.0:
            high = elongation
        else:
            low = elongation
        step = error / slope
        if not low <= elongation - step <= high:
            step = elongation - 0.5 * (low + high)
        elongation -= step
        if abs(step) < 1e-15:
            break
    q[ELASTIC] = elongation


EFFECT = Effect(
    name='geometric_stiffening',
    row='M-07',
    stage='mechanical',
    equation='F = k0 L0 [(sin b - sin b0) + (1 + mu)(cos b0 - cos b) tan b] / (1 + (1 + mu) tan^2 b0)',
    source='Kirchhoff-Love rod; replaces equations 19 to 25',
    parameters=(
        Parameter('mu', 0.4, '1', -1.0, 5.0, "Poisson's ratio in EI/GJ = 1 + mu", 'estimated; symbol: equation 10'),
    ),
    hooks={'elasticity': elasticity},
    strength='mu',
    none=-1.0,
)
