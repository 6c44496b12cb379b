"""M-09 coil contact: the coil cannot become shorter than its turns side by side.

    H -> H + s w ln(1 + exp((Hc - H)/w))

A soft stop: with s = 1 the length never falls below Hc, and there the force of a held muscle no longer rises with the
temperature. Hc = N d/cos b is 56 mm for a fibre diameter d of 0.2 mm and 130 mm for one of 0.46 mm.
"""

from math import exp, log1p

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import LENGTH


def limit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Hold back what contact holds back."""
    z = (c[1] - q[LENGTH]) / c[2]
    q[LENGTH] += c[0] * c[2] * (max(z, 0.0) + log1p(exp(-abs(z))))


EFFECT = Effect(
    name='coil_contact',
    row='M-09',
    stage='mechanical',
    equation='H + s w ln(1 + exp((Hc - H)/w))',
    source='solid length of a coil spring',
    parameters=(
        Parameter('s', 0.95, '1', 0.0, 1.0, 'share of the motion that contact stops', 'estimated: near 1'),
        Parameter(
            'Hc', 0.095, 'm', 0.02, 0.5, 'length at which the turns meet', 'estimated: 56 to 130 mm', crossed='length'
        ),
        Parameter('w', 0.002, 'm', 0.0002, 0.02, 'softness of the stop', 'estimated: unequal pitch'),
    ),
    hooks={'limit': limit},
    strength='s',
)
