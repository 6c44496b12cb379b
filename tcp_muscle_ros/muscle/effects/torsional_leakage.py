"""M-16 torsional leakage: the end turns a little under the torque of the contracting fibre, and turns are lost.

    dy/dt = r max(0, D + x - Dc) - y/tau,   H -> H + y

The torque of a blocked end grows with what heat shortens the muscle by (D, the thermal contraction) and with what the
load stretches it by (x, the elastic elongation). Above that of Dc its clamp slips, for good, or it gives way and turns
back within tau once the torque has gone (glue, rubber, a long lead). One turn less lengthens the paper's coil by
(L0^2 - H0^2)/(N H0) = 5.4 mm. This is the mean of the slips, not each of them.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import ELASTIC, EXTRA, THERMAL


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The length of the lost turns."""
    q[EXTRA] += s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """It slips above the threshold, and turns back."""
    ds[0] = c[0] * max(0.0, q[ELASTIC] - q[THERMAL] - c[1]) - s[0] / c[2]


EFFECT = Effect(
    name='torsional_leakage',
    row='M-16',
    stage='mechanical',
    equation='dy/dt = r max(0, D + x - Dc) - y/tau, H + y',
    source='slipping end, a few turns',
    parameters=(
        Parameter('r', 0.001, '1/s', 0.0, 0.1, 'rate of slip', 'estimated: a tenth of a turn a cycle'),
        Parameter('Dc', 0.065, 'm', 0.0, 0.5, 'contraction and elongation whose torque the clamp holds', 'estimated'),
        Parameter('tau', 1e5, 's', 10.0, 1e5, 'time in which it turns back', 'a clamp that slips: hardly ever'),
    ),
    hooks={'extra': extra, 'rates': rates},
    strength='r',
    latent='slips',
    threshold='Dc',
    like_slips=True,
    states=('leakage',),
)
