"""Held-out data: other recordings, or other stretches of a single one; free-run, never one step ahead."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.diagnosis.experiment import Experiment, Observed
from tcp_muscle_ros.diagnosis.fitting import Fit, Problem, fit
from tcp_muscle_ros.muscle.arrays import Array, Mask

_STRETCHES = 4
_CLUSTER = 15.0  # s: stretches over which errors are summed before their scatter is judged


@dataclass(frozen=True)
class Fold:
    """Which observations are kept back: recording, and the stretch of it (s); the rest is fitted."""

    recording: int
    start: float
    end: float


def folds(experiments: Sequence[Experiment]) -> list[Fold]:
    """One fold a recording; of one or two recordings, stretches, so that no fold takes all that shows an effect."""
    if len(experiments) > 2:
        return [Fold(k, -np.inf, np.inf) for k in range(len(experiments))]
    found = []
    for k, experiment in enumerate(experiments):
        time = experiment.imposed.time
        edges = np.linspace(time[0], time[-1], _STRETCHES // len(experiments) + 1)
        found += [Fold(k, float(a), float(b)) for a, b in pairwise(edges)]
    return found


def _cut(observed: Observed, keep: Mask) -> Observed:
    return Observed(observed.time[keep], observed.value[keep], observed.count[keep])


def training(problem: Problem, fold: Fold) -> Problem:
    """The problem without what the fold keeps back. A recording kept back whole stays in with nothing observed."""
    experiments = []
    for k, experiment in enumerate(problem.experiments):
        if k != fold.recording:
            experiments.append(experiment)
            continue
        kept = {}
        for name, o in experiment.observed.items():
            outside = (o.time < fold.start) | (o.time > fold.end)
            if np.count_nonzero(outside) > 3:
                kept[name] = _cut(o, outside)
        experiments.append(replace(experiment, observed=kept))
    return replace(problem, experiments=tuple(experiments))


def testing(problem: Problem, fold: Fold) -> Problem:
    """The problem with only what the fold keeps back observed."""
    experiment = problem.experiments[fold.recording]
    kept = {}
    for name, o in experiment.observed.items():
        inside = (o.time >= fold.start) & (o.time <= fold.end)
        if np.count_nonzero(inside) > 3:
            kept[name] = _cut(o, inside)
    experiments = list(problem.experiments)
    experiments[fold.recording] = replace(experiment, observed=kept)
    return replace(problem, experiments=tuple(experiments))


@dataclass(frozen=True)
class HeldOut:
    """Errors on data not fitted. ``misfit``: sums of squared whitened residuals, one a cluster; ``squares`` and
    ``count``: by channel the sum of squared errors (SI) and how many."""

    misfit: Array
    by_fold: Array
    squares: dict[str, float]
    count: dict[str, int]

    def rmse(self) -> dict[str, float]:
        """Root mean square error by channel (SI)."""
        return {name: float(np.sqrt(self.squares[name] / self.count[name])) for name in self.squares}


def held_out(fitted: Fit, rounds: int = 4) -> HeldOut:
    """Refit without each fold in turn, from the full fit, and look at the fold.

    What belongs to a recording alone (its ambient, its start) is taken from the full fit: it is no property of the
    muscle, and a new recording brings its own.
    """
    problem = fitted.problem
    clusters: list[float] = []
    by_fold: list[float] = []
    squares: dict[str, float] = {}
    count: dict[str, int] = {}
    for fold in folds(problem.experiments):
        trained = fit(training(problem, fold), fitted.z, rounds=rounds, tolerance=1e-4)
        z = np.array(
            [
                own if u.recording == fold.recording else shared
                for u, own, shared in zip(problem.unknowns, fitted.z, trained.z, strict=True)
            ]
        )
        looked = testing(problem, fold)
        values = looked.values(z)
        white = looked.residual(values, fold.recording)[:-1]  # the last entry is not data
        observed = looked.experiments[fold.recording].observed
        total, start = 0.0, 0
        for channel in observed.values():
            part = white[start : start + channel.time.size] ** 2
            start += channel.time.size
            label = np.floor((channel.time - channel.time[0]) / _CLUSTER).astype(int)
            clusters.extend(np.bincount(label, part).tolist())
            total += float(part.sum())
        by_fold.append(total)
        for name, left in looked.raw_residuals(values, fold.recording).items():
            squares[name] = squares.get(name, 0.0) + float(left @ left)
            count[name] = count.get(name, 0) + left.size
    return HeldOut(np.array(clusters), np.array(by_fold), squares, count)


@dataclass(frozen=True)
class Gain:
    """Held-out improvement: its sum, its standard error over clusters, and the share of folds that improve."""

    total: float
    error: float
    folds: float

    @property
    def holds(self) -> bool:
        """Whether unseen data confirm it: most folds, and by twice its scatter."""
        return self.folds > 0.5 and self.total > 2.0 * self.error


def improvement(before: HeldOut, after: HeldOut) -> Gain:
    """What changed on the same unseen data."""
    drop = before.misfit - after.misfit
    error = float(np.std(drop) * np.sqrt(drop.size))
    return Gain(float(drop.sum()), error, float(np.mean(before.by_fold > after.by_fold)))
