"""M-14 friction: a guide holds the end until the force on it exceeds Coulomb's.

    k (H - Hs) + f = 0,   df = (Ff - f sign(dH)) |dH| / d

f opposes the motion (N) and builds up over the distance d, by which asperities yield before they slip (Dahl 1968). For
d -> 0 the end stays within Ff/k of its equilibrium length Hs (Ff/(k + k_spring) against a spring). A blocked end does
not move, so no friction acts.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMPLIANCE, EQUILIBRIUM_LENGTH, HELD, LENGTH, STIFFNESS

_ROUNDS, _NEAR = 50, 1e-12  # of Newton's method, which comes from one side; m


@inner
def _opposing(c: Array, before: float, way: float) -> float:
    """The friction (N) after a way (m), shortening or lengthening, from what it was before."""
    limit = c[0] if way > 0.0 else -c[0]
    now: float = limit + (before - limit) * exp(-abs(way) / c[1])
    return now


def position(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Move until friction balances what pulls; where it has slipped for good, that is at the edge of the play."""
    rate = q[STIFFNESS]
    if q[HELD] > 0.0:
        rate += 1.0 / q[COMPLIANCE]
    wanted, start = q[LENGTH], s[0]
    pull = rate * (wanted - start) - s[1]
    if c[0] <= 0.0:
        return
    sign = 1.0 if pull > 0.0 else -1.0
    # Friction is at most Ff: no nearer than this, or than where it was.
    way = max(0.0, sign * (wanted - start) - c[0] / rate)
    for _ in range(_ROUNDS):
        friction = sign * _opposing(c, s[1], sign * way) if way > 0.0 else sign * s[1]
        short = (rate * (sign * (wanted - start) - way) - friction) / (rate + max(c[0] - friction, 0.0) / c[1])
        way += max(short, 0.0)
        if short < _NEAR:
            break
    q[LENGTH] = start + sign * way


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Free of friction."""
    s[0], s[1] = q[EQUILIBRIUM_LENGTH], 0.0


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The end has moved."""
    s[1] = _opposing(c, s[1], q[LENGTH] - s[0])
    s[0] = q[LENGTH]


EFFECT = Effect(
    name='friction',
    row='M-14',
    stage='mechanical',
    equation='k (H - Hs) + f = 0, df = (Ff - f sign(dH)) |dH| / d',
    source="Coulomb's law of friction, with the way before it slips of Dahl 1968",
    parameters=(
        Parameter('Ff', 0.01, 'N', 0.0, 0.5, 'friction of the guide', 'estimated: 2 to 20 mN'),
        Parameter('d', 5e-5, 'm', 1e-6, 5e-3, 'way over which it builds up', 'estimated: hundredths of a millimetre'),
    ),
    hooks={'position': position, 'initial': initial, 'commit': commit},
    strength='Ff',
    sticks=True,
    states=('end_length', 'friction'),
)
