"""M-14 friction: a guide or a pulley holds the end until the force on it exceeds Coulomb's.

    k (H - Hs) + f = 0,   df = (Ff - f sign(dH)) dH / d

f opposes the motion (N) and builds up over the distance d, by which asperities yield before they slip (Dahl 1968). For
d -> 0 the end stays within Ff/k of its equilibrium length Hs (Ff/(k + k_spring) against a spring). A blocked end does
not move, so no friction acts.

What presses on a guide is the same under any load, what presses on a pulley or a Bowden cable is the force that goes
over it: there Ff is as large under 0.5 N, and in proportion to the force.
"""

from math import exp

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMPLIANCE, EQUILIBRIUM_LENGTH, FORCE, HELD, LENGTH, STIFFNESS

_ROUNDS, _NEAR = 50, 1e-12  # of Newton's method, which comes from one side; m
_FORCE = 0.5  # N


@inner
def _most(c: Array, q: Array) -> float:
    """What it holds at most, N. The force over a pulley is that where the end balances, before it is held back."""
    if c[2] < 0.5:
        return c[0]  # type: ignore[no-any-return]
    over = q[FORCE]
    if q[HELD] > 0.0 and q[COMPLIANCE] > 0.0:
        over += (q[LENGTH] - q[EQUILIBRIUM_LENGTH]) / q[COMPLIANCE]
    most: float = c[0] * abs(over) / _FORCE
    return most


@inner
def _opposing(c: Array, most: float, before: float, way: float) -> float:
    """The friction (N), at most so much, after a way (m), shortening or lengthening, from what it was before."""
    limit = most if way > 0.0 else -most
    now: float = limit + (before - limit) * exp(-abs(way) / c[1])
    return now


def position(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Move until friction balances what pulls; where it has slipped for good, that is at the edge of the play."""
    rate = q[STIFFNESS]
    if q[HELD] > 0.0:
        rate += 1.0 / q[COMPLIANCE]
    most = _most(c, q)
    wanted, start, before = q[LENGTH], s[0], min(max(s[1], -most), most)
    pull = rate * (wanted - start) - before
    if most <= 0.0:
        return
    sign = 1.0 if pull > 0.0 else -1.0
    # Friction is at most this: no nearer, or than where it was.
    way = max(0.0, sign * (wanted - start) - most / rate)
    for _ in range(_ROUNDS):
        friction = sign * _opposing(c, most, before, sign * way) if way > 0.0 else sign * before
        short = (rate * (sign * (wanted - start) - way) - friction) / (rate + max(most - friction, 0.0) / c[1])
        way += max(short, 0.0)
        if short < _NEAR:
            break
    q[LENGTH] = start + sign * way


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Free of friction."""
    s[0], s[1] = q[EQUILIBRIUM_LENGTH], 0.0


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """The end has moved."""
    most = _most(c, q)
    s[1] = _opposing(c, most, min(max(s[1], -most), most), q[LENGTH] - s[0])
    s[0] = q[LENGTH]


EFFECT = Effect(
    name='friction',
    row='M-14',
    stage='mechanical',
    equation='k (H - Hs) + f = 0, df = (Ff - f sign(dH)) dH / d',
    source="Coulomb's law of friction, with the way before it slips of Dahl 1968",
    parameters=(
        Parameter('Ff', 0.01, 'N', 0.0, 0.5, 'friction of the guide; of a pulley, at 0.5 N', 'estimated: 2 to 20 mN'),
        Parameter('d', 5e-5, 'm', 1e-6, 5e-3, 'way over which it builds up', 'estimated: hundredths of a millimetre'),
        Parameter(
            'law', 0.0, '1', 0.0, 1.0, 'what rubs: 0 a guide, alike under any load, 1 a pulley, in proportion to it',
            'a free choice', choices=('a guide', 'a pulley'), fitted=False, told_by='load',
        ),
    ),
    hooks={'position': position, 'initial': initial, 'commit': commit},
    strength='Ff',
    sticks=True,
    states=('end_length', 'friction'),
)  # fmt: skip
