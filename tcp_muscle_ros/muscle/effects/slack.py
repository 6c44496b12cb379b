"""M-10 slack: a lightly loaded muscle straightens before its end moves.

    H -> H + g tanh(D/g),   g = g0 exp(-F/Fs),   D the thermal contraction

The first millimetres of contraction show nothing; a preload pulls the muscle straight.
"""

from math import exp, tanh

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import EXTRA, FORCE, THERMAL


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The contraction that only takes up slack."""
    gap = c[0] * exp(-q[FORCE] / c[1])
    if gap > 1e-12:
        q[EXTRA] -= gap * tanh(q[THERMAL] / gap)


EFFECT = Effect(
    name='slack',
    row='M-10',
    stage='mechanical',
    equation='H + g tanh(D/g), g = g0 exp(-F/Fs)',
    source='dead band of an unloaded muscle',
    parameters=(
        Parameter('g0', 0.0025, 'm', 0.0, 0.02, 'dead band without load', 'estimated: 0 to 5 mm'),
        Parameter('Fs', 0.1, 'N', 0.05, 1.0, 'load that straightens the muscle', 'estimated: below 0.1 N'),
    ),
    hooks={'extra': extra},
    strength='g0',
)
