"""T-04 ambient drift: the air around the muscle changes, and no thermometer shows it.

    Tinf -> Tinf + a z (1 + (1 - z) (b + c (1 - 2 z))),   z = min(t / tau, 1)

Rooms and enclosures drift 0.3 to 2 K over minutes. The total change is a; b bends its course, c gives it an S shape.
With b = c = 0 it is a ramp; with b = 1 it slows down towards its end, as in an enclosure that warms up.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.course import mean_rate
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import AMBIENT, TIME


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Shift the ambient temperature."""
    z = min(q[TIME] / c[3], 1.0)
    q[AMBIENT] += c[0] * z * mean_rate(z, c[1], c[2])


EFFECT = Effect(
    name='ambient_drift',
    row='T-04',
    stage='thermal',
    equation='Tinf + a z (1 + (1 - z) (b + c (1 - 2 z))), z = t / tau',
    source='rooms and enclosures that warm up',
    parameters=(
        Parameter('a', 1.0, 'K', -20.0, 20.0, 'total rise of the ambient', 'estimated: 0.3 to 2 K'),
        Parameter('b', 0.0, '1', -20.0, 20.0, 'bend of the course, relative to the rise', 'a free choice'),
        Parameter('c', 0.0, '1', -40.0, 40.0, 'S shape of the course, relative to the rise', 'a free choice'),
        Parameter('tau', 200.0, 's', 10.0, 1e5, 'how long it goes on', 'estimated: minutes', fitted=False),
    ),
    hooks={'surroundings': surroundings},
    strength='a',
    latent='room',
    circumstance=True,
    whole='tau',
)
