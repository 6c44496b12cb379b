"""What a channel weighs: the noise that a fit leaves, with what it misses, and the same fit under another noise."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.generic import Structure, drivers, structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit, fit
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.noise.noise import Noise, quick_noise
from tcp_muscle_ros.diagnosis.noise.replicates import done_twice, pure_error


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
        times = [problem.experiments[k].observed[name].time for k in owners]
        drive = [drivers(problem.followed[k], outputs[k], t) for k, t in zip(owners, times, strict=True)]
        mine = [left[k][name] for k in owners]
        averaged = float(np.mean(np.concatenate([problem.experiments[k].observed[name].count for k in owners])))
        repeated = pure_error(problem.experiments, left, name, twice)
        found[name] = structure(
            mine, times, drive, floor[name], repeated, averaged, problem.model.channels[name], most_of_single=most
        )
    return found


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
