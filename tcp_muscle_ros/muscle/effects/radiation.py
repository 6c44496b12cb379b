"""T-02 radiation: the envelope of the coil radiates to surroundings at ambient temperature.

    q = eps sigma A (T^4 - Tinf^4),   A = pi D0 H0

The envelope of the paper's muscle is 3.5e-4 m^2. Bright silver has eps = 0.05, tarnished or soiled up to 0.9.
"""

from math import pi

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, HEAT, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

STEFAN_BOLTZMANN = 5.670374419e-8  # W/(m^2 K^4)
_D0, _H0 = INDEX['D0'], INDEX['H0']


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Lose heat to the surroundings."""
    area = pi * p[_D0] * p[_H0]
    q[HEAT] -= c[0] * STEFAN_BOLTZMANN * area * (q[TEMPERATURE] ** 4 - q[AMBIENT] ** 4)


EFFECT = Effect(
    name='radiation',
    row='T-02',
    stage='thermal',
    equation='eps sigma pi D0 H0 (T^4 - Tinf^4)',
    source='Stefan-Boltzmann law, grey envelope',
    parameters=(Parameter('eps', 0.5, '1', 0.0, 2.0, 'emissivity of the envelope', 'estimated: 0.05 to 0.9'),),
    hooks={'heat': heat},
    strength='eps',
)
