"""E-03 contact resistance: the crimps at the clamps in series with the muscle.

    constant:             V = i (R + Rc),  with the heat i^2 Rc released at the clamp, not in the muscle
    with the current:     V = i (R + Rc / (1 + b i^2)),  the heat accordingly

The resistance shown is the sum. On one muscle at one length a constant contact is nearly an exact change of R0, a_R, hA
and C: recordings of one muscle cannot show it (two lengths, or four wires, can). A contact touches in few small spots:
they heat, soften and spread, and films between them break down, so that many contacts conduct better the more current
they carry (Holm, Electric Contacts, 1967). i is the current as the source is set.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.electrical import source_current
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMMAND, KIND, RESISTANCE, SERIES

_ROUNDS = 6  # the current of a source of power or voltage depends on the contact, which depends on the current


def resistance(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Put the contacts in series."""
    contact, others = c[0], q[RESISTANCE] + q[SERIES]
    if c[1] > 0.5:
        for _ in range(_ROUNDS):
            i = source_current(q[KIND], q[COMMAND], others + contact)
            contact = c[0] / (1.0 + c[2] * i * i)
    q[SERIES] += contact


EFFECT = Effect(
    name='contact_resistance',
    row='E-03',
    stage='electrical',
    equation='V = i (R + Rc), or V = i (R + Rc / (1 + b i^2)), the heat of Rc at the clamp',
    source='series circuit; contacts that conduct better under current: Holm, Electric Contacts, 1967',
    parameters=(
        Parameter('Rc', 0.5, 'ohm', 0.0, 10.0, 'resistance of both contacts', 'estimated: 0.1 to 1 ohm'),
        Parameter(
            'falls', 0.0, '1', 0.0, 1.0, 'whether the current lowers it: 0 constant, 1 with the current',
            'a free choice',
            choices=('constant', 'with the current'), fitted=False,
        ),
        Parameter(
            'b', 25.0, '1/A^2', 3.0, 400.0, 'fall with the current: halved at 1/sqrt(b)',
            'estimated: halved at 0.1 to 0.4 A', only=('falls', 1),
        ),
    ),
    hooks={'resistance': resistance},
    strength='Rc',
    hidden='a constant resistance in series acts on one muscle nearly as other R0, a_R, hA and C do '
    '(one that falls with the current is tried); measure with four wires, or two lengths',
)  # fmt: skip
