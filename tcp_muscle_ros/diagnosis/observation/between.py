"""What the model shows between the instants at which it is stepped: cubic, from step to step of its inputs.

Channels lose samples by themselves, so their blocks have their middles at instants of their own. A straight line
between two instants half a second apart is off by some hundredths of a kelvin just after a switch.
"""

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array, Mask, Places

_POINTS = 4
_CLOSE = 1e-3  # s: points closer than this are no help to each other


def bends(drive: Array, load: Array) -> tuple[Mask, Mask]:
    """At which instants what is shown may have a corner, and at which a jump, both shape (n,)."""
    jump = np.append(False, np.diff(load) != 0.0)
    return jump | np.append(False, np.diff(drive) != 0.0), jump


def weights(time: Array, corner: Mask, jump: Mask, at: Array) -> tuple[Places, Array]:
    """Places in ``time`` and the weights by which values there sum up to that at each instant ``at``, shape (m, 4)."""
    starts = np.append(True, corner[1:])
    begins, stretch = np.flatnonzero(starts), np.cumsum(starts) - 1
    ends = np.append(begins[1:] - jump[begins[1:]], time.size - 1)  # a corner ends what it begins, a jump does not
    inside = np.clip(at, time[0], time[-1])
    left = np.minimum(np.searchsorted(time, inside, side='right') - 1, time.size - 1)
    low, high = begins[stretch[left]], ends[stretch[left]]
    first = np.clip(left - 1, low, np.maximum(high - (_POINTS - 1), low))
    places = first[:, None] + np.arange(_POINTS)
    valid = places <= high[:, None]
    places = np.minimum(places, high[:, None])
    points = time[places]
    apart = points[:, :, None] - points[:, None, :]
    both = valid[:, :, None] & valid[:, None, :] & ~np.eye(_POINTS, dtype=bool)
    close = np.any(both & (np.abs(apart) < _CLOSE), axis=(1, 2))
    with np.errstate(divide='ignore', invalid='ignore'):
        factors = np.where(both, (inside[:, None, None] - points[:, None, :]) / apart, 1.0)
    found = np.where(valid, np.prod(factors, axis=2), 0.0)
    if close.any():  # there, a straight line
        right = np.minimum(left[close] + 1, time.size - 1)
        span = np.maximum(time[right] - time[left[close]], 1e-12)
        share = np.clip((inside[close] - time[left[close]]) / span, 0.0, 1.0)
        places[close] = np.stack([left[close], right, right, right], axis=1)
        found[close] = np.stack([1.0 - share, share, 0.0 * share, 0.0 * share], axis=1)
    return places, found
