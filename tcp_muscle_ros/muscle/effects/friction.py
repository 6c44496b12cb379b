"""M-14 friction: a guide holds the end until the force on it exceeds Coulomb's.

    H -> play of half width Ff/k about the equilibrium length (Ff/(k + k_spring) against a spring)

A blocked end does not move and feels none.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMPLIANCE, EQUILIBRIUM_LENGTH, HELD, LENGTH, STIFFNESS


def position(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Stay where it was unless that is out of the play's reach."""
    rate = q[STIFFNESS]
    if q[HELD] > 0.0:
        rate += 1.0 / q[COMPLIANCE]
    half = c[0] / rate
    q[LENGTH] = min(max(s[0], q[LENGTH] - half), q[LENGTH] + half)


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """In the middle of the play."""
    s[0] = q[EQUILIBRIUM_LENGTH]


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The end has moved."""
    s[0] = q[LENGTH]


EFFECT = Effect(
    name='friction',
    row='M-14',
    stage='mechanical',
    equation='play of half width Ff/k in H',
    source="Coulomb's law of friction",
    parameters=(Parameter('Ff', 0.01, 'N', 0.0, 0.5, 'friction of the guide', 'estimated: 2 to 20 mN'),),
    hooks={'position': position, 'initial': initial, 'commit': commit},
    strength='Ff',
    states=('end_length',),
)
