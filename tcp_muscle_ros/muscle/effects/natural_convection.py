"""T-01 natural convection: the conductance grows with the excess temperature.

    hA -> hA (|T - Tinf| / 40 K)^n

Free convection around a horizontal cylinder follows Nu ~ Ra^n: n = 0.12 (Churchill & Chu 1975) to 0.155 (Morgan 1975)
at the Rayleigh numbers of this muscle, 0.25 in the laminar limit. hA is then the conductance at an excess of 40 K.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, CONDUCTANCE, TEMPERATURE

REFERENCE_EXCESS = 40.0  # K


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance."""
    q[CONDUCTANCE] *= (abs(q[TEMPERATURE] - q[AMBIENT]) / REFERENCE_EXCESS) ** c[0]


EFFECT = Effect(
    name='natural_convection',
    row='T-01',
    stage='thermal',
    equation='hA (|T - Tinf| / 40 K)^n',
    source='Churchill & Chu 1975, Morgan 1975',
    parameters=(
        Parameter(
            'n',
            0.14,
            '1',
            0.0,
            0.4,
            'exponent of the excess temperature',
            'Churchill & Chu 1975: 0.12, Morgan 1975: 0.155',
        ),
    ),
    hooks={'heat': heat},
    strength='n',
)
