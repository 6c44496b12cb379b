"""What a channel weighs: the noise that a fit leaves, with what it misses, and the same fit under another noise."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.generic import Structure, drivers, structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.noise.noise import Noise, quick_noise
from tcp_muscle_ros.diagnosis.noise.replicates import done_twice, pure_error
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.muscle.arrays import Array

_UNLIKE = 4.0  # times as many samples: means of fewer do not scatter half as much at best, and one noise serves all


@lru_cache(maxsize=8)
def structures(fitted: Fit) -> dict[str, Structure]:
    """The generic model of what a fit leaves, by channel."""
    problem = fitted.problem
    outputs, left = fitted.outputs, fitted.weighed
    floor, twice = _floor(problem), done_twice(problem.followed)
    most = problem.policy.single_readings
    found = {}
    for name in sorted({n for e in problem.experiments for n in e.observed}):
        owners = [k for k, e in enumerate(problem.experiments) if name in e.observed]
        seen = [problem.experiments[k].observed[name] for k in owners]
        times = [o.time for o in seen]
        drive = [drivers(problem.followed[k], outputs[k], t) for k, t in zip(owners, times, strict=True)]
        mine = [left[k][name] for k in owners]
        averaged = float(np.mean(np.concatenate([o.count for o in seen])))
        repeated = pure_error(problem.experiments, left, name, twice)
        found[name] = structure(
            mine,
            times,
            drive,
            floor[name],
            repeated,
            averaged,
            problem.model.channels[name],
            most_of_single=most,
            beside=[o.beside for o in seen],
        )
    return found


def each_by_its_noise(fitted: Fit) -> Fit:
    """The same fit, in which the values of a channel weigh by the noise of their own recording, where they are means of
    far more samples in one than in another; else the fit itself.

    Means of n samples scatter by a root of n less where that is white, and hardly less where it is slow. Counts do not
    tell which, nor do second differences, which see only what is quick: by either, a recording that is averaged much
    would outweigh the others by what it does not have. What the generic model leaves of each holds both. It is believed
    as far as counts explain it: what differs beyond that is misfit, or chance.
    """
    problem = fitted.problem
    unlike = {name: count for name, count in _counts(problem).items() if count.max() >= _UNLIKE * count.min()}
    if not unlike:
        return fitted
    found = structures(fitted)
    weighs: list[dict[str, float]] = [{} for _ in problem.experiments]
    for name, count in unlike.items():
        owners = [k for k, e in enumerate(problem.experiments) if name in e.observed]
        seen = [problem.experiments[k].observed[name] for k in owners]
        sizes = [left / o.beside for left, o in zip(found[name].own, seen, strict=True)]
        # The generic model may follow the noise of a few values.
        least = [max(white_sigma(o.value, o.swinging), 1e-12) for o in seen]
        noise, most = np.log(np.maximum(sizes, least)), 0.5 * np.log(count / np.median(count))
        quieter = np.clip(np.median(noise) - noise, np.minimum(most, 0.0), np.maximum(most, 0.0))
        for k, much in zip(owners, quieter, strict=True):
            weighs[k][name] = float(np.exp(much))
    return refitted(fitted, problem.weighing(weighs))


def _counts(problem: Problem) -> dict[str, Array]:
    """How many samples a usual value of each channel is the mean of, one entry a recording that has it."""
    counts: dict[str, list[float]] = {}
    for experiment in problem.experiments:
        for name, observed in experiment.observed.items():
            counts.setdefault(name, []).append(float(np.median(observed.count)))
    return {name: np.array(found) for name, found in counts.items()}


def _floor(problem: Problem) -> dict[str, float]:
    """The quick noise (SI) of each channel, with what differs from run to run as quickly."""
    return {
        name: float(np.hypot(n.sigma, np.median([latent.allowance(name).apart for latent in problem.latents])))
        for name, n in quick_noise(problem.experiments).items()
    }


def robust_noise(fitted: Fit, found: dict[str, Structure]) -> dict[str, Noise]:
    """The noise by channel, with what its colour does not cover added to its size, and what the fit misses too.

    A channel that a model cannot follow must not pull the others along: the temperature would be bent until the stroke
    fits. Its weight returns as effects are accepted.
    """
    return {
        name: Noise(max(s.noise.sigma * float(np.sqrt(s.inflation)), fitted.mean_square[name] ** 0.5), s.noise.phi)
        for name, s in found.items()
    }


def with_noise(fitted: Fit, noise: dict[str, Noise]) -> Fit:
    """The same fit under another noise."""
    return refitted(fitted, fitted.problem.with_noise(noise))


def refitted(fitted: Fit, problem: Problem) -> Fit:
    """The fit of a problem that weighs the same data otherwise, from where they were fitted."""
    return fit(problem, fitted.z, rounds=20, tolerance=1e-5, known=fitted.rough_slopes)


def calmed(fitted: Fit, swings: Fit) -> Fit:
    """The same fit with samples during a swing weighing as little as a model that swings misses them beside the others.

    No form of a swing keeps its phase to within the noise; what is left of it would drown all that is slow.
    """
    problem, latents = fitted.problem, []
    for experiment, latent, left in zip(problem.experiments, problem.latents, swings.left, strict=True):
        allowances = dict(latent.allowances)
        for name, o in experiment.observed.items():
            if o.swinging is not None and not o.swinging.all():
                still, moving = (float(np.mean(left[name][part] ** 2)) for part in (~o.swinging, o.swinging))
                calm = min(1.0, float(np.sqrt(still / max(moving, 1e-300))))
                allowances[name] = replace(latent.allowance(name), calm=calm)
        latents.append(replace(latent, allowances=allowances))
    return refitted(fitted, problem.with_latents(latents))


def settle_noise(fitted: Fit, rounds: int = 2) -> tuple[Fit, dict[str, Structure]]:
    """Refit with the noise that the generic model leaves, until both agree."""
    found = structures(fitted)
    for _ in range(rounds):
        fitted = with_noise(fitted, robust_noise(fitted, found))
        found = structures(fitted)
    return fitted, found
