"""M-11 first cycle: a fresh muscle gives a stroke that it gives only once.

    H -> H + a exp(-(Tmax - T0)/w),   Tmax the largest temperature so far

Published (lonely stroke): 2 to 10 mm, set free mostly between 25 and 50 degC, gone after one to three cycles.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, EXTRA
from tcp_muscle_ros.muscle.table import INDEX

_T0 = INDEX['T0']


def extra(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The length that training has not yet taken away."""
    q[EXTRA] += c[0] * exp(min((p[_T0] - max(s[0], q[CORE_TEMPERATURE])) / c[1], 0.0))


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Never hotter than now."""
    s[0] = q[CORE_TEMPERATURE]


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Remember the largest temperature."""
    s[0] = max(s[0], q[CORE_TEMPERATURE])


EFFECT = Effect(
    name='first_cycle',
    row='M-11',
    stage='mechanical',
    equation='H + a exp(-(Tmax - T0)/w)',
    source='lonely stroke of fresh muscles (Spinks group)',
    parameters=(
        Parameter('a', 0.005, 'm', -0.05, 0.05, 'stroke that comes only once', 'published: 2 to 10 mm'),
        Parameter('w', 15.0, 'K', 2.0, 100.0, 'heating that sets most of it free', 'published: 25 to 50 degC'),
    ),
    hooks={'extra': extra, 'initial': initial, 'commit': commit},
    strength='a',
    states=('largest_temperature',),
)
