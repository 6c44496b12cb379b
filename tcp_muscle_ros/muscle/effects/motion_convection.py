"""T-05 motion convection: a muscle that moves stirs the air around it.

    hA -> hA (1 + c |v| (|v|/v0)^(n-1)),   v = dH/dt, v0 = 10 mm/s

At 8 mm/s the air passes at about 0.05 m/s. Masuya et al. 2017 use a velocity-dependent coefficient for these muscles;
forced convection follows a power of the speed, 0.3 to 0.6 for cylinders (Churchill & Bernstein 1977), or less where
natural convection adds to it. For n = 1 the heat lost over a distance does not depend on the speed: a load step that
changes the length by dH lowers theta = T - Tinf to theta exp(-hA c |dH| / C). For other n a step moves at 0.1 m/s.

Cooling moves the muscle, and motion cools it: beyond a certain strength this would have no limit. So hA is at most ten
times its value at rest (in a wind of 3 m/s it is 6.5 times, after Churchill & Bernstein).
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, CONDUCTANCE, ELASTIC, FORCE, TEMPERATURE, VELOCITY
from tcp_muscle_ros.muscle.table import INDEX

_C, _HA, _K0 = INDEX['C'], INDEX['hA'], INDEX['k0']
_USUAL, _JUMPING, _SLOWEST = 0.01, 0.1, 1e-5  # m/s; below the slowest the loss goes with the speed
_MOST = 9.0  # relative rise of hA


@inner
def _per_speed(c: Array, speed: float) -> float:
    """The relative rise of hA over the speed, s/m."""
    rise: float = c[0] if c[1] == 1.0 else c[0] * (max(speed, _SLOWEST) / _USUAL) ** (c[1] - 1.0)
    return rise


def begin(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The load has jumped, and the length with it."""
    jump = q[FORCE] - s[0]
    if jump != 0.0:
        compliance = q[ELASTIC] / q[FORCE] if q[FORCE] > 1e-6 else 1.0 / p[_K0]
        stirred = p[_HA] / p[_C] * _per_speed(c, _JUMPING) * compliance * abs(jump)
        q[TEMPERATURE] = q[AMBIENT] + (q[TEMPERATURE] - q[AMBIENT]) * exp(-stirred)
        s[0] = q[FORCE]


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance by the speed."""
    speed = abs(q[VELOCITY])
    rise = _per_speed(c, speed) * speed
    q[CONDUCTANCE] *= 1.0 + rise / (1.0 + (rise / _MOST) ** 4) ** 0.25


def remember(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep the force of this instant."""
    s[0] = q[FORCE]


EFFECT = Effect(
    name='motion_convection',
    row='T-05',
    stage='thermal',
    equation='hA (1 + c |v| (|v|/10 mm/s)^(n-1)), v = dH/dt',
    source='Masuya et al. 2017; the power of Churchill & Bernstein 1977',
    parameters=(
        Parameter('c', 10.0, 's/m', 0.0, 100.0, 'relative rise of hA per speed', 'estimated: 0.1 per 10 mm/s'),
        Parameter('n', 1.0, '1', 0.3, 1.5, 'power of the speed', 'forced convection: 0.3 to 0.6'),
    ),
    hooks={'begin': begin, 'heat': heat, 'initial': remember, 'commit': remember},
    strength='c',
    states=('stirred_force',),
    motion=True,
)
