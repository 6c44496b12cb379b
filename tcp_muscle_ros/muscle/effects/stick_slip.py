"""Stick-slip: the end rests until the force on it exceeds static friction, then jumps; the instants are random.

    |k (Hs - H)| <= Fi: the end rests at H;   beyond: it jumps to where |k (Hs - H)| = r Fb
    Fi = Fb (r + (1 - r) exp(s n - s^2/2)),   n standard normal, drawn anew for each rest

Hs is the length at which forces balance, or to which inertia and friction bring the end. Jumps are (Fi - r Fb)/k, on
average (1 - r) Fb/k; the first after a reversal needs the force of both directions. The random numbers follow from the
seed and the number of jumps so far, so the same seed and inputs give the same motion. A spring at the end adds to k; a
blocked end does not move.
"""

from math import cos, exp, log, pi, sqrt

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import COMPLIANCE, EQUILIBRIUM_LENGTH, HELD, LENGTH, STIFFNESS, UNSTUCK_LENGTH

# SplitMix64 (Steele et al. 2014): the mixed product of a counter, with no state but the counter.
_GOLDEN, _FIRST, _SECOND = (np.uint64(n) for n in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB))
_S30, _S27, _S31, _S11 = (np.uint64(n) for n in (30, 27, 31, 11))
_UNIT = 2.0**-53
_MOST = 1000  # jumps in a step; a friction that small holds nothing


@inner
def _uniform(seed: int, count: int) -> float:
    """Between 0 and 1, of this seed and count."""
    z = (np.uint64(seed) * _FIRST) ^ (np.uint64(count + 1) * _GOLDEN)
    z = (z ^ (z >> _S30)) * _FIRST
    z = (z ^ (z >> _S27)) * _SECOND
    z = z ^ (z >> _S31)
    value: float = (float(z >> _S11) + 0.5) * _UNIT
    return value


@inner
def _breakaway(c: Array, jumps: float) -> float:
    """The pull (N) that ends the rest after so many jumps."""
    seed, count = int(c[3]), 2 * int(jumps)
    normal = sqrt(-2.0 * log(_uniform(seed, count))) * cos(2.0 * pi * _uniform(seed, count + 1))
    value: float = c[0] * (c[1] + (1.0 - c[1]) * exp(c[2] * normal - 0.5 * c[2] * c[2]))
    return value


@inner
def _rested(q: Array, c: Array, s: Array) -> tuple[float, float, float]:
    """Where the end rests under the present pull (m), what would break it away (N), and after how many jumps.

    Of several jumps within a step each begins where it would have: the step does not change their sizes.
    """
    rate = q[STIFFNESS]
    if q[HELD] > 0.0:
        rate += 1.0 / q[COMPLIANCE]
    end, held, jumps = s[0], s[1], s[2]
    sliding = c[0] * c[1]
    for _ in range(_MOST):
        pull = rate * (q[UNSTUCK_LENGTH] - end)
        if abs(pull) <= held:
            return end, held, jumps
        end += (held - sliding) / rate if pull > 0.0 else (sliding - held) / rate
        jumps += 1.0
        held = _breakaway(c, jumps)
    return q[UNSTUCK_LENGTH], held, jumps


def position(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Rest, or jump to where sliding friction stops it."""
    q[UNSTUCK_LENGTH] = q[LENGTH]  # ``commit`` asks again, and LENGTH is then where the end rests
    if c[0] > 0.0:
        q[LENGTH] = _rested(q, c, s)[0]


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """At rest where forces balance."""
    s[0], s[1], s[2] = q[EQUILIBRIUM_LENGTH], _breakaway(c, 0.0), 0.0


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """After a jump it rests anew, as firmly as chance wills."""
    if c[0] > 0.0 and (q[HELD] == 0.0 or q[COMPLIANCE] > 0.0):
        s[0], s[1], s[2] = _rested(q, c, s)


EFFECT = Effect(
    name='stick_slip',
    row='',
    stage='mechanical',
    equation='rests while |k (Hs - H)| <= Fi, then jumps to |k (Hs - H)| = r Fb',
    source="Coulomb's law of friction with a larger force at rest, and a spread of it",
    parameters=(
        Parameter('Fb', 0.03, 'N', 0.0, 5.0, 'mean pull that breaks it away', 'jumps of hundredths of the stroke'),
        Parameter('r', 0.5, '1', 0.0, 0.95, 'sliding friction over that', 'dry pairs: 0.5 to 0.9'),
        Parameter('s', 0.5, '1', 0.0, 1.5, 'spread of the logarithm of what it breaks away by', 'estimated'),
        Parameter('seed', 0.0, '1', 0.0, 2.0**31, 'of the draws, a whole number', 'a free choice', fitted=False),
    ),
    hooks={'position': position, 'initial': initial, 'commit': commit},
    strength='Fb',
    states=('end_length', 'held_by', 'jumps'),
    listed=False,
    chance=True,
)
