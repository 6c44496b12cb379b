"""M-13 inertia: a hanging weight oscillates about the length of the resolved model.

    M H'' = F - N - 2 zeta sqrt(k M) H',   N = F + k (H - Hs), times q where it is negative,   M = b max(F, 0.1 N)/g

Hs is the equilibrium length; b = 1 is a dead weight, b = 0 a load without mass (a long soft spring, a servo). A weight
that moves up fast may press on the muscle: a slender coil buckles at once (q = 0), a short one with open turns resists
as it does in tension (q = 1). The clamp weighs at least 0.1 N. Below b = 0.25 the mass stays that of b = 0.25 and the
length follows it in part, so that b = 0 is the resolved model. Held ends do not oscillate.
"""

from math import sqrt

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import GRAVITY, Parameter
from tcp_muscle_ros.muscle.quantities import EQUILIBRIUM_LENGTH, FORCE, HELD, LENGTH, STIFFNESS
from tcp_muscle_ros.muscle.table import INDEX

_LIGHTEST = 0.1  # N
_SMALLEST = 0.25  # of a dead weight's mass


@inner
def _mass(c: Array, force: float) -> float:
    """The swinging mass, kg."""
    mass: float = max(c[0], _SMALLEST) * max(force, _LIGHTEST) / GRAVITY
    return mass


def position(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The end is where the weight is."""
    if q[HELD] == 0.0:
        q[LENGTH] += min(c[0] / _SMALLEST, 1.0) * (s[0] - q[EQUILIBRIUM_LENGTH])


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Newton's law of the weight."""
    if q[HELD] == 0.0:
        mass, k = _mass(c, q[FORCE]), q[STIFFNESS]
        tension = q[FORCE] + k * (s[0] - q[EQUILIBRIUM_LENGTH])
        if tension < 0.0:
            tension *= c[2]
        ds[0] = s[1]
        ds[1] = (q[FORCE] - tension - 2.0 * c[1] * sqrt(k * mass) * s[1]) / mass
    else:
        ds[0] = ds[1] = 0.0


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The weight hangs at rest."""
    s[0], s[1] = q[EQUILIBRIUM_LENGTH], 0.0


EFFECT = Effect(
    name='inertia',
    row='M-13',
    stage='mechanical',
    equation="M H'' = F - N - 2 zeta sqrt(k M) H', N = F + k (H - Hs), times q below 0, M = b F/g",
    source="Newton's law",
    parameters=(
        Parameter('b', 1.0, '1', 0.0, 2.0, 'mass over that of a dead weight', 'a hanging weight: 1'),
        Parameter('zeta', 0.05, '1', 0.0, 2.0, 'damping ratio', 'estimated: 0.02 to 0.1'),
        Parameter('q', 0.0, '1', 0.0, 1.0, 'stiffness when pressed, of that when pulled', 'a slender coil buckles: 0'),
    ),
    hooks={'position': position, 'rates': rates, 'initial': initial},
    strength='b',
    swings=True,
    least_rate=8.0,  # a hanging weight rings at 2 to 5 Hz, and must be seen twice a period
    states=('position', 'velocity'),
    fastest_rate=lambda c, p: 0.7 * sqrt(1.1 * p[INDEX['k0']] * GRAVITY / (max(c[0], _SMALLEST) * _LIGHTEST)),
)
