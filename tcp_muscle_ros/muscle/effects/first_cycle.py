"""M-11 first cycle: a new muscle has an additional stroke in its first heating only.

    H -> H + a (1 - m),   dm/dt = max(0, e(T) - m) / tau,   e = 1 - exp(-(T - T0)/w)

Heating to T releases the share e of it with the time constant tau, unless an earlier heating released more. Published
(lonely stroke): 2 to 10 mm, released mostly between 25 and 50 degC, gone after one to three cycles. In several
recordings either each is of a new muscle (or of one that was stretched anew), or it goes on: what a recording set free
at its hottest is not there in the next.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, EXTRA
from tcp_muscle_ros.muscle.table import INDEX

_T0 = INDEX['T0']


@inner
def _free(temperature: float, c: Array, p: Array) -> float:
    """The share that a temperature sets free, given time."""
    share: float = 1.0 - exp(min((p[_T0] - temperature) / c[1], 0.0))
    return share


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The length that training has not yet taken away."""
    q[EXTRA] += c[0] * (1.0 - s[0])


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What was set free stays so."""
    ds[0] = max(_free(q[CORE_TEMPERATURE], c, p) - s[0], 0.0) / c[2]


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Never hotter than now, but for what earlier recordings set free."""
    s[0] = max(_free(q[CORE_TEMPERATURE], c, p), c[3])
    if c[5] > 0.5:
        s[0] = max(s[0], _free(c[4], c, p))


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
        Parameter(
            'hottest', 23.0 + ZERO_CELSIUS, 'K', 250.0, 1000.0,
            'hottest before (with course = 1)', 'a new muscle; earlier recordings',
            absolute=True, fitted=False,
        ),
        Parameter(
            'course', 0.0, '1', 0.0, 1.0, 'of a recording after others: 0 anew, 1 goes on', 'a free choice',
            choices=('anew', 'goes on'), fitted=False,
        ),
    ),
    hooks={'extra': extra, 'rates': rates, 'initial': initial},
    strength='a',
    age='hottest',
    states=('set_free',),
    fastest_rate=lambda c, p: float(1.0 / c[2]),
)  # fmt: skip
