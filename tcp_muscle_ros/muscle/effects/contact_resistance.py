"""E-03 contact resistance: the crimps at the clamps in series with the muscle.

    V = i (R + Rc),  with the heat i^2 Rc released at the clamp, not in the muscle

The resistance shown is R + Rc. On one muscle at one length this is an exact change of R0, a_R, hA and C: recordings
of one muscle cannot show it (two lengths, or four wires, can).
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import SERIES


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Put the contacts in series."""
    q[SERIES] += c[0]


EFFECT = Effect(
    name='contact_resistance',
    row='E-03',
    stage='electrical',
    equation='V = i (R + Rc), heat i^2 Rc at the clamp',
    source='series circuit',
    parameters=(Parameter('Rc', 0.5, 'ohm', 0.0, 10.0, 'resistance of both contacts', 'estimated: 0.1 to 1 ohm'),),
    hooks={'resistance': resistance},
    strength='Rc',
    # Present in no recording of one muscle: an exact null direction of R0, a_R, hA and C (see docs/effects.md).
    hidden='a constant resistance in series acts on one muscle exactly as other R0, a_R, hA and C do; '
    'measure with four wires, or two lengths',
)
