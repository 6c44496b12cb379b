"""Where the calibrated model differs: channel, phase, temperature, time; from the structure of the misfit alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.anchored import anchored
from tcp_muscle_ros.diagnosis.fitting.generic import Drivers, Structure, drivers
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.noise.noise import slow_size
from tcp_muscle_ros.muscle.arrays import Array, Mask

_TRANSITION = 2.0  # s after a switch
_STEADY = 0.02  # of the largest rate: slower is rest
_WINDOW = 10.0  # s
_MOST_INTERVALS = 3
_BINS = 20  # of a variable's range
_SPARSE = 0.25  # of the samples that a bin has on average: fewer tell little of its misfit
_SOME, _NEARLY = 0.1, 0.5  # of the misfit's energy that a phase holds; of the largest mean square of a phase
_MOSTLY = 0.5  # of a misfit's size: a mean that is smaller says little of it
_SURE = 3.0  # standard deviations of the mean of so much noise


@dataclass(frozen=True)
class Driver:
    """The range of a variable in which the misfit is largest, and the share (0 to 1) of the whole that is in it. SI;
    without a unit where it is a channel itself, of the range of which it is a share."""

    variable: str
    low: float
    high: float
    share: float
    unit: str


@dataclass(frozen=True)
class Location:
    """Where the calibrated model differs.

    ``intervals``: the stretches with the largest misfit: recording (an index, from 0), start, end (s). ``size``: the
    root mean square of recorded minus calibrated there (SI of the channel, never negative); ``mean``: its mean, where
    that has one sign for sure, and it is the larger part of what is missed; None where it has not.
    """

    stage: str
    channel: str
    phases: tuple[str, ...]
    drivers: tuple[Driver, ...]
    intervals: tuple[tuple[int, float, float], ...]
    size: float
    mean: float | None = None


@dataclass(frozen=True)
class Unexplained:
    """Structure that no listed effect explains: its share of the misfit above noise, and what it goes with.

    ``interval``: the stretch that shows it most: recording (an index, from 0), start, end (s).
    """

    stage: str
    channel: str
    share: float
    driver: str
    low: float
    high: float
    interval: tuple[int, float, float]


def worst_channel(found: Mapping[str, Structure]) -> str | None:
    """The channel whose misfit stands out most; None where none does.

    Of channels that stand out alike the one upstream counts: what is wrong with the temperature shows downstream too.
    """
    standing = {name: s.gain / s.terms for name, s in found.items() if s.significant}
    if not standing:
        return None
    return max(standing, key=lambda name: standing[name])


def locate(fitted: Fit, found: Mapping[str, Structure], channel: str, stage: str | None = None) -> Location:
    """Say where one channel's misfit is largest, by phase, temperature and time; where the recordings do not say how
    hot it was, by the channel itself in place of the temperature.

    Largest in noise units, not where most of its sum is: that is where the muscle was for long.
    """
    problem = fitted.problem
    owners = [k for k, e in enumerate(problem.experiments) if channel in e.observed]
    smooth = found[channel].fitted
    seen: list[Drivers] = []
    for k in owners:
        outputs = fitted.outputs[k]
        seen.append(drivers(problem.followed[k], outputs, problem.experiments[k].observed[channel].time))
    misfit = np.concatenate(smooth)
    energy = misfit**2
    variable, title, unit = _ordering(fitted, channel, owners, seen)
    phases = _phases(seen)
    picked = _strong_phases(phases, energy)
    low, high, share = _narrowest(variable, energy, 0.6)
    inside = (variable >= low) & (variable <= high)
    if picked:
        inside &= np.logical_or.reduce([phases[p] for p in picked])
    inside = inside if np.any(inside) else np.ones(misfit.size, dtype=bool)
    kept = np.split(inside, np.cumsum([part.size for part in smooth])[:-1])
    missed = [fitted.left[k][channel][there] for k, there in zip(owners, kept, strict=True)]
    noise = slow_size(found[channel].noise)
    size, mean = _typical(missed, [noise / problem.experiments[k].observed[channel].beside for k in owners])
    found_drivers = [Driver(title, low, high, share, unit)]
    load = np.concatenate([d.load for d in seen])
    if np.ptp(load) > 0.0:
        a, b, part = _narrowest(load, energy, 0.6)
        if part > 0.6 and (a, b) != (float(load.min()), float(load.max())):
            found_drivers.append(Driver('load', a, b, part, 'N'))
    intervals = _intervals(owners, [problem.experiments[k].observed[channel].time for k in owners], smooth)
    stage = stage or problem.model.channels[channel].stage
    return Location(stage, channel, picked, tuple(found_drivers), intervals, size, mean)


def _ordering(fitted: Fit, channel: str, owners: Sequence[int], seen: Sequence[Drivers]) -> tuple[Array, str, str]:
    """What orders the misfit, its name and its unit: the state, or where no recording anchors that, how far the channel
    itself has gone."""
    problem = fitted.problem
    if anchored(fitted):
        return np.concatenate([d.level for d in seen]), problem.model.state_title, problem.model.state_unit
    shown = np.concatenate([problem.experiments[k].observed[channel].value for k in owners])
    gone = (shown - shown.min()) / max(float(np.ptp(shown)), 1e-300)
    return gone, share_of_range(channel), ''


def share_of_range(channel: str) -> str:
    """What such a driver is called."""
    return f'share of the range of the {channel}'


def _phases(seen: Sequence[Drivers]) -> dict[str, Mask]:
    rate = np.concatenate([d.rate for d in seen])
    warms = rate > 0.0  # not whether the drive is on: a muscle cools under the small current that reads its resistance
    fresh = np.concatenate([d.since_switch for d in seen]) < _TRANSITION
    still = np.abs(rate) < _STEADY * max(float(np.max(np.abs(rate))), 1e-12)
    return {
        'heating': warms & ~still & ~fresh,
        'cooling': ~warms & ~still & ~fresh,
        'rest': still & ~fresh,
        'transition': fresh,
    }


def _strong_phases(phases: Mapping[str, Mask], energy: Array) -> tuple[str, ...]:
    """Phases in which the mean square misfit is half the largest at least, of those that hold a tenth of it."""
    total = float(energy.sum())
    sizes = {
        name: float(energy[mask].mean())
        for name, mask in phases.items()
        if mask.any() and float(energy[mask].sum()) > _SOME * total
    }
    return tuple(name for name, size in sizes.items() if size > _NEARLY * max(sizes.values()))


def _narrowest(variable: Array, energy: Array, wanted: float) -> tuple[float, float, float]:
    """The narrowest range around the largest mean square misfit, over 20 equal bins, that has ``wanted`` of the sum of
    the bins' mean squares: low, high, and the share of all energy in it."""
    edges = np.linspace(float(variable.min()), float(variable.max()), _BINS + 1)
    if edges[0] == edges[-1]:
        return float(edges[0]), float(edges[-1]), 1.0
    held, _ = np.histogram(variable, edges, weights=energy)
    count, _ = np.histogram(variable, edges)
    # Of few samples the mean is not sure.
    mean_square = held / np.maximum(count, _SPARSE * variable.size / _BINS)
    sums, all_energy = (np.concatenate([[0.0], np.cumsum(part)]) for part in (mean_square, held))
    peak = int(np.argmax(mean_square))
    for width in range(1, _BINS + 1):
        first = np.arange(max(peak - width + 1, 0), min(peak, _BINS - width) + 1)
        best = int(first[np.argmax(sums[first + width] - sums[first])])
        last = best + width
        if sums[last] - sums[best] >= wanted * sums[-1]:
            share = (all_energy[last] - all_energy[best]) / max(float(all_energy[-1]), 1e-300)
            return float(edges[best]), float(edges[last]), float(share)
    return float(edges[0]), float(edges[-1]), 1.0


