"""Sudden slips of the end, and other changes for good: what is shown leaps from one instant to the next, and stays.

No model foretells the instants, and no smooth one has such steps: they are read from what a fit leaves, as steps beside
a line, away from the steps of drive and load. Several, all of them lengthening, each at an instant of its own, are
turns lost; anything else has no name in the catalogue. Where an end sticks, its jumps are none of these: they go both
ways at instants of chance, so a model that copies them from a recording foretells nothing.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, seen_beside
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted, settle_noise
from tcp_muscle_ros.diagnosis.hypothesis.latents import Slip
from tcp_muscle_ros.diagnosis.model.model import floating
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.inputs import distance

_REACH, _SHORT = 2.5, 1.2  # s either side of a step, over which all else is a line; and between slips that follow soon
_FEWEST, _MOST = 4, 40  # samples either side
_CLEAR, _CLEAR_BESIDE = 6.0, 4.5  # times what is usual in that recording; and beside others
_SUDDEN = 0.6  # of the step, from one sample to the next but one
_SEVERAL, _OTHERWISE = 2, 0.2  # slips that make an effect; and the share of steps the other way that unmakes it
_OWN = 1.0  # s from those of other recordings
_LESS = 0.9  # of what is left (squared) without them
_CLEARLY, _FAR_LESS = 8.0, 0.7  # for what has no name
_AGAIN, _LEFT = 4, 0.25  # leaps; and the share of them that is left where they go and come back
_STEP = 0.05  # of an input's span
_RINGS = 5.0  # s after a step of the load
_APART, _APART_BESIDE = 1.0, 0.25  # s between a slip and a step of drive or load; and beside other slips
_SAMPLES_APART = 3.0  # between slips
_UNSURE = 3.0  # times what is usual: what is slow and missed bends them too
_HOLDS = 0.9  # of the least torque at which the end slipped
_ROUNDS = 3


def slipping(fitted: Fit) -> bool:
    """Whether a fit has sudden slips."""
    return bool(fitted.problem.slips)


def slipped(fitted: Fit) -> Fit | None:
    """The same fit with the slips that it leaves, or None where it shows none, or where what sticks slips."""
    if fitted.problem.model.roles.sticks in fitted.problem.parameters.effects:
        return None
    found = _found(fitted, _CLEAR, _APART, (_REACH,))
    if not (_lengthening(found) and _several(fitted, found)):
        return None
    better = added(fitted, [[slip for slip in mine if slip.size > 0.0] for mine in found])
    again = refitted(fitted, fitted.problem)  # what a refit alone would gain is not the slips'
    return further(better) if _less(again, better, _LESS) else None  # what comes back was no turn lost


def leapt(fitted: Fit) -> Fit | None:
    """The same fit with the changes for good that it leaves, or None where it shows none."""
    found = _found(fitted, _CLEARLY, _APART, (_REACH,), fitted.mean_square)
    if not any(found) or _comes_back(found):
        return None
    better = added(fitted, found)
    if not _less(refitted(fitted, fitted.problem), better, _FAR_LESS):
        return None
    for _ in range(_ROUNDS):
        better = _with(better, _sized(better))
    return settle_noise(better, 1)[0]


def _comes_back(found: Sequence[Sequence[Slip]]) -> bool:
    """Whether what leaps leaps back, again and again: no change for good, but a law that has such steps."""
    sizes = [np.array([slip.size for slip in mine]) for mine in found if mine]
    return sum(mine.size for mine in sizes) >= _AGAIN and all(
        abs(np.sum(mine)) < _LEFT * np.sum(np.abs(mine)) for mine in sizes
    )


def further(fitted: Fit) -> Fit:
    """The same fit with slips that show only beside those that it has."""
    for _ in range(_ROUNDS):
        found = _found(fitted, _CLEAR_BESIDE, _APART_BESIDE, (_REACH, _SHORT))
        more = [[slip for slip in mine if slip.size > 0.0] for mine in found] if _lengthening(found) else []
        better = added(_seen_again(fitted), more or [[]] * len(found))
        if not _less(fitted, better, 1.0):
            break
        fitted = better
    for _ in range(_ROUNDS):
        fitted = _with(fitted, _sized(fitted))
    return settle_noise(fitted, 1)[0]


def _lengthening(found: Sequence[Sequence[Slip]]) -> bool:
    """Whether there are steps, nearly all of them such that the muscle is longer after them."""
    sizes = [slip.size for mine in found for slip in mine]
    return bool(sizes) and sum(size < 0.0 for size in sizes) <= _OTHERWISE * len(sizes)


def _several(fitted: Fit, found: Sequence[Sequence[Slip]]) -> bool:
    """Whether the muscle is longer after several, most at instants that are not also those of other recordings."""
    elapsed = [
        round((slip.time - e.imposed.time[0]) / _OWN)
        for e, mine in zip(fitted.problem.experiments, found, strict=True)
        for slip in mine
        if slip.size > 0.0
    ]
    return len(elapsed) >= _SEVERAL and len(set(elapsed)) > 0.5 * len(elapsed)


def _less(before: Fit, after: Fit, share: float) -> bool:
    """Whether slips leave less than a share of what was left (squared) of any channel that shows them."""
    showing = {slip.channel for slip in after.problem.slips}
    return any(after.mean_square[name] < share * before.mean_square[name] for name in showing)


def _found(
    fitted: Fit, clear: float, apart: float, reaches: Sequence[float], channels: Collection[str] | None = None
) -> list[list[Slip]]:
    """The sudden steps in what a fit leaves of these channels, clear of the inputs' own, by recording; none where it
    sticks."""
    problem = fitted.problem
    swings = problem.model.roles.swings in problem.parameters.effects
    found, looked = [], floating(problem.model) if channels is None else channels
    for experiment, latent, mine in zip(problem.followed, problem.latents, fitted.left, strict=True):
        left = {name: mine[name] for name in mine if name in looked}
        steps = _steps(experiment, latent.slips, left, clear, apart, reaches, swings)
        stuck = {name for name in {slip.channel for slip in steps} if _sticks(experiment, name, left[name])}
        found.append([slip for slip in steps if slip.channel not in stuck])
    return found


def _sticks(experiment: Experiment, name: str, left: Array) -> bool:
    """Whether a channel that moves rests and jumps by chance; of averages it is told too, if less surely."""
    return name in floating(experiment.model) and seen_beside(experiment.observed[name], left).kind == CHANCE


def added(fitted: Fit, found: Sequence[Sequence[Slip]]) -> Fit:
    """The fit with these slips and its own."""
    return _with(fitted, [(*latent.slips, *mine) for latent, mine in zip(fitted.problem.latents, found, strict=True)])


def taken_out(fitted: Fit) -> Fit:
    """The fit without its slips."""
    return settle_noise(_with(fitted, [()] * len(fitted.problem.experiments)), 1)[0]


@dataclass(frozen=True)
class Leakage:
    """The mean of sudden slips as the effect whose mean they are: its ``rate`` (1/s), what that is known to (standard
    deviation), and the torque from which it ``begins``, in the unit of the motion."""

    rate: float
    unsure: float
    begins: float


def mean_leakage(fitted: Fit) -> Leakage | None:
    """What the slips of a fit are in the mean; None without any, or where the effect's own flow was fitted.

    What clamped the end held up to about the least torque at which it slipped.
    """
    problem = fitted.problem
    motion = problem.model.motion
    sizes = [slip.size for slip in problem.slips if slip.channel == motion]
    if not sizes or problem.model.roles.slips in problem.parameters.effects:
        return None
    seen, at = [], []
    for experiment, latent, outputs in zip(problem.experiments, problem.latents, fitted.outputs, strict=True):
        if motion in experiment.observed:
            torque = experiment.model.exposed(fitted.muscle, outputs)
            seen.append((np.diff(outputs.time), torque[:-1]))
            at += [float(np.interp(s.time, outputs.time, torque)) for s in latent.slips if s.channel == motion]
    begins = _HOLDS * max(min(at), 0.0)
    exposed = sum(float(np.maximum(torque - begins, 0.0) @ step) for step, torque in seen)
    if not exposed > 0.0:  # nothing pulled at it: then no torque made it slip
        return None
    rate = sum(sizes) / exposed
    unsure = rate * float(np.sqrt(1.0 + np.var(sizes) / np.mean(sizes) ** 2) / np.sqrt(len(sizes)))
    return Leakage(rate, unsure, begins)


def _with(fitted: Fit, slips: Sequence[Sequence[Slip]]) -> Fit:
    latents = [replace(latent, slips=tuple(mine)) for latent, mine in zip(fitted.problem.latents, slips, strict=True)]
    return refitted(fitted, fitted.problem.with_latents(latents))


def _sized(fitted: Fit) -> list[tuple[Slip, ...]]:
    """The slips with their most likely sizes, all else that the model leaves free being fitted too, in linear
    approximation."""
    problem = fitted.problem
    scale = problem.spreads()
    columns, sizes, usual = [], [], []
    for k, (experiment, latent) in enumerate(zip(problem.experiments, problem.latents, strict=True)):
        for slip in latent.slips:
            shown = {name: np.zeros((o.time.size, 1)) for name, o in experiment.observed.items()}
            shown[slip.channel][:, 0] = -slip.after(experiment.observed[slip.channel].time)
            shown |= {name: np.zeros((1, 1)) for name in fitted.predictions[k] if name not in shown}
            whole = [np.zeros(part.size) for part in fitted.residuals]
            whole[k] = problem.columns(shown, k)[:, 0]
            columns.append(np.concatenate([*whole, np.zeros(scale.size)]))
            sizes.append(slip.size)
            usual.append(_UNSURE * slip.unsure)
    steps = np.column_stack(columns)
    unsure = np.array(usual)
    matrix = np.hstack([np.vstack([fitted.jacobian, np.diag(1.0 / scale)]), steps])
    priors = np.hstack([np.zeros((unsure.size, scale.size)), np.diag(1.0 / unsure)])
    left = np.concatenate([*fitted.residuals, (fitted.z - problem.start()) / scale, np.zeros(unsure.size)])
    moved = -np.linalg.lstsq(np.vstack([matrix, priors]), left, rcond=None)[0][scale.size :]
    before = np.array(sizes)
    better = iter(np.where(before * (before + moved) > 0.0, before + moved, 0.0))  # none turns round
    return [tuple(replace(slip, size=float(next(better))) for slip in latent.slips) for latent in problem.latents]


def _steps(
    experiment: Experiment,
    slips: Sequence[Slip],
    left: dict[str, Array],
    clear: float,
    apart: float,
    reaches: Sequence[float],
    swings: bool,
) -> list[Slip]:
    found: list[Slip] = []
    for name, rest in left.items():
        look = _Look(experiment, name, apart, swings)
        for reach in reaches:
            known = [slip.time for slip in (*slips, *found) if slip.channel == name]
            more = look.steps(rest, look.wide(reach), clear, known)
            rest = rest + sum((slip.size * slip.after(look.time) for slip in more), np.zeros(rest.size))
            found += more
    return found


def _seen_again(fitted: Fit) -> Fit:
    """The fit with the sizes of its slips as they are seen beside each other."""
    seen = []
    problem = fitted.problem
    swings = problem.model.roles.swings in problem.parameters.effects
    for experiment, latent, left in zip(problem.followed, problem.latents, fitted.left, strict=True):
        mine = []
        for slip in latent.slips:
            look = _Look(experiment, slip.channel, _APART_BESIDE, swings)
            at, wide = int(np.searchsorted(look.time, slip.time)), look.wide(_REACH)
            weights = look.weights(at, wide)
            step = 0.0 if weights is None else float(weights @ left[slip.channel][at - wide : at + wide])
            mine.append(replace(slip, size=slip.size - step))
        seen.append([slip for slip in mine if slip.size > 0.0])
    return _with(fitted, seen)


class _Look:
    """How one channel of a recording is looked at, for steps that are not its inputs' own; where a weight ``swings``,
    not at what is left of that."""

    def __init__(self, experiment: Experiment, name: str, apart: float, swings: bool) -> None:
        imposed, self.swings = experiment.imposed, swings
        self.name, self.time = name, experiment.observed[name].time
        self.period = float(np.median(np.diff(self.time))) if self.time.size > 1 else np.inf
        self.switches, self.loads = (_jumps(imposed.time, value) for value in (imposed.drive, imposed.load))
        self.own = distance(self.time, np.union1d(self.switches, self.loads)) < apart

    def wide(self, reach: float) -> int:
        """How many samples either side of a step are looked at."""
        return int(np.clip(round(reach / self.period), _FEWEST, _MOST))

    def steps(self, left: Array, wide: int, clear: float, known: Sequence[float]) -> list[Slip]:
        """The sudden steps in what is left, apart from those known."""
        step, height = np.zeros(self.time.size), np.zeros(self.time.size)
        calm = np.zeros(self.time.size, dtype=bool)
        elsewhere = distance(self.time, np.sort(known)) >= _SAMPLES_APART * self.period
        for at in np.flatnonzero(elsewhere).tolist():
            weights = self.weights(at, wide)
            if weights is not None:
                calm[at] = weights is _even(wide)
                step[at] = weights @ left[at - wide : at + wide]
                height[at] = abs(step[at]) / np.sqrt(weights @ weights)
        for alike in (calm, ~calm):
            usual = height[alike & (height > 0.0)]
            height[alike] /= np.median(usual) / 0.6745 if usual.size > 3 * wide else np.inf
        found = []
        while height.size and height[at := int(height.argmax())] > clear:
            before, after = float(np.mean(left[at - 3 : at - 1])), float(np.mean(left[at + 1 : at + 3]))
            if (after - before) / step[at] > _SUDDEN:
                # Samples are means of what was read around them: of two beside the step, what part was read after it.
                share = float(np.sum(np.clip((left[at - 1 : at + 1] - before) / (after - before), 0.0, 1.0)))
                instant = float(self.time[at]) + (0.5 - share) * self.period
                unsure = float(abs(step[at]) / height[at])
                found.append(Slip(self.name, instant, -float(step[at]), unsure, 0.5 * self.period))
            height[max(at - 2 * wide, 0) : at + 2 * wide + 1] = 0.0
        return found

    def weights(self, at: int, wide: int) -> Array | None:
        """The weights by which the samples around one sum up to the step before it; None where some are missing, or an
        input has a step there."""
        if not wide <= at <= self.time.size - wide or self.own[at]:
            return None
        around = self.time[at - wide : at + wide]
        now, begin, end = self.time[at], around[0], around[-1]
        whole = end - begin < 1.3 * (2 * wide - 1) * self.period and now - self.time[at - 1] < 2.0 * self.period
        if not whole:
            return None
        switched = self.switches[(self.switches > begin - self.period) & (self.switches <= end + self.period)]
        loaded = self.loads[(self.loads > begin - _RINGS) & (self.loads <= end + self.period)]
        if self.swings and loaded.size:
            return None
        if not switched.size and not loaded.size:
            return _even(wide)
        return _step_among(around - now, switched - now, loaded - now)


@lru_cache(maxsize=64)
def _even(wide: int) -> Array:
    """As below, samples being as far apart as each other and no input having a step; beside a level if they are few."""
    if wide == _FEWEST:
        return np.repeat([-1.0 / wide, 1.0 / wide], wide)
    return _step_among(np.arange(-wide, wide).astype(float), np.empty(0), np.empty(0))


def _step_among(since: Array, switched: Array, loaded: Array) -> Array:
    """The weights by which samples sum up to the step at 0, beside a line that bends, and goes on bending, where the
    drive has a step, and breaks where the load has one; shape as ``since``."""
    ways = [np.ones(since.size), since, since >= 0.0]
    ways += [np.maximum(since - at, 0.0) for at in (*switched, *loaded)]
    ways += [np.maximum(since - at, 0.0) ** 2 for at in switched]
    ways += [since >= at for at in loaded]
    return np.asarray(np.linalg.pinv(np.column_stack(ways))[2])


def _jumps(time: Array, value: Array) -> Array:
    """When an input has a step."""
    span = float(np.ptp(value))
    return np.asarray(time[1:][np.abs(np.diff(value)) > _STEP * span]) if span > 0.0 else np.empty(0)
