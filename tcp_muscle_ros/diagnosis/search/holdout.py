"""Held-out data: other recordings, or other stretches of a single one; free-run, never one step ahead."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.fitting.weighing import robust_noise, structures
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown, without_effect
from tcp_muscle_ros.diagnosis.noise.noise import Noise
from tcp_muscle_ros.muscle.arrays import Array, Mask

_STRETCHES, _AT_A_TIME = 8, 2  # of a recording; and how many are kept back at once
_CLUSTER = 15.0  # s: stretches over which errors are summed before their scatter is judged
# A fold has a say where the squared whitened difference of two predictions is at least so much, of noise and of the
# largest of all folds; and, where it is a recording, of that on the data that were fitted.
_SEEN, _NOTABLE = 4.0, 0.02
# Where a fold is a recording and they differ more than so many times as much as on the data that were fitted, a form
# that is not quite the muscle's own errs by as much, and failure is no refutation; beyond the latter, nor is success.
_BEYOND, _FAR_BEYOND = 5.0, 40.0
# Who leaves less than such a share of what was missed (squared) was right however far it reached, if what was fitted
# tells the two apart by so much: ten standard deviations.
_RIGHT, _TOLD = 0.25, 100.0
# Nor is failure one where the poorer model misses (squared) a recording so many times as far as it misses the others.
_UNLIKE = 2.0
_TOUCHES = 0.1  # of the noise
PLAINLY = 3.0  # times the noise's variance, twice the noise: what is missed plainly


@dataclass(frozen=True)
class Fold:
    """Which observations are kept back: stretches (recording, start, end), s; or one recording ``whole``."""

    stretches: tuple[tuple[int, float, float], ...]
    whole: int | None = None

    @property
    def recordings(self) -> list[int]:
        """Those of which something is kept back."""
        return sorted({k for k, _, _ in self.stretches})


def conditions(problem: Problem) -> tuple[Fold, ...]:
    """One fold a recording; none of one or two recordings, or where each has unknowns of an effect for itself."""
    count = len(problem.experiments)
    if count < 3 or any(u.each_has for u in problem.unknowns):
        return ()
    return tuple(Fold(((k, -np.inf, np.inf),), k) for k in range(count))


def stretches(problem: Problem) -> tuple[Fold, ...]:
    """Stretches of recordings: no fold takes all that shows an effect, and what belongs to a recording is predicted
    from the rest of it."""
    experiments = problem.experiments
    kept_back = []
    for k, experiment in enumerate(experiments):
        time = experiment.imposed.time
        edges = np.linspace(time[0], time[-1], _STRETCHES + 1)
        parts = [(k, float(a), float(b)) for a, b in pairwise(edges)]
        # Far apart: what drifts is then predicted between what was seen as well as beyond it.
        apart = _STRETCHES // _AT_A_TIME
        kept_back.append([tuple(parts[first::apart]) for first in range(apart)])
    if len(experiments) > 2:
        return tuple(Fold(sum(parts, ())) for parts in zip(*kept_back, strict=True))
    return tuple(Fold(parts) for own in kept_back for parts in own)


def _split(problem: Problem, fold: Fold, inside: bool) -> Problem:
    """The problem with only what the fold keeps back observed, or only the rest."""
    keep: list[dict[str, Mask]] = []
    for k, experiment in enumerate(problem.experiments):
        mine = [(a, b) for recording, a, b in fold.stretches if recording == k]
        kept: dict[str, Mask] = {}
        for name, o in experiment.observed.items():
            within = np.zeros(o.time.size, dtype=bool)
            for a, b in mine:
                within |= (o.time >= a) & (o.time <= b)
            wanted = within if inside else ~within
            if np.count_nonzero(wanted) > 3:
                kept[name] = wanted
        keep.append(kept)
    return problem.only(keep)


def training(problem: Problem, fold: Fold) -> Problem:
    """The problem without what the fold keeps back. A recording kept back whole stays in with nothing observed."""
    return _split(problem, fold, inside=False)


def testing(problem: Problem, fold: Fold) -> Problem:
    """The problem with only what the fold keeps back observed."""
    return _split(problem, fold, inside=True)


@dataclass(frozen=True)
class HeldOut:
    """Errors on data not fitted.

    ``white``: whitened residuals by channel, ``misfit``: sums of their squares, one a cluster; ``fitted``: whitened
    residuals of the data that were fitted instead; each one a fold. ``squares`` and ``count``: by channel the sum of
    squared errors (SI) and how many.
    """

    white: tuple[Mapping[str, Array], ...]
    fitted: tuple[Array, ...]
    misfit: tuple[Mapping[str, Array], ...]
    squares: dict[str, float]
    count: dict[str, int]

    def rmse(self) -> dict[str, float]:
        """Root mean square error by channel (SI)."""
        return {name: float(np.sqrt(self.squares[name] / self.count[name])) for name in self.squares}


Weights = tuple[tuple[str, Noise], ...]  # by channel, the noise by which errors are judged; none: that of the fit


@lru_cache(maxsize=16)
def held_out(fitted: Fit, kept_back: tuple[Fold, ...], rounds: int = 12, weights: Weights = ()) -> HeldOut:
    """Refit without each fold in turn, from the full fit, and look at the fold.

    What belongs to a recording alone is taken from the full fit where that is kept back whole: it is no property of the
    muscle, and a new recording brings its own. So is its start always, which may be in the stretch that is kept back.
    """
    found = _judged(_foretold(fitted, kept_back, rounds), weights)
    fitted.problem.forget()  # the fit is kept with its answer
    return found


def held_out_as(fitted: Fit, kept_back: tuple[Fold, ...], seen_as: Callable[[Fit], Array], rounds: int = 12) -> HeldOut:
    """The same with what ``seen_as`` makes of the unknowns of each fit to the rest."""
    return _judged([_foretelling(fitted, fold, _without(fitted, fold, rounds), seen_as) for fold in kept_back], ())


@lru_cache(maxsize=8)
def _without(fitted: Fit, fold: Fold, rounds: int) -> Fit:
    """The fit to the rest of the data."""
    rest = training(fitted.problem, fold)
    return fit(rest, fitted.z, rounds=rounds, tolerance=1e-4, known=_slopes_of(rest, fitted))


@dataclass(frozen=True)
class _Foretold:
    """What a fit to the rest of the data of a ``problem`` shows of it (``fitted``), and what with the unknowns of a
    whole model is shown of the ``fold`` (``unseen``), by recording with the ``zeros`` that the rest has.

    The two parts of the problem are made again where they are asked for: with all in which their channels may err they
    take tens of megabytes a fold, and this is kept for many folds.
    """

    problem: Problem
    fold: Fold
    fitted: tuple[Shown, ...]
    unseen: list[Shown]
    zeros: Mapping[int, dict[str, float]]


@lru_cache(maxsize=16)
def _foretold(fitted: Fit, kept_back: tuple[Fold, ...], rounds: int) -> tuple[_Foretold, ...]:
    """Each fold as the fit to the rest foretells it."""
    return tuple(
        _foretelling(fitted, fold, _without(fitted, fold, rounds), lambda trained: trained.z) for fold in kept_back
    )


def _foretelling(fitted: Fit, fold: Fold, trained: Fit, seen_as: Callable[[Fit], Array]) -> _Foretold:
    """A fold as a fit to the rest foretells it."""
    problem, rest = fitted.problem, trained.problem
    z = np.array(
        [
            own if u.state or (u.recording is not None and u.recording == fold.whole) else shared
            for u, own, shared in zip(problem.unknowns, fitted.z, seen_as(trained), strict=True)
        ]
    )
    predictions = problem.predictions(z)
    remaining, unseen = (_at_the_instants_of(part, problem, predictions) for part in (rest, testing(problem, fold)))
    # A stretch has the zero of the rest of its recording, as the fit weighs it: its own would show no drift.
    zeros = {k: rest.zeros(remaining[k], k) for k in fold.recordings}
    rest.forget()
    return _Foretold(problem, fold, trained.predictions, unseen, zeros)


def _judged(foretold: Sequence[_Foretold], weights: Weights) -> HeldOut:
    """The errors of what was foretold, judged by the noise of the fit, or by another."""
    clusters: list[Mapping[str, Array]] = []
    errors: list[Mapping[str, Array]] = []
    remembered: list[Array] = []
    squares: dict[str, float] = {}
    count: dict[str, int] = {}
    for mine in foretold:
        judged, zeros = mine.problem.with_noise({**mine.problem.noise, **dict(weights)}), mine.zeros
        looked, rest = testing(judged, mine.fold), training(judged, mine.fold)
        together: dict[str, list[Array]] = {}
        sums: dict[str, list[Array]] = {}
        for recording in mine.fold.recordings:
            white = looked.residual(mine.unseen[recording], recording, zeros[recording])
            start = 0
            for name, channel in looked.experiments[recording].observed.items():
                part = white[start : start + channel.time.size]
                start += channel.time.size
                label = np.floor((channel.time - channel.time[0]) / _CLUSTER).astype(int)
                together.setdefault(name, []).append(part)
                sums.setdefault(name, []).append(np.asarray(np.bincount(label, part**2)))
            for name, left in looked.raw_residual(mine.unseen[recording], recording, zeros[recording]).items():
                squares[name] = squares.get(name, 0.0) + float(left @ left)
                count[name] = count.get(name, 0) + left.size
        clusters.append({name: np.concatenate(parts) for name, parts in sums.items()})
        errors.append({name: np.concatenate(parts) for name, parts in together.items()})
        remembered.append(np.concatenate(rest.residuals(mine.fitted)))
    return HeldOut(tuple(errors), tuple(remembered), tuple(clusters), squares, count)


@dataclass(frozen=True)
class Gain:
    """Held-out improvement, over the folds that have a say: its sum; what noise alone scatters it by; its scatter over
    clusters; the share of those folds that improve, where any does more or less than noise alone would; how many have a
    say."""

    total: float
    chance: float
    scatter: float
    folds: float
    say: int

    @property
    def holds(self) -> bool:
        """Whether unseen data confirm it: most folds, beyond chance, and not by one cluster against the others.

        The scatter counts half: an effect that acts in a few moments only improves few clusters, and those much.
        """
        return not self.fails and self.total > 3.0 * self.chance and self.total > 0.5 * self.scatter

    @property
    def fails(self) -> bool:
        """Whether unseen data speak against it: in half of the folds. Worse altogether by a few says too little."""
        return self.say > 0 and self.folds <= 0.5


def _at_the_instants_of(part: Problem, whole: Problem, shown: Sequence[Shown]) -> list[Shown]:
    """Of what is shown in whole recordings (or of its slopes), the rows that a part of them observes."""
    found = []
    for some, every, mine in zip(part.experiments, whole.experiments, shown, strict=True):
        # What is no channel belongs to a recording as a whole.
        kept = {name: rows for name, rows in mine.items() if name not in every.observed}
        for name, observed in some.observed.items():
            kept[name] = mine[name][np.searchsorted(every.observed[name].time, observed.time)]
        found.append(kept)
    return found


def _slopes_of(rest: Problem, fitted: Fit) -> list[Shown] | None:
    """The fit's slopes at the instants that remain."""
    known = fitted.rough_slopes
    return None if known is None else _at_the_instants_of(rest, fitted.problem, known)