def _typical(missed: Sequence[Array], noises: Sequence[float]) -> tuple[float, float | None]:
    """The root mean square of what is missed in each recording; and its mean, where that is half as large at least and
    has the same sign in each, beyond what its noise (slow, SI) gives; else None."""
    together = np.concatenate(missed)
    size, mean = float(np.sqrt(np.mean(together**2))), float(np.mean(together))
    sure = [
        np.sign(mean) * float(np.mean(part)) > _SURE * noise / np.sqrt(part.size)
        for part, noise in zip(missed, noises, strict=True)
        if part.size
    ]
    return size, mean if abs(mean) >= _MOSTLY * size and all(sure) else None


def _intervals(
    owners: Sequence[int], times: Sequence[Array], smooth: Sequence[Array]
) -> tuple[tuple[int, float, float], ...]:
    """The stretches of time with the largest misfit."""
    windows = []
    for owner, time, part in zip(owners, times, smooth, strict=True):
        label = np.floor((time - time[0]) / _WINDOW).astype(int)
        power = np.bincount(label, part**2) / np.maximum(np.bincount(label), 1)
        for k in range(power.size):
            start = float(time[0]) + k * _WINDOW
            windows.append((float(power[k]), owner, start, min(start + _WINDOW, float(time[-1]))))
    windows.sort(reverse=True)
    return tuple((owner, start, end) for _, owner, start, end in windows[:_MOST_INTERVALS])
