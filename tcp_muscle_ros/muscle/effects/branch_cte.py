"""M-04 branch-dependent contraction: above Tg, the coefficient of heating differs from that of cooling.

    dz/dt = g(T) dT/dt - z |dT/dt| / 10 K,   g = 1 / (1 + exp(-(T - Tg) / 5 K)),   T_drive = T + c z

A rate-independent (Duhem) loop. The contraction leads the temperature on heating and on cooling, so the heating branch
lies on top. The loop opens above Tg and closes at the extremes, because each branch starts where the other
ended. A loop in the other direction is hysteresis or friction: c is not negative.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import ZERO_CELSIUS, Parameter
from tcp_muscle_ros.muscle.quantities import CORE_TEMPERATURE, DRIVING_TEMPERATURE, TEMPERATURE_RATE

TRAVEL = 10.0  # K, over which a reversal changes branch
EDGE = 5.0  # K, over which the loop opens


def contraction(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Ahead of the temperature, whichever way it goes."""
    q[DRIVING_TEMPERATURE] += c[0] * s[0]


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The branch follows the way of the temperature."""
    rate = q[TEMPERATURE_RATE]
    share = 1.0 / (1.0 + exp(min(-(q[CORE_TEMPERATURE] - c[1]) / EDGE, 500.0)))
    ds[0] = share * rate - s[0] * abs(rate) / TRAVEL


EFFECT = Effect(
    name='branch_cte',
    row='M-04',
    stage='mechanical',
    equation='dz/dt = g(T) dT/dt - z |dT/dt| / 10 K, T_drive = T + c z',
    source='different coefficients of heating and cooling above the glass transition',
    parameters=(
        Parameter('c', 0.10, '1', 0.0, 1.0, 'difference of the coefficients', 'estimated: 5 to 20 %'),
        Parameter(
            'Tg',
            50.0 + ZERO_CELSIUS,
            'K',
            20.0 + ZERO_CELSIUS,
            100.0 + ZERO_CELSIUS,
            'glass transition',
            'nylon 6,6, dry',
            absolute=True,
            crossed='fibre_temperature',
        ),
    ),
    hooks={'contraction': contraction, 'rates': rates},
    strength='c',
    states=('branch',),
    fastest_rate=lambda c, p: 2.0,
)
