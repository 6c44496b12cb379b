"""E-05 resistance drift: the silver cracks and oxidises, and the resistance grows with time in use.

    R -> R (1 + r t),   held at twice the first resistance

Published: 0.1 to 2 % per 100 cycles; up to 2 % within one run of a fresh coating. Cracking goes with cycles and
oxidation with time; over a run of like cycles the two are one.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import RESISTANCE, TIME


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the resistance by the elapsed time."""
    q[RESISTANCE] *= 1.0 + min(max(c[0] * q[TIME], -0.5), 1.0)


EFFECT = Effect(
    name='resistance_drift',
    row='E-05',
    stage='electrical',
    equation='R (1 + r t)',
    source='cracking and oxidation of silver coatings',
    parameters=(Parameter('r', 1e-4, '1/s', -1e-3, 1e-3, 'relative drift of R', 'estimated: 2 % in a run of 210 s'),),
    hooks={'resistance': resistance},
    strength='r',
)
