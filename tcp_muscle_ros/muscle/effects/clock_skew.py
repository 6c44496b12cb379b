"""S-05 clock skew: the temperature comes from another clock or a slower logger, as a pure delay.

    Tm(t) = T(t - d)

The last 32 values at least d/30 apart are kept and read with straight lines between them: over edges the delay is
right to d/30, at 20 Hz, and at 100 Hz up to d = 0.3 s, to the sample.
"""

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.muscle.effects.effect import Effect
from tcp_muscle_ros.muscle.parameter import Parameter
from tcp_muscle_ros.muscle.quantities import PRESENT_TEMPERATURE, SHOWN_TEMPERATURE, TIME

KEPT = 32


def sensor(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Read the past."""
    q[PRESENT_TEMPERATURE] = q[SHOWN_TEMPERATURE]
    wanted = q[TIME] - c[0]
    later, value = q[TIME], q[SHOWN_TEMPERATURE]
    if c[0] > 0.0:
        for j in range(KEPT):
            then, kept = s[j], s[KEPT + j]
            if then <= wanted:
                value = kept + (value - kept) * (wanted - then) / (later - then)
                break
            later, value = then, kept
    q[SHOWN_TEMPERATURE] = value


def initial(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """It has long been so."""
    for j in range(KEPT):
        s[j] = q[TIME] - 1e9 * j
        s[KEPT + j] = q[PRESENT_TEMPERATURE]


def commit(q: Array, c: Array, p: Array, s: Array, ds: Array) -> None:
    """Keep the present value, and forget the oldest."""
    if q[TIME] - s[0] >= c[0] / (KEPT - 2) * (1.0 - 1e-9):
        for j in range(KEPT - 1, 0, -1):
            s[j] = s[j - 1]
            s[KEPT + j] = s[KEPT + j - 1]
        s[0] = q[TIME]
        s[KEPT] = q[PRESENT_TEMPERATURE]


EFFECT = Effect(
    name='clock_skew',
    row='S-05',
    stage='sensor',
    equation='Tm(t) = T(t - d)',
    source='unsynchronised loggers',
    parameters=(Parameter('d', 0.2, 's', 0.0, 5.0, 'delay of the temperature', 'estimated: 0.05 to 0.5 s'),),
    hooks={'sensor': sensor, 'initial': initial, 'commit': commit},
    strength='d',
    states=tuple(f'{what}_{j}' for what in ('time', 'temperature') for j in range(KEPT)),
)
