"""Current gain: the ammeter is wrong, so the muscle gets another current or power than was recorded.

    i = g (i_shown - z),   R_shown = V / i_shown, or R where an ohmmeter measures it apart

z is the offset of what it shows. A recorded power is V i_shown, where V follows from the resistance of equation 4; a
recorded voltage is right. Where the ammeter shows zero, no current flows.
"""

from math import sqrt

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.electrical import CURRENT as CURRENT_SOURCE
from tcp_muscle_ros.muscle.electrical import POWER as POWER_SOURCE
from tcp_muscle_ros.muscle.electrical import resistance_at
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import (
    COMMAND,
    CURRENT,
    KIND,
    SHOWN_CURRENT,
    SHOWN_POWER,
    SHOWN_RESISTANCE,
    TEMPERATURE,
)

_TOO_FAR = 3.0  # times, either way, that a shown current may be off the true one


@inner
def _offset_root(q: Array, c: Array, p: Array) -> float:
    """z sqrt(R): with sqrt(P) it makes the power that the zero adds to what is shown."""
    value: float = c[1] * sqrt(resistance_at(p, q[TEMPERATURE]))
    return value


def surroundings(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What is set by the wrong ammeter."""
    if q[COMMAND] != 0.0:
        if q[KIND] == CURRENT_SOURCE:
            flows = c[0] * (q[COMMAND] - c[1])
            q[COMMAND] = flows if flows * q[COMMAND] > 0.0 else 0.0
        elif q[KIND] == POWER_SOURCE:
            offset = _offset_root(q, c, p)
            root = 0.5 * c[0] * (sqrt(offset * offset + 4.0 * q[COMMAND] / c[0]) - offset)
            q[COMMAND] = root * root


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """What is read from it."""
    flows = q[CURRENT]
    shown = flows / c[0] + c[1]
    if c[2] < 0.5:  # else another instrument shows the resistance
        # Of a current that is as small as the zero nobody computes one.
        sensible = shown * flows > 0.0 and _TOO_FAR > flows / shown > 1.0 / _TOO_FAR
        q[SHOWN_RESISTANCE] *= flows / shown if sensible else c[0]
    if q[SHOWN_CURRENT] != 0.0:
        q[SHOWN_CURRENT] = q[SHOWN_CURRENT] / c[0] + c[1]
    if q[SHOWN_POWER] > 0.0:
        q[SHOWN_POWER] = q[SHOWN_POWER] / c[0] + sqrt(q[SHOWN_POWER]) * _offset_root(q, c, p)


EFFECT = Effect(
    name='current_gain',
    row='',
    stage='sensor',
    equation='i = g (i_shown - z), R_shown = V / i_shown (an ohmmeter: R)',
    source='tolerance of shunts and displays',
    parameters=(
        Parameter('g', 1.02, '1', 0.5, 2.0, 'slope of true over shown current', 'estimated: 1 to 3 %'),
        Parameter('z', 0.0, 'A', -5e-3, 5e-3, 'offset of what is shown', 'estimated: 0.1 to 1 % of a range of 0.5 A'),
        Parameter(
            'ohms', 0.0, '1', 0.0, 1.0, 'how the resistance is measured: 0 by this ammeter, 1 apart', 'a free choice',
            choices=('by this ammeter', 'apart'), fitted=False,
        ),
    ),
    hooks={'surroundings': surroundings, 'sensor': sensor},
    strength='g',
    none=1.0,
)  # fmt: skip
