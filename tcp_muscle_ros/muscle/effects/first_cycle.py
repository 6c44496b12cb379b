"""M-11 first cycle: a new muscle has an additional stroke in its first heating only.

    H -> H + a (1 - m),   dm/dt = max(0, e(T) - m) / tau,   e = 1 - exp(-(T - T0)/w)

Heating to T releases the share e of it with the time constant tau, unless an earlier heating released more. Published
(lonely stroke): 2 to 10 mm, released mostly between 25 and 50 degC, gone after one to three cycles.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, EXTRA
from tcp_muscle_ros.muscle.table import INDEX

_T0 = INDEX['T0']


@inner
def _free(q: Array, c: Array, p: Array) -> float:
    """The share that this temperature sets free, given time."""
    share: float = 1.0 - exp(min((p[_T0] - q[CORE_TEMPERATURE]) / c[1], 0.0))
    return share


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The length that training has not yet taken away."""
    q[EXTRA] += c[0] * (1.0 - s[0])


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What was set free stays so."""
    ds[0] = max(_free(q, c, p) - s[0], 0.0) / c[2]


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Never hotter than now, but for what earlier recordings set free."""
    s[0] = max(_free(q, c, p), c[3])


EFFECT = Effect(
    name='first_cycle',
    row='M-11',
    stage='mechanical',
    equation='dm/dt = max(0, 1 - exp(-(T - T0)/w) - m)/tau, H + a (1 - m)',
    source='lonely stroke of fresh muscles (Spinks group)',
    parameters=(
        Parameter('a', 0.005, 'm', -0.05, 0.05, 'stroke that comes only once', 'published: 2 to 10 mm'),
        Parameter('w', 15.0, 'K', 2.0, 100.0, 'heating that sets most of it free', 'published: 25 to 50 degC'),
        Parameter('tau', 2.0, 's', 0.2, 200.0, 'time that it takes', 'estimated: gone after one to three cycles'),
        Parameter(
            'start', 0.0, '1', 0.0, 1.0, 'share that was set free before the start', 'earlier runs', state=True,
        ),
    ),
    hooks={'extra': extra, 'rates': rates, 'initial': initial},
    strength='a',
    states=('set_free',),
    fastest_rate=lambda c, p: float(1.0 / c[2]),
)  # fmt: skip