def improvement(before: HeldOut, after: HeldOut, whole: bool = False, channels: frozenset[str] | None = None) -> Gain:
    """What changed on the same unseen data, under the same noise; of these ``channels``, None: all.

    Where noise e is all that a model leaves, another that differs by d changes the misfit by d'd + 2 e'd. A fold has no
    say where the models hardly differ; nor, where folds are ``whole`` recordings, where the models differ far more than
    on what they were fitted to, or miss the recording far more than the others: what the rest did not show was not
    learnt from it. There a failure is not the effect's, but a success is. Of those that have a say, most must improve;
    where noise alone could have tipped some, of the others.
    """
    had, has, missed, misses = (
        [_together(fold, channels) for fold in folds]
        for folds in (before.white, after.white, before.misfit, after.misfit)
    )
    moved = np.array([float(np.sum((a - b) ** 2)) for a, b in zip(had, has, strict=True)])
    learnt = np.array([float(np.sum((a - b) ** 2)) for a, b in zip(before.fitted, after.fitted, strict=True)])
    say = moved > max(_SEEN, _NOTABLE * float(moved.max(initial=0.0)))
    drops = [a - b for a, b in zip(missed, misses, strict=True)]
    change = np.array([float(drop.sum()) for drop in drops])
    better = change > 0.0
    if whole:
        right = np.array([float(b.sum()) < _RIGHT * float(a.sum()) for a, b in zip(missed, misses, strict=True)])
        right &= learnt > _TOLD
        say &= (moved > _NOTABLE * learnt) & (right | (moved <= np.where(better, _FAR_BEYOND, _BEYOND) * learnt))
        say &= better | ~_unlike(had)
    if not say.any():
        return Gain(0.0, 0.0, 0.0, 0.0, 0)
    decided = say & (np.abs(change) > 2.0 * np.sqrt(moved))
    counted = np.concatenate([drop for drop, counts in zip(drops, say, strict=True) if counts])
    return Gain(
        float(counted.sum()),
        2.0 * float(np.sqrt(moved[say].sum())),
        float(np.std(counted) * np.sqrt(counted.size)),
        float(np.mean(better[decided if decided.any() else say])),
        int(say.sum()),
    )


