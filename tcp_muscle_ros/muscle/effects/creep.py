"""M-01 creep: a Kelvin unit in series (standard linear solid), quicker when hot.

    dxv/dt = (J F / k(T) - xv) / tau(T),   tau(T) = tau50 exp(-aT (T - 50 degC)),   H -> H + xv

J is the delayed share of the elastic elongation. A muscle that has long rested starts with xv = J F / k.
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


@inner
def _rate(c: Array, p: Array, temperature: float) -> float:
    """1/tau(T), 1/s; the shift factor is held beyond the model's domain, and what is quicker than 0.05 s is elastic."""
    rate: float = min(exp(c[2] * (min(temperature, p[_HOTTEST]) - _REFERENCE)) / c[1], _QUICKEST)
    return rate


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The delayed elongation."""
    q[EXTRA] += s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The delayed elongation follows its equilibrium."""
    ds[0] = (c[0] * q[FORCE] / q[STIFFNESS] - s[0]) * _rate(c, p, q[TEMPERATURE])


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest: in equilibrium with the force."""
    s[0] = c[0] * q[FORCE] / q[STIFFNESS]


EFFECT = Effect(
    name='creep',
    row='M-01',
    stage='mechanical',
    equation='dxv/dt = (J F/k - xv) / tau(T), tau = tau50 exp(-aT (T - 50 degC)), H + xv',
    source='standard linear solid with a time-temperature shift',
    parameters=(
        Parameter('J', 0.10, '1', 0.0, 0.6, 'delayed share of the elastic elongation', 'estimated: 5 to 20 %'),
        Parameter('tau50', 15.0, 's', 0.5, 600.0, 'retardation time at 50 degC', 'estimated: 5 to 60 s'),
        Parameter('aT', 0.07, '1/K', 0.0, 0.15, 'time-temperature shift', 'estimated: 0.04 to 0.1 1/K'),
    ),
    hooks={'extra': extra, 'rates': rates, 'initial': initial},
    strength='J',
    states=('delayed_elongation',),
    fastest_rate=lambda c, p: float((1.0 + c[0]) * min(exp(c[2] * (p[_HOTTEST] - _REFERENCE)) / c[1], _QUICKEST)),
)
