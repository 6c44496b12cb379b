"""Calibrate: fit the paper's parameters to a given muscle, say how surely, and which the data do not fix.

Noise and parameters are estimated in turn: the first fit weighs by the sensors' quick noise, the next by size and
colour of what the model leaves over, so that a model that does not fit well does not claim narrow intervals.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.as_assumed import as_assumed
from tcp_muscle_ros.diagnosis.fitting.least_squares import WIDTH, Fit, fit
from tcp_muscle_ros.diagnosis.fitting.warm_start import begun_warm
from tcp_muscle_ros.diagnosis.fitting.weighing import each_by_its_noise
from tcp_muscle_ros.diagnosis.hypothesis.latents import Before, Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import base_unknowns
from tcp_muscle_ros.diagnosis.model.model import Model, floating
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, FACTOR, START, Unknown
from tcp_muscle_ros.diagnosis.noise.noise import Noise, estimate, quick_noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.muscle.arrays import Array

_FACTORS = (0.125, 0.35, 1.0, 2.8, 8.0)
# Evaluations at most. Three channels need some twenty; where the stroke alone is recorded, heat exchange, capacity and
# gain trade against each other, and a fit goes along that valley for a hundred.
_FREELY, _BRIEFLY = 200, 60


@dataclass(frozen=True)
class Estimate:
    """One calibrated parameter: SI, 90 % interval. ``partner``: what it trades against where it is not fixed."""

    name: str
    recording: int | None
    nominal: float
    value: float
    low: float
    high: float
    unit: str
    fixed: bool
    at_bound: bool
    partner: str | None


@dataclass(frozen=True)
class Known:
    """How well a muscle is known: estimates, and the covariance of what all recordings share (``unknowns``), in the
    fit's coordinates."""

    estimates: tuple[Estimate, ...]
    unknowns: tuple[Unknown, ...]
    covariance: Array


@dataclass(frozen=True)
class Calibration:
    """A calibrated muscle: the fit, each estimate, and ratios that are fixed even where their members are not."""

    fit: Fit
    estimates: tuple[Estimate, ...]
    combinations: tuple[Estimate, ...]

    @property
    def held_by_melting(self) -> bool:
        """Whether the data want the fibre hotter than a muscle survives: hA and the gain are then that limit's."""
        return any(float(part[-1]) > 0.0 for part in self.fit.residuals)

    @cached_property
    def parameters(self) -> Parameters:
        """The calibrated muscle; what the data do not fix is as assumed, where the rest fits as well so."""
        return as_assumed(self.fit).muscle

    @property
    def known(self) -> Known:
        """How well it is known."""
        unknowns, covariance = in_one(self.fit, self.fit.covariance)
        return Known((*self.estimates, *self.combinations), tuple(unknowns), covariance)

    def rmse(self) -> dict[str, list[float]]:
        """Root mean square misfit (SI) of single samples by channel, one entry a recording (nan where it was not
        observed). Where these were averaged for the fit, what they scatter about their means counts too, as in a
        replay."""
        problem = self.fit.problem
        channels = sorted({name for e in problem.experiments for name in e.observed})
        found: dict[str, list[float]] = {name: [] for name in channels}
        for experiment, left in zip(problem.experiments, self.fit.left, strict=True):
            for name in channels:
                square = np.mean(left[name] ** 2) + experiment.observed[name].within if name in left else np.nan
                found[name].append(float(np.sqrt(square)))
        return found


def calibrate(
    experiments: Sequence[Experiment],
    nominal: Parameters,
    *,
    latents: Sequence[Latent] = (),
    separate: Sequence[str] = (),
    rounds: int = 3,
    progress: Callable[[], None] | None = None,
) -> Calibration:
    """Fit the paper's parameters to recordings of one muscle.

    Args:
        experiments: prepared recordings.
        nominal: where to start; effects that are on stay on with their parameters as given.
        latents: what is already inferred of each of them; default nothing.
        separate: parameters that each recording has for itself (such as ``B`` where every run is another specimen).
        rounds: how often noise and parameters are estimated in turn.
        progress: called at every evaluation of the model.
    """
    bare = Problem(tuple(experiments), nominal, (), quick_noise(experiments), tuple(latents))
    unknowns = base_unknowns(bare.followed, nominal, dict.fromkeys(separate, True))
    problem = replace(bare, unknowns=tuple(unknowns))
    freely = partial(fit, rounds=_FREELY, progress=progress)
    briefly = partial(fit, rounds=_BRIEFLY, progress=progress)
    cold = freely(problem, coarse_start(problem))
    if rounds > 1:
        cold = under_what_is_left(_begun_twice(cold, freely), briefly, rounds - 2)
    fitted = begun_warm(cold, freely, coarse_start)
    if fitted is not cold:
        fitted = under_what_is_left(fitted, briefly, rounds - 1)
    for _ in range(2):  # by weights that are nearer, the noise of each recording is told better
        weighed = each_by_its_noise(fitted)
        if weighed is not fitted:
            fitted = under_what_is_left(weighed, briefly)
    problem = fitted.problem
    found = estimates(problem.model, problem.unknowns, fitted.z, fitted.covariance)
    return Calibration(fitted, tuple(found), tuple(_combinations(fitted)))