def _together(fold: Mapping[str, Array], channels: frozenset[str] | None) -> Array:
    """What there is of these channels."""
    parts = [part for name, part in fold.items() if channels is None or name in channels]
    return np.concatenate(parts) if parts else np.zeros(0)


def _unlike(white: Sequence[Array]) -> Mask:
    """Which folds are missed far more than the others."""
    missed = np.array([float(np.mean(fold**2)) if fold.size else 0.0 for fold in white])
    usual = np.array([float(np.median(np.delete(missed, k))) for k in range(missed.size)])
    return np.asarray(missed > _UNLIKE * usual)


def touched(before: Fit, after: Fit) -> frozenset[str] | None:
    """The channels that what ``after`` has more changes by itself; None for all.

    Where it changes nothing the two models differ by how little the data fix of their other parameters. But what one
    sensor reads wrong they take up, and the others pay for it: a sensor is asked for in all channels.
    """
    more = set(after.problem.parameters.effects) - set(before.problem.parameters.effects)
    effect = more.pop() if len(more) == 1 else ''
    if not effect or after.problem.model.effects[effect].stage == 'sensor':
        return None
    return changed_by(after, effect) or None


def changed_by(fitted: Fit, effect: str) -> frozenset[str]:
    """The channels in which a fit shows something else without one of its effects, all else being as it is."""
    without, kept = without_effect(fitted.problem, effect)
    shown = without.predictions(fitted.z[kept])
    found = set()
    for had, has, experiment in zip(shown, fitted.predictions, fitted.problem.experiments, strict=True):
        for name, observed in experiment.observed.items():
            changed = float(np.sqrt(np.mean((has[name] - had[name]) ** 2))) * observed.beside
            if changed > _TOUCHES * fitted.problem.noise[name].sigma:
                found.add(name)
    return frozenset(found)


