"""E-06 supply lag: the source's control loop approaches its setting with a first-order delay.

    tau dv/dt = setting - v,   v the current, power or voltage that the muscle gets

Loops of bench supplies in constant current take 0.05 to 0.5 s. The channel of the source goes on showing the setting,
as the display of a supply does: that is what a recording holds.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.effects.lag import approach, fastest, lagging
from tcp_muscle_ros.muscle.electrical import CURRENT as CURRENT_SOURCE
from tcp_muscle_ros.muscle.electrical import POWER as POWER_SOURCE
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMMAND, DRIVE, KIND, SHOWN_CURRENT, SHOWN_POWER, SHOWN_VOLTAGE


def drive(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What reaches the muscle."""
    q[DRIVE] = lagging(c[0], q[COMMAND], s[0])


def rates(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The source approaches its setting."""
    ds[0] = approach(c[0], q[COMMAND], s[0])


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
    equation='tau dv/dt = setting - v',
    source='first-order control loop of the supply',
    parameters=(Parameter('tau', 0.5, 's', 0.0, 10.0, 'time constant of the source', 'estimated: 0.05 to 0.5 s'),),
    hooks={'drive': drive, 'rates': rates, 'sensor': sensor},
    strength='tau',
    states=('delivered_drive',),
    fastest_rate=lambda c, p: fastest(float(c[0])),
)