def in_one(fitted: Fit, covariance: Array) -> tuple[list[Unknown], Array]:
    """What a muscle has for all recordings, and its covariance, for a further recording of it.

    A parameter that each recording has for itself is the mean of these, as unsure as they differ beside that. What is
    of single recordings only is in none.
    """
    unknowns, z = fitted.problem.unknowns, fitted.z
    own = {name for name in fitted.problem.model.specifications if '.' not in name}
    members: dict[str, list[int]] = {}
    for k, u in enumerate(unknowns):
        if u.recording is None or u.name in own:
            members.setdefault(u.name, []).append(k)
    mean = np.zeros((len(members), len(unknowns)))
    differs = np.zeros(len(members))
    for row, mine in enumerate(members.values()):
        mean[row, mine] = 1.0 / len(mine)
        differs[row] = np.var(z[mine], ddof=1) if len(mine) > 1 else 0.0
    found = [replace(unknowns[mine[0]], recording=None) for mine in members.values()]
    return found, mean @ covariance @ mean.T + np.diag(differs)


def _begun_twice(fitted: Fit, fitting: Callable[..., Fit]) -> Fit:
    """The fit under the noise that it leaves, begun where it was and at the coarse start of that.

    The noise of single readings makes walls of what the model misses, between which the first fit may be caught.
    """
    problem = fitted.problem.with_noise(left_over_noise(fitted))
    begun = [fitting(problem, fitted.z, known=fitted.rough_slopes), fitting(problem, coarse_start(problem))]
    return min(begun, key=lambda f: f.objective)


def under_what_is_left(fitted: Fit, fitting: Callable[..., Fit], times: int = 1) -> Fit:
    """The fit under the noise that it leaves, both estimated in turn so often."""
    for _ in range(times):
        again = fitted.problem.with_noise(left_over_noise(fitted))
        fitted = fitting(again, fitted.z, known=fitted.rough_slopes)
    return fitted


def in_turn(fitted: Fit) -> Fit:
    """The same fit of recordings before which the muscle went through those before them."""
    problem, latents = fitted.problem, []
    for latent, before in zip(problem.latents, ages(problem.experiments, fitted.outputs), strict=True):
        latents.append(replace(latent, before=before))
    turned = problem.with_latents(latents)
    # Of a muscle that ages already, what it shows is not what it showed as if it were new each time.
    return fit(turned, fitted.z, rounds=0) if turned.ages else replace(fitted, problem=turned)


def ages(experiments: Sequence[Experiment], outputs: Sequence[Outputs]) -> list[Before]:
    """What one muscle went through before each of its recordings, one after the other; ``outputs`` of each of them, or
    of all but the last."""
    found = [Before()]
    for experiment, shown in zip(experiments, outputs, strict=False):
        found.append(found[-1].then(getattr(shown, experiment.model.state), experiment.duration))
    return found[: len(experiments)]


def left_over_noise(fitted: Fit) -> dict[str, Noise]:
    """Size and colour of each channel's residuals, pooled over recordings."""
    problem = fitted.problem
    floor = quick_noise(problem.experiments)
    pooled: dict[str, list[Noise]] = {name: [] for name in floor}
    weights: dict[str, list[int]] = {name: [] for name in floor}
    for mine in fitted.weighed:
        for name, left in mine.items():
            pooled[name].append(estimate(left, 0.0))
            weights[name].append(left.size)
    return {
        name: Noise(
            max(float(np.sqrt(np.average([n.sigma**2 for n in found], weights=weights[name]))), floor[name].sigma),
            float(np.average([n.phi for n in found], weights=weights[name])),
        )
        for name, found in pooled.items()
    }


