"""Repeated cycles and recordings: what was done twice was seen to differ by noise, whatever the model lacks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from tcp_muscle_ros.diagnosis.noise.noise import Noise, estimate
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Imposed
from tcp_muscle_ros.muscle.arrays import Array

# The recordings in which the same was done, the second perhaps the first; (start, end, shift), s, as below.
Twice = tuple[int, int, tuple[float, float, float]]

_LEAST_PERIOD = 10.0  # s
_LEAST_PAIRS = 150
_STEP = 0.25  # s, at which inputs are compared


def repeats(imposed: Imposed) -> list[tuple[float, float, float]]:
    """Stretches (start, end, shift) in which the inputs at ``t`` and at ``t + shift`` are the same, s."""
    grid, drive, load = _inputs(imposed)
    on = _rises(drive)
    if on.size < 2:
        return []
    found = []
    for first, second in pairwise(on.tolist()):
        shift = second - first
        last = min(second + shift, grid.size)
        length = last - second
        if shift * _STEP < _LEAST_PERIOD or length < 0.6 * shift:
            continue
        if _alike(drive[first : first + length], drive[second:last], load[first : first + length], load[second:last]):
            found.append((float(grid[first]), float(grid[first + length - 1]), shift * _STEP))
    return found


def copies(one: Imposed, other: Imposed) -> tuple[float, float, float] | None:
    """The stretch (start, end) of one recording, and the shift, such that the inputs of another at ``t + shift`` are
    the same as its own at ``t``, s; None where they are not."""
    if one.kind != other.kind:
        return None
    (grid, drive, load), (their_grid, their_drive, their_load) = _inputs(one, other), _inputs(other, one)
    mine, theirs = _rises(drive)[:1], _rises(their_drive)[:1]
    if not mine.size or not theirs.size:
        return None
    first, second = int(mine[0]), int(theirs[0])
    length = min(drive.size - first, their_drive.size - second)
    here, there = slice(first, first + length), slice(second, second + length)
    if length * _STEP < _LEAST_PERIOD or not _alike(drive[here], their_drive[there], load[here], their_load[there]):
        return None
    return float(grid[first]), float(grid[first + length - 1]), float(their_grid[second] - grid[first])


def _inputs(imposed: Imposed, beside: Imposed | None = None) -> tuple[Array, Array, Array]:
    """Instants (s), and drive and load at them, of the largest of both recordings."""
    both = (imposed,) if beside is None else (imposed, beside)
    grid = np.arange(imposed.time[0], imposed.time[-1], _STEP)
    at = np.clip(np.searchsorted(imposed.time, grid + 1e-9, side='right') - 1, 0, imposed.time.size - 1)
    scale = max(*(float(np.ptp(each.drive)) for each in both), 1e-12)
    heaviest = max(*(float(np.max(each.load)) for each in both), 1e-12)
    return grid, imposed.drive[at] / scale, imposed.load[at] / heaviest


def _rises(drive: Array) -> Array:
    """Where the drive comes on: indices."""
    return np.asarray(np.flatnonzero((drive[1:] > 0.1) & (drive[:-1] <= 0.1)) + 1)


def _alike(drive: Array, other_drive: Array, load: Array, other_load: Array) -> bool:
    same = (np.abs(drive - other_drive) < 0.02) & (np.abs(load - other_load) < 0.02)
    return bool(np.mean(same) > 0.97)


def done_twice(experiments: Sequence[Experiment]) -> list[Twice]:
    """All that was done twice, in one recording or in two."""
    pairs = [(k, k, found) for k, e in enumerate(experiments) for found in repeats(e.imposed)]
    for k, other in combinations(range(len(experiments)), 2):
        found = copies(experiments[k].imposed, experiments[other].imposed)
        pairs += [(k, other, found)] if found else []
    return pairs


@dataclass(frozen=True)
class Protocol:
    """Recordings in which the same was done: their places, from 0, and when the drive first came on in each, s."""

    recordings: tuple[int, ...]
    begins: tuple[float, ...]


def protocols(experiments: Sequence[Experiment]) -> list[Protocol]:
    """The protocols of which there are several runs, whatever the runs are called.

    What hung before the drive came on was the same too: a muscle may remember it.
    """
    of = list(range(len(experiments)))  # the first recording of the same protocol
    for k, other, _ in done_twice(experiments):
        if k != other and _began_alike(experiments[k].imposed, experiments[other].imposed):
            of = [min(of[k], of[other]) if one in (of[k], of[other]) else one for one in of]
    found = []
    for first in sorted(set(of)):
        runs = tuple(k for k, one in enumerate(of) if one == first)
        if len(runs) > 1:
            found.append(Protocol(runs, tuple(_comes_on(experiments[k].imposed) for k in runs)))
    return found


def _began_alike(one: Imposed, other: Imposed) -> bool:
    """Whether the same hung before the drive came on, counted back from there; what only one of them has of it must
    have hung unchanged."""
    loads = []
    for imposed, beside in ((one, other), (other, one)):
        _, drive, load = _inputs(imposed, beside)
        loads.append(load[: int(_rises(drive)[0]) + 1][::-1])
    common = min(load.size for load in loads)
    rest = [load[common - 1 :] for load in loads]
    same = np.abs(loads[0][:common] - loads[1][:common]) < 0.02
    return bool(np.mean(same) > 0.97) and all(np.ptp(load) < 0.02 for load in rest)


def _comes_on(imposed: Imposed) -> float:
    """When the drive comes on for the first time, s."""
    level = 0.1 * max(float(np.ptp(imposed.drive)), 1e-12)
    return float(imposed.time[np.argmax(np.diff(imposed.drive, prepend=imposed.drive[0]) > level)])


def pure_error(
    experiments: Sequence[Experiment], residuals: Sequence[Mapping[str, Array]], channel: str, twice: Sequence[Twice]
) -> Noise | None:
    """The noise of a channel from what was done twice; None where too little was.

    ``residuals`` by channel, one an experiment. Their differences between the two serve, in which the slow approach to
    a periodic state, which the model knows, is gone as well.
    """
    noises, sizes = [], []
    for k, other, (start, end, shift) in twice:
        if channel not in residuals[k] or channel not in residuals[other]:
            continue
        one, two = experiments[k].observed[channel], experiments[other].observed[channel]
        time, again = one.time, two.time
        inside = (time >= start + 1.0) & (time <= end - 1.0)
        if np.count_nonzero(inside) < 20:
            continue
        wanted = time[inside] + shift
        nearest = np.abs(again[np.minimum(np.searchsorted(again, wanted), again.size - 1)] - wanted)
        kept = nearest < 2.0  # resistance may have been read in one of the two only
        # Both miss the same by what the model lacks, and not the same times what each weighs beside the other.
        mine, others = residuals[k][channel] / one.beside, residuals[other][channel] / two.beside
        usual = float(np.sqrt(0.5 * (one.beside**-2.0 + two.beside**-2.0)))
        difference = (mine[inside] - np.interp(wanted, again, others))[kept] / usual
        if difference.size < 20:
            continue
        noises.append(estimate(difference, 0.0))
        sizes.append(difference.size)
    if sum(sizes) < _LEAST_PAIRS:
        return None
    # A difference of two has twice the variance; interpolation between neighbours takes a little off.
    sigma = float(np.sqrt(np.average([n.sigma**2 for n in noises], weights=sizes) / 2.0)) * 1.1
    return Noise(sigma, float(np.average([n.phi for n in noises], weights=sizes)))
