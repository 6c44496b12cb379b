"""Current gain: the ammeter is off, and with it what the muscle really gets for a recorded current or power.

    i = g i_shown,   R_shown = V / i_shown = g R

A recorded power is V i_shown, so the muscle gets g times as much; a recorded voltage is right.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.electrical import VOLTAGE
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMMAND, KIND, SHOWN_CURRENT, SHOWN_POWER, SHOWN_RESISTANCE


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What is set by the wrong ammeter."""
    if q[KIND] != VOLTAGE:
        q[COMMAND] *= c[0]


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What is read from it."""
    q[SHOWN_CURRENT] /= c[0]
    q[SHOWN_POWER] /= c[0]
    q[SHOWN_RESISTANCE] *= c[0]


EFFECT = Effect(
    name='current_gain',
    row='',
    stage='sensor',
    equation='i = g i_shown, R_shown = g R',
    source='tolerance of shunts and displays',
    parameters=(Parameter('g', 1.02, '1', 0.5, 2.0, 'true over shown current', 'estimated: 1 to 3 %'),),
    hooks={'surroundings': surroundings, 'sensor': sensor},
    strength='g',
    none=1.0,
)