def coarse_start(problem: Problem) -> Array:
    """A start within reach of the optimum: the best of a grid over what may be far off (``Model.coarse``), the gain
    scaled to the motion.

    A nominal value may be wrong eightfold, from where a local search need not find home.
    """
    names = [u.name for u in problem.unknowns]
    best, best_misfit = problem.start(), np.inf
    for factors in product(_FACTORS, repeat=len(problem.model.coarse)):
        shifts, z = dict(zip(problem.model.coarse, factors, strict=True)), problem.start()
        for k, name in enumerate(names):
            if name in shifts:
                u = problem.unknowns[k]
                z[k] = u.to_fit(min(max(u.start * shifts[name], u.low), u.high))
        z = _scale_stroke(problem, z)
        parts = problem.residuals(problem.predictions(z))
        misfit = float(sum(np.sum(np.minimum(part**2, 1e8)) for part in parts))
        if np.isfinite(misfit) and misfit < best_misfit:
            best, best_misfit = z, misfit
    return best


def _scale_stroke(problem: Problem, z: Array) -> Array:
    """Move the stroke gain(s) so that the predicted span of displacement or force is the recorded one."""
    out = np.array(z)
    values = problem.values(z)
    ratios: dict[int, float] = {}
    for k, experiment in enumerate(problem.experiments):
        predicted = problem.predict(values, k)
        for name in floating(problem.model):
            if name in experiment.observed:
                made = float(np.ptp(predicted[name]))
                if made > 0.0:
                    ratios[k] = float(np.ptp(experiment.observed[name].value)) / made
    if not ratios:
        return out
    common = float(np.exp(np.mean(np.log([max(r, 1e-6) for r in ratios.values()]))))
    for k, unknown in enumerate(problem.unknowns):
        if unknown.name == problem.model.gain:
            ratio = common if unknown.recording is None else ratios.get(unknown.recording, 1.0)
            value = unknown.from_fit(float(z[k])) * max(ratio, 1e-6)
            out[k] = unknown.to_fit(min(max(value, unknown.low), unknown.high))
    return out


def unit_of(model: Model, name: str) -> str:
    """The unit of an unknown inside: that of the state for what belongs to a recording."""
    return model.state_unit if name in (AMBIENT, START) else model.specifications[name].unit


def estimates(
    model: Model, unknowns: Sequence[Unknown], z: Array, covariance: Array, beside: Array | float = 0.0
) -> list[Estimate]:
    """Each unknown at ``z`` with its interval, and what it trades against where it is not fixed.

    ``beside``: a further standard deviation of each, in the fit's coordinate, of which their errors share nothing.
    """
    spread = np.sqrt(np.diag(covariance))
    wide = np.hypot(spread, beside)
    correlation = covariance / np.maximum(np.outer(spread, spread), 1e-300)
    found = []
    for k, unknown in enumerate(unknowns):
        strongest = np.abs(correlation[k])
        strongest[k] = 0.0
        other = int(np.argmax(strongest))
        partner = _label(unknowns[other]) if strongest[other] > 0.7 else None
        value = unknown.from_fit(float(z[k]))
        at_bound = bool(np.isclose(value, unknown.low, rtol=1e-4) or np.isclose(value, unknown.high, rtol=1e-4))
        found.append(
            Estimate(
                unknown.name,
                unknown.recording,
                unknown.start,
                value,
                unknown.from_fit(float(z[k] - WIDTH * wide[k])),
                unknown.from_fit(float(z[k] + WIDTH * wide[k])),
                unit_of(model, unknown.name),
                unknown.fixed_by(float(spread[k])),
                at_bound,
                partner,
            )
        )
    return found


def _label(unknown: Unknown) -> str:
    return unknown.name if unknown.recording is None else f'{unknown.name} of recording {unknown.recording + 1}'


def _combinations(fitted: Fit) -> list[Estimate]:
    """Ratios of parameters: sums of logarithms, so that their interval is exact."""
    problem = fitted.problem
    place = {u.key: k for k, u in enumerate(problem.unknowns)}
    found = []
    for ratio in problem.model.ratios:
        for key, k in place.items():
            if key[0] != ratio.top:
                continue
            below = place.get((ratio.bottom, key[1]), place.get((ratio.bottom, None)))
            if below is None:
                continue
            weights = np.zeros(len(place))
            weights[k], weights[below] = 1.0, -1.0
            centre = float(weights @ fitted.z)
            spread = float(np.sqrt(weights @ fitted.covariance @ weights))
            nominal = problem.unknowns[k].start / problem.unknowns[below].start
            low, high = np.exp(centre - WIDTH * spread), np.exp(centre + WIDTH * spread)
            fixed = spread < FACTOR
            found.append(
                Estimate(
                    ratio.name,
                    key[1],
                    nominal,
                    float(np.exp(centre)),
                    float(low),
                    float(high),
                    ratio.unit,
                    fixed,
                    False,
                    None,
                )
            )
    return found
