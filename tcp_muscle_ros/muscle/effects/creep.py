"""M-01 creep: Kelvin units in series, quicker when hot.

    dxj/dt = (Jj F / k(T) - xj) / tauj(T),   tau(T) = tau50 exp(-aT (T - 50 degC)),   H -> H + sum xj

J is the delayed share of the elastic elongation: by one unit (standard linear solid), or by four, whose times lie a
decade apart around tau, and whose shares grow with the cube root of their times. Polymers delay over many decades:
their creep goes with a small power of time (Andrade 1910: a third). A muscle that has long rested is in equilibrium.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import EXTRA, FORCE, STIFFNESS, TEMPERATURE
from tcp_muscle_ros.muscle.table import INDEX

_REFERENCE = ZERO_CELSIUS + 50.0
_HOTTEST = INDEX['hottest']
_QUICKEST = 20.0  # 1/s
_UNITS, _APART = 4, 10.0
_FIRST = _APART ** (0.5 * (_UNITS - 1))  # times quicker than the middle
_MORE = _APART ** (1.0 / 3.0)  # that a unit gives more than the next quicker one
_LEAST = (_MORE - 1.0) / (_MORE**_UNITS - 1.0)  # of all, that the quickest gives


@inner
def _units(c: Array) -> int:
    """How many."""
    return 1 if c[3] < 0.5 else _UNITS


@inner
def _share(c: Array, q: Array) -> float:
    """That the quickest unit tends to, m."""
    share: float = c[0] * q[FORCE] / q[STIFFNESS] * (1.0 if _units(c) == 1 else _LEAST)
    return share


@inner
def _rate(c: Array, p: Array, temperature: float) -> float:
    """1/tau(T) of the quickest unit, 1/s; the shift factor is held beyond the model's domain."""
    rate: float = exp(c[2] * (min(temperature, p[_HOTTEST]) - _REFERENCE)) / c[1] * (1.0 if _units(c) == 1 else _FIRST)
    return rate


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The delayed elongation."""
    for j in range(_units(c)):
        q[EXTRA] += s[j]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The delayed elongations follow their equilibrium; what is quicker than 0.05 s is elastic."""
    share, rate = _share(c, q), _rate(c, p, q[TEMPERATURE])
    for j in range(_units(c)):
        ds[j] = (share - s[j]) * min(rate, _QUICKEST)
        rate /= _APART
        share *= _MORE


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest: in equilibrium with the force. The slowest may still be on its way there."""
    share = _share(c, q)
    for j in range(_units(c)):
        s[j] = share
        share *= _MORE
    s[_units(c) - 1] *= 1.0 + c[4]


def fastest_rate(c: Array, p: Array) -> float:
    """Of the quickest unit, 1/s."""
    first = 1.0 if c[3] < 0.5 else _FIRST
    quickest = first * exp(c[2] * (p[_HOTTEST] - _REFERENCE)) / c[1]
    return float((1.0 + c[0]) * min(quickest, _QUICKEST))


EFFECT = Effect(
    name='creep',
    row='M-01',
    stage='mechanical',
    equation='dxj/dt = (Jj F/k - xj) / tauj(T), tau = tau50 exp(-aT (T - 50 degC)), H + sum xj',
    source='standard linear solid with a time-temperature shift; Andrade 1910',
    parameters=(
        Parameter('J', 0.10, '1', 0.0, 0.6, 'delayed share of the elastic elongation', 'estimated: 5 to 20 %'),
        Parameter('tau50', 15.0, 's', 0.5, 600.0, 'retardation time at 50 degC', 'estimated: 5 to 60 s'),
        Parameter('aT', 0.07, '1/K', 0.0, 0.15, 'time-temperature shift', 'estimated: 0.04 to 0.1 1/K'),
        Parameter(
            'law', 0.0, '1', 0.0, 1.0, 'how many times it is delayed by: 0 one, 1 four, a decade apart around tau50',
            'a free choice', choices=('one time', 'many times'), fitted=False,
        ),
        Parameter(
            'start', 0.0, '1', -1.0, 1.0, 'how far from equilibrium the slowest begins: -1 just loaded, 0 at rest',
            'rest since the last run', state=True,
        ),
    ),
    hooks={'extra': extra, 'rates': rates, 'initial': initial},
    strength='J',
    states=('delayed_elongation_1', 'delayed_elongation_2', 'delayed_elongation_3', 'delayed_elongation_4'),
    fastest_rate=fastest_rate,
)  # fmt: skip
