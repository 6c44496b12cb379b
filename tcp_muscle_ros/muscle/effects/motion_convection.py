"""T-05 motion convection: a muscle that moves stirs the air around it.

    hA -> hA (1 + c |dH/dt|)

At 8 mm/s the air passes at about 0.05 m/s. Masuya et al. 2017 use a velocity-dependent coefficient for these muscles.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CONDUCTANCE, VELOCITY


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance by the speed."""
    q[CONDUCTANCE] *= 1.0 + c[0] * abs(q[VELOCITY])


EFFECT = Effect(
    name='motion_convection',
    row='T-05',
    stage='thermal',
    equation='hA (1 + c |dH/dt|)',
    source='Masuya et al. 2017',
    parameters=(Parameter('c', 10.0, 's/m', 0.0, 40.0, 'relative rise of hA per speed', 'estimated: 0.1 per 10 mm/s'),),
    hooks={'heat': heat},
    strength='c',
    motion=True,
)
