"""E-06 supply lag: the source's control loop approaches its setting with a delay.

    q tau^2 d2v/dt2 + tau dv/dt = setting - v,   v the current, power or voltage that the muscle gets

Control loops of bench supplies in constant current take 0.05 to 0.5 s; tau is the mean delay. q = 0 is a loop of first
order, q = 1/4 one with an equally slow filter (two equal poles), q = 0.6 one that overshoots. The recorded channel
shows the setting, as the display of a supply does.
"""

from math import sqrt

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.effects.lag import SHORTEST, approach, fastest, lagging
from tcp_muscle_ros.muscle.electrical import CURRENT as CURRENT_SOURCE
from tcp_muscle_ros.muscle.electrical import POWER as POWER_SOURCE
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMMAND, DRIVE, KIND, SHOWN_CURRENT, SHOWN_POWER, SHOWN_VOLTAGE

_EQUAL_POLES, _OVERSHOOTING = 0.25, 0.6  # q of the loops of second order


def drive(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What reaches the muscle. A loop that overshoots takes no power back."""
    delivered = lagging(c[0], q[COMMAND], s[0])
    q[DRIVE] = max(delivered, 0.0) if q[KIND] == POWER_SOURCE else delivered


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The source approaches its setting."""
    if c[1] < 0.5:
        ds[0] = approach(c[0], q[COMMAND], s[0])
        ds[1] = 0.0
    else:
        tau = max(c[0], SHORTEST)
        inertia = _EQUAL_POLES if c[1] < 1.5 else _OVERSHOOTING
        ds[0] = s[1]
        ds[1] = (q[COMMAND] - s[0] - tau * s[1]) / (inertia * tau * tau)


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The display shows the setting."""
    if q[KIND] == CURRENT_SOURCE:
        q[SHOWN_CURRENT] = q[COMMAND]
    elif q[KIND] == POWER_SOURCE:
        q[SHOWN_POWER] = q[COMMAND]
    else:
        q[SHOWN_VOLTAGE] = q[COMMAND]


EFFECT = Effect(
    name='supply_lag',
    row='E-06',
    stage='electrical',
    equation='q tau^2 d2v/dt2 + tau dv/dt = setting - v',
    source='control loop of the supply, of first or second order',
    parameters=(
        Parameter('tau', 0.5, 's', 0.0, 10.0, 'mean delay of the source', 'estimated: 0.05 to 0.5 s'),
        Parameter(
            'loop', 0.0, '1', 0.0, 2.0, 'how it gets there: 0 first order, 1 two equal poles, 2 overshooting',
            'a free choice',
            choices=('first order', 'two equal poles', 'overshooting'), fitted=False,
        ),
    ),
    hooks={'drive': drive, 'rates': rates, 'sensor': sensor},
    strength='tau',
    delay=lambda muscle: muscle['supply_lag.tau'],
    states=('delivered_drive', 'its_rate'),
    fastest_rate=lambda c, p: fastest(float(c[0])) * (1.0 if c[1] < 0.5 else 1.0 / sqrt(_EQUAL_POLES)),
)  # fmt: skip
