"""T-03 airflow: a draught that begins and ends raises the conductance.

    hA -> hA (1 + g [S((t - t1)/w) - S((t - t1 - d)/w)]),   S(z) = 1 / (1 + exp(-z)),  w = 0.5 s

A cross-flow of 0.1, 0.3, 1, 3 m/s raises h 1.5, 2.3, 3.9, 6.5 times (Churchill & Bernstein 1977). A long d is a step.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CONDUCTANCE, TIME
from tcp_muscle_ros.muscle.table import INDEX

EDGE = 0.5  # s


@inner
def _rise(since: float) -> float:
    """0 before, 1 after."""
    share: float = 1.0 / (1.0 + exp(min(max(-since / EDGE, -500.0), 500.0)))
    return share


def heat(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Scale the conductance while the draught lasts."""
    since = q[TIME] - c[1]
    q[CONDUCTANCE] *= 1.0 + c[0] * (_rise(since) - _rise(since - c[2]))


EFFECT = Effect(
    name='airflow',
    row='T-03',
    stage='thermal',
    equation='hA (1 + g) from t1 for a time d',
    source='Churchill & Bernstein 1977',
    parameters=(
        Parameter('g', 0.30, '1', -0.9, 10.0, 'relative rise of hA', 'estimated: 0.1 m/s gives 0.5'),
        Parameter('t1', 75.0, 's', 0.0, 1e6, 'when the draught begins', 'a free choice'),
        Parameter('d', 60.0, 's', 0.0, 1e6, 'how long it lasts', 'a free choice'),
    ),
    hooks={'heat': heat},
    strength='g',
    latent='course',
    circumstance=True,
    moments=('t1', 'd'),
    fastest_rate=lambda c, p: float(max(2.0, (1.0 + c[0]) * p[INDEX['hA']] / p[INDEX['C']])),
)
