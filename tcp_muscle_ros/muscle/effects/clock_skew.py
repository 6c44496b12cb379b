"""S-05 clock skew: one channel comes from another clock or a slower logger.

    ym(t) = y(t - d - r t)

y is the temperature, the displacement, the resistance or the force; d is a delay, r the rate at which that clock falls
behind. 32 past values are kept, at least (d + r t)/30 apart, and interpolated linearly: at an edge the delay is exact
to a thirtieth of itself, or to a sample. A jump caused by the load stays a jump.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.compiled import inner
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import (
    FORCE,
    LENGTH,
    PRESENT_TEMPERATURE,
    RESISTANCE,
    SERIES,
    SHOWN_FORCE,
    SHOWN_LENGTH,
    SHOWN_RESISTANCE,
    SHOWN_TEMPERATURE,
    TIME,
)

KEPT = 32
JUMP = 1e-4  # of the length or the force
CHANNELS = ('temperature', 'displacement', 'resistance', 'force')


@inner
def _present(q: Array, c: Array) -> float:
    """What the channel would show without a delay."""
    value: float = q[PRESENT_TEMPERATURE]
    if c[2] > 2.5:
        value = q[FORCE]
    elif c[2] > 1.5:
        value = q[RESISTANCE] + q[SERIES]
    elif c[2] > 0.5:
        value = q[LENGTH]
    return value


@inner
def _apart(q: Array, c: Array) -> float:
    """How far apart values are kept, s, less what rounding takes."""
    apart: float = (c[0] + c[1] * q[TIME]) / (KEPT - 2) * (1.0 - 1e-9)
    return apart


@inner
def _push(time: float, value: float, s: Array) -> None:
    """Keep one more, and forget the oldest."""
    for j in range(KEPT - 1, 0, -1):
        s[j] = s[j - 1]
        s[KEPT + j] = s[KEPT + j - 1]
    s[0] = time
    s[KEPT] = value


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Read the past."""
    q[PRESENT_TEMPERATURE] = q[SHOWN_TEMPERATURE]
    present = _present(q, c)
    behind = c[0] + c[1] * q[TIME]
    wanted = q[TIME] - behind
    later, value = q[TIME], present
    if behind > 0.0:
        for j in range(KEPT):
            then, kept = s[j], s[KEPT + j]
            if then <= wanted:
                if later > then:
                    value = kept + (value - kept) * (wanted - then) / (later - then)
                break
            later, value = then, kept
    if c[2] > 2.5:
        q[SHOWN_FORCE] += value - present
    elif c[2] > 1.5:
        q[SHOWN_RESISTANCE] += value - present
    elif c[2] > 0.5:
        q[SHOWN_LENGTH] += value - present
    else:
        q[SHOWN_TEMPERATURE] = value


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """It has long been so."""
    for j in range(KEPT):
        s[j] = q[TIME] - 1e9 * j
        s[KEPT + j] = _present(q, c)


def begin(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep both sides of a jump of the length or the force, unless it jumps all the time."""
    if (0.5 < c[2] < 1.5 or c[2] > 2.5) and q[TIME] == s[0] and s[0] - s[1] >= _apart(q, c):
        present = _present(q, c)
        if abs(present - s[KEPT]) > JUMP * abs(s[KEPT]):
            _push(q[TIME], present, s)


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep the present value in place of the latest, or beside it where that is far enough from the one before."""
    value = _present(q, c)
    if s[0] - s[1] >= _apart(q, c) or s[0] == s[1]:
        _push(q[TIME], value, s)
    else:
        s[0], s[KEPT] = q[TIME], value


EFFECT = Effect(
    name='clock_skew',
    row='S-05',
    stage='sensor',
    equation='ym(t) = y(t - d - r t)',
    source='unsynchronised loggers',
    parameters=(
        Parameter('d', 0.2, 's', 0.0, 5.0, 'delay of one channel', 'estimated: 0.05 to 0.5 s'),
        Parameter('r', 0.0, '1', 0.0, 5e-3, 'pace at which its clock falls behind', 'quartz 1e-4, a busy logger 1e-3'),
        Parameter(
            'channel', 0.0, '1', 0.0, 3.0, 'which: 0 temperature, 1 displacement, 2 resistance, 3 force',
            'a free choice',
            choices=CHANNELS, fitted=False,
        ),
    ),
    hooks={'sensor': sensor, 'initial': initial, 'begin': begin, 'commit': commit},
    strength='d',
    late=('d', 'r', 'channel'),
    states=tuple(f'{what}_{j}' for what in ('time', 'value') for j in range(KEPT)),
)  # fmt: skip
