"""T-04 ambient drift: the air around the muscle warms up while the ambient thermometer does not tell.

    Tinf -> Tinf + a (1 - exp(-t / tau))

Rooms and enclosures drift 0.3 to 2 K over minutes.
"""

from math import expm1

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, TIME


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Shift the ambient temperature."""
    q[AMBIENT] -= c[0] * expm1(-q[TIME] / c[1])


EFFECT = Effect(
    name='ambient_drift',
    row='T-04',
    stage='thermal',
    equation='Tinf + a (1 - exp(-t / tau))',
    source='enclosure that warms up',
    parameters=(
        Parameter('a', 1.0, 'K', -20.0, 20.0, 'final rise of the ambient', 'estimated: 0.3 to 2 K'),
        Parameter('tau', 200.0, 's', 10.0, 1e5, 'time constant of the rise', 'estimated: minutes'),
    ),
    hooks={'surroundings': surroundings},
    strength='a',
    circumstance=True,
)
