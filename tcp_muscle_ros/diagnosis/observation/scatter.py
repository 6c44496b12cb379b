"""How far single readings scatter, whatever a model says: from second differences, and from the steps of a reading."""

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array, Mask

_ENOUGH = 50  # bends, by which a noise is known to a tenth or so


def white_sigma(value: Array, moving: Mask | None = None) -> float:
    """The quick part of the noise, from second differences, robust against edges; quantisation included.

    A channel whose second differences mostly vanish is quantised: its step over sqrt(12) is the least noise. Samples
    while something is ``moving``, as a weight that swings, tell nothing where enough others do.
    """
    if value.size < 4:
        return 0.0
    bends = np.diff(value, 2)
    if moving is not None:
        still = ~(moving[2:] | moving[1:-1] | moving[:-2])
        bends = bends[still] if np.count_nonzero(still) >= _ENOUGH else bends
    return max(sigma_of_bends(bends), quantum(value) / float(np.sqrt(12.0)))


def sigma_of_bends(second: Array) -> float:
    """Standard deviation of the white noise that has these second differences, robust against edges."""
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6.0))


def quantum(value: Array) -> float:
    """The smallest step between different values, 0 where values repeat too seldom to be quantised."""
    levels = np.unique(value)
    if value.size < 20 or levels.size < 2 or levels.size > 0.5 * value.size:
        return 0.0
    steps = np.diff(levels)
    real = steps[steps > 1e-9 * float(np.ptp(levels))]
    return float(np.min(real)) if real.size else 0.0
