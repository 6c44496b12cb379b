"""What several channels see at once: no noise, for sensors err on their own.

A draught, a room or a supply that wanders moves temperature, resistance and stroke together. Where no state of the
muscle goes with it, a smooth misfit passes for slow noise in each channel alone; that they agree tells it from noise.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array

_WINDOW = 5.0  # s, over which a channel's misfit is averaged
_FEWEST = 8  # windows of a recording
_SURE = 6.0  # standard deviations of the correlation of independent noise
_AGREE = 0.7  # correlation: half of what one shows is in the other
_BEYOND = 2.0  # times the quick noise's variance: less is what an input's own noise leaves


@dataclass(frozen=True)
class Shared:
    """Two channels whose misfits agree: which, their correlation, and where it is strongest (recording, from, to in
    s)."""

    channels: tuple[str, str]
    correlation: float
    interval: tuple[int, float, float]


def shared_misfit(fitted: Fit) -> Shared | None:
    """The pair of channels that agree best on what a fit leaves; None where none do beyond chance and noise."""
    return next(iter(agreeing(fitted)), None)


@lru_cache(maxsize=2)
def agreeing(fitted: Fit) -> tuple[Shared, ...]:
    """The pairs of channels that agree on what a fit leaves beyond chance and noise, the best first."""
    experiments = fitted.problem.experiments
    floor = quick_noise(experiments)
    names = [name for name in floor if fitted.mean_square[name] > _BEYOND * floor[name].sigma ** 2]
    found: list[tuple[float, Shared]] = []
    for one, two in combinations(names, 2):
        pairs = [
            (k, *_windows(e, one, left[one], two, left[two]))
            for k, (e, left) in enumerate(zip(experiments, fitted.left, strict=True))
            if one in e.observed and two in e.observed
        ]
        pairs = [(k, start, a, b) for k, start, a, b in pairs if start.size >= _FEWEST]
        if not pairs:
            continue
        # Slow noise gives fewer independent windows (Bartlett 1946).
        independent = sum(
            a.size * (1.0 - both) / (1.0 + both) for _, _, a, b in pairs for both in [_slow(a) * _slow(b)]
        )
        powers = [
            np.sqrt(sum(float(x @ x) for x in column)) for column in zip(*((a, b) for *_, a, b in pairs), strict=True)
        ]
        correlation = sum(float(a @ b) for *_, a, b in pairs) / max(float(np.prod(powers)), 1e-300)
        surety = abs(np.arctanh(np.clip(correlation, -0.999, 0.999))) * np.sqrt(max(independent - 3.0, 0.0))
        if surety >= _SURE and abs(correlation) >= _AGREE:
            k, start, a, b = max(pairs, key=lambda pair: float(np.max(np.abs(pair[2] * pair[3]))))
            at = float(start[int(np.argmax(np.abs(a * b)))])
            found.append((abs(correlation), Shared((one, two), correlation, (k, at, at + _WINDOW))))
    return tuple(shared for _, shared in sorted(found, key=lambda one: -one[0]))


def _windows(experiment: Experiment, one: str, left: Array, two: str, right: Array) -> tuple[Array, Array, Array]:
    """Where windows begin (s) in which both channels were seen, and the mean misfit of each in them."""
    begin = float(experiment.imposed.time[0])
    count = int(np.ceil(experiment.duration / _WINDOW)) + 1
    means = []
    for name, misfit in ((one, left), (two, right)):
        label = ((experiment.observed[name].time - begin) / _WINDOW).astype(int)
        number = np.bincount(label, minlength=count)
        means.append(np.bincount(label, misfit, count) / np.where(number > 0, number, np.nan))
    seen = np.isfinite(means[0]) & np.isfinite(means[1])
    a, b = (mean[seen] - np.mean(mean[seen]) if seen.any() else mean[seen] for mean in means)
    return np.asarray(begin + _WINDOW * np.flatnonzero(seen)), a, b


def _slow(values: Array) -> float:
    """Correlation of one window with the next; 0 at least."""
    return max(float(values[1:] @ values[:-1]) / max(float(values @ values), 1e-300), 0.0)
