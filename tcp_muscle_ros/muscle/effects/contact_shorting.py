"""E-02 contact shorting: coils that touch short part of the winding, near full contraction only.

    R -> R (1 - s / (1 + exp((H - Hc) / w)))

Hc is the length at which neighbouring coils meet, N d = 84 to 90 mm for the paper's 280 turns
of a fibre that is 0.30 to 0.32 mm thick in effect (of its stated 0.2 mm: 56 mm).
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import LENGTH, RESISTANCE


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Lower the resistance by the shorted share."""
    q[RESISTANCE] *= 1.0 - c[0] / (1.0 + exp(min((q[LENGTH] - c[1]) / c[2], 500.0)))


EFFECT = Effect(
    name='contact_shorting',
    row='E-02',
    stage='electrical',
    equation='R (1 - s / (1 + exp((H - Hc) / w)))',
    source='coils in contact, logistic in length',
    parameters=(
        Parameter('s', 0.10, '1', 0.0, 0.6, 'share of the resistance that contact shorts', 'estimated: 2 to 30 %'),
        Parameter(
            'Hc', 0.087, 'm', 0.02, 0.5, 'length at which coils meet', 'estimated: N d = 84 to 90 mm', crossed='length'
        ),
        Parameter('w', 0.005, 'm', 0.0005, 0.05, 'spread of that length along the muscle', 'estimated: 2 to 8 mm'),
    ),
    hooks={'resistance': resistance},
    strength='s',
)
