"""T-05 motion convection: a muscle that moves stirs the air around it.

    hA -> hA (1 + c |dH/dt|)

At 8 mm/s the air passes at about 0.05 m/s. Masuya et al. 2017 use a velocity-dependent coefficient for these muscles.
What a way through the air costs does not depend on how quickly it is gone: a load that jumps and takes the length along
by |H| lets theta = T - Ta fall to theta exp(-hA c |H| / C).
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, CONDUCTANCE, ELASTIC, FORCE, TEMPERATURE, VELOCITY
from tcp_muscle_ros.muscle.table import INDEX

_C, _HA, _K0 = INDEX['C'], INDEX['hA'], INDEX['k0']


def begin(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The load has jumped, and the length with it."""
    jump = q[FORCE] - s[0]
    if jump != 0.0:
        compliance = q[ELASTIC] / q[FORCE] if q[FORCE] > 1e-6 else 1.0 / p[_K0]
        stirred = p[_HA] / p[_C] * c[0] * compliance * abs(jump)
        q[TEMPERATURE] = q[AMBIENT] + (q[TEMPERATURE] - q[AMBIENT]) * exp(-stirred)
        s[0] = q[FORCE]


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance by the speed."""
    q[CONDUCTANCE] *= 1.0 + c[0] * abs(q[VELOCITY])


def remember(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep the force of this instant."""
    s[0] = q[FORCE]


EFFECT = Effect(
    name='motion_convection',
    row='T-05',
    stage='thermal',
    equation='hA (1 + c |dH/dt|)',
    source='Masuya et al. 2017',
    parameters=(Parameter('c', 10.0, 's/m', 0.0, 40.0, 'relative rise of hA per speed', 'estimated: 0.1 per 10 mm/s'),),
    hooks={'begin': begin, 'heat': heat, 'initial': remember, 'commit': remember},
    strength='c',
    states=('stirred_force',),
    motion=True,
)
