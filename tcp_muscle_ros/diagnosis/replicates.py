"""Repeated cycles: where the same was done twice, what was seen differs by noise, whatever the model lacks."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.diagnosis.experiment import Experiment, Imposed
from tcp_muscle_ros.diagnosis.noise import Noise, estimate
from tcp_muscle_ros.muscle.arrays import Array

_LEAST_PERIOD = 10.0  # s
_LEAST_PAIRS = 150
_STEP = 0.25  # s, at which inputs are compared


def repeats(imposed: Imposed) -> list[tuple[float, float, float]]:
    """Stretches (start, end, shift) in which the inputs at ``t`` and at ``t + shift`` are the same, s."""
    grid = np.arange(imposed.time[0], imposed.time[-1], _STEP)
    at = np.clip(np.searchsorted(imposed.time, grid + 1e-9, side='right') - 1, 0, imposed.time.size - 1)
    scale = max(float(np.ptp(imposed.drive)), 1e-12)
    drive = imposed.drive[at] / scale
    load = imposed.load[at] / max(float(np.max(imposed.load)), 1e-12)
    on = np.flatnonzero((drive[1:] > 0.1) & (drive[:-1] <= 0.1)) + 1
    if on.size < 2:
        return []
    found = []
    for first, second in pairwise(on.tolist()):
        shift = second - first
        last = min(second + shift, grid.size)
        length = last - second
        if shift * _STEP < _LEAST_PERIOD or length < 0.6 * shift:
            continue
        same = np.abs(drive[first : first + length] - drive[second:last]) < 0.02
        same &= np.abs(load[first : first + length] - load[second:last]) < 0.02
        if np.mean(same) > 0.97:
            found.append((float(grid[first]), float(grid[first + length - 1]), shift * _STEP))
    return found


def pure_error(experiments: Sequence[Experiment], residuals: Sequence[Array], channel: str) -> Noise | None:
    """The noise of a channel from its repeated cycles; None where too little was repeated.

    ``residuals`` are those of the channel, one array an experiment that observes it. Their differences between cycles
    serve, in which the slow approach to a periodic state, which the model knows, is gone as well.
    """
    noises, sizes = [], []
    owners = [e for e in experiments if channel in e.observed]
    for experiment, left in zip(owners, residuals, strict=True):
        time = experiment.observed[channel].time
        for start, end, shift in repeats(experiment.imposed):
            inside = (time >= start + 1.0) & (time <= end - 1.0)
            if np.count_nonzero(inside) < 20:
                continue
            later = np.interp(time[inside] + shift, time, left)
            wanted = time[inside] + shift
            nearest = np.abs(time[np.minimum(np.searchsorted(time, wanted), time.size - 1)] - wanted)
            kept = nearest < 2.0  # resistance may have been read in one of the cycles only
            difference = (left[inside] - later)[kept]
            if difference.size < 20:
                continue
            found = estimate(difference, 0.0)
            noises.append(found)
            sizes.append(difference.size)
    if sum(sizes) < _LEAST_PAIRS:
        return None
    # A difference of two has twice the variance; interpolation between neighbours takes a little off.
    sigma = float(np.sqrt(np.average([n.sigma**2 for n in noises], weights=sizes) / 2.0)) * 1.1
    return Noise(sigma, float(np.average([n.phi for n in noises], weights=sizes)))