def confirmation(before: Fit, after: Fit) -> tuple[Gain, tuple[Fold, ...]]:
    """What unseen data say of a richer model, and which: other conditions where they confirm it or speak against it,
    else, where they say too little, other stretches of the same ones.

    They are asked in the channels that it touches; in all, where there the two models hardly differ.
    """
    channels = touched(before, after)
    gain, kept_back = _asked(before, after, channels)
    return _asked(before, after, None) if channels is not None and gain.say == 0 else (gain, kept_back)


def _asked(before: Fit, after: Fit, channels: frozenset[str] | None) -> tuple[Gain, tuple[Fold, ...]]:
    """The same, in these channels; None: all."""
    weights = _weights(before, after)
    kept_back = conditions(after.problem)
    if kept_back:
        had, has = (held_out(model, kept_back, weights=weights) for model in (before, after))
        gain = improvement(had, has, whole=True, channels=channels)
        if gain.holds or gain.fails:
            return gain, kept_back
    kept_back = stretches(after.problem)
    had, has = (held_out(model, kept_back, weights=weights) for model in (before, after))
    return improvement(had, has, channels=channels), kept_back


def _weights(before: Fit, after: Fit) -> Weights:
    """The noise by which the two are compared: what the richer model leaves, where the poorer one misses plainly more.

    Into that of the poorer one counts what it misses. By it a channel that it misses plainly weighs next to nothing,
    and chance in the others outweighs that the richer model does not miss it. Otherwise both leave the noise, and a
    smaller one makes more of what a draught does by chance.
    """
    leaves = robust_noise(after, structures(after))
    return tuple(
        (name, leaves[name] if noise.sigma**2 > PLAINLY * leaves[name].sigma ** 2 else noise)
        for name, noise in before.problem.noise.items()
    )
