"""M-16 torsional leakage: the end turns a little under the torque of the contracting fibre, and turns are lost.

    dy/dt = r max(0, D - Dc),   H -> H + y,   D the thermal contraction

The torque of a blocked end grows with D; above that of Dc its clamp slips. One turn less lengthens the paper's coil by
(L0^2 - H0^2)/(N H0) = 5.4 mm. This is the mean of the slips, not each of them.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import EXTRA, THERMAL


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The length of the lost turns."""
    q[EXTRA] += s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """It slips above the threshold."""
    ds[0] = c[0] * max(0.0, -q[THERMAL] - c[1])


EFFECT = Effect(
    name='torsional_leakage',
    row='M-16',
    stage='mechanical',
    equation='dy/dt = r max(0, D - Dc), H + y',
    source='slipping end, a few turns',
    parameters=(
        Parameter('r', 0.001, '1/s', 0.0, 0.1, 'rate of slip', 'estimated: a tenth of a turn a cycle'),
        Parameter('Dc', 0.04, 'm', 0.0, 0.5, 'contraction whose torque the clamp holds', 'estimated'),
    ),
    hooks={'extra': extra, 'rates': rates},
    strength='r',
    latent='slips',
    threshold='Dc',
    like_slips=True,
    states=('leakage',),
)
