"""What differs from run to run, allowed for: no model of one muscle predicts it, so none is asked to.

Where runs of one protocol differ from each other, every recording may err by a course of its own as large as they do,
on the time scales on which they do: Gaussian columns (see noise/discrepancy.py). Only what recordings have in common
beyond that can then be evidence for an effect.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.generic import hats
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.hypothesis.problem import Shown
from tcp_muscle_ros.diagnosis.noise.discrepancy import Allowance
from tcp_muscle_ros.diagnosis.noise.noise import over_all, quick_noise
from tcp_muscle_ros.diagnosis.noise.repeatability import SCALES, Repeatability, between_runs
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle.arrays import Array

# Between knots a piecewise linear course has half the variance that it has at them: two thirds in the mean.
_AT_KNOTS = float(np.sqrt(1.5))
_LEAST_SAMPLES = 2.0  # between two knots
_MOSTLY = 0.5  # of a variance
BEYOND_NOISE = 3.0  # times the noise: runs that differ by more differ by something else


def repeating(fitted: Fit) -> dict[str, Repeatability]:
    """How well runs of one protocol repeat each other, by channel, beside what the fitted muscle does differently in
    each: one that flows or wears, or is in another room, is still one muscle.

    Where one channel alone was recorded, nothing else shows the room that a fit infers: then as it was read.
    """
    return between_runs(fitted.problem.followed, fitted.predictions if _seen_twice(fitted) else _as_read(fitted))


def _seen_twice(fitted: Fit) -> bool:
    return any(len(e.observed) > 1 for e in fitted.problem.experiments)


def _as_read(fitted: Fit) -> list[Shown]:
    """What the typical muscle of its age shows in each recording, with nothing that is inferred of that one alone."""
    problem = fitted.problem
    aged = (Latent(latent.before, switched=latent.switched) for latent in problem.latents)
    typical = replace(problem, parameters=fitted.muscle, latents=tuple(aged))
    return [typical.predict({}, k) for k in range(len(problem.experiments))]


def differing(fitted: Fit, repeated: Mapping[str, Repeatability]) -> list[str]:
    """The channels in which runs of one protocol differ by more than the noise, the model misses more than it, and most
    of the difference is none that the model foretells: what is left of one that it does is its form's."""
    experiments = fitted.problem.experiments
    noise = over_all(experiments, quick_noise(experiments))
    as_they_are = between_runs(fitted.problem.followed)
    return [
        name
        for name, found in repeated.items()
        if min(found.own_gain * found.peak, float(np.sqrt(fitted.mean_square[name]))) > BEYOND_NOISE * noise[name]
        and found.own_gain**2 > _MOSTLY * as_they_are[name].own_gain ** 2
    ]


def allowing(fitted: Fit, repeated: Mapping[str, Repeatability]) -> Fit:
    """The same fit, in which each recording may err by what runs of one protocol do not share."""
    problem, latents = fitted.problem, []
    for experiment, latent in zip(problem.experiments, problem.latents, strict=True):
        allowed = {
            name: _allowing(latent.allowance(name), observed, repeated[name])
            for name, observed in experiment.observed.items()
            if name in repeated
        }
        latents.append(replace(latent, allowances={**latent.allowances, **allowed}))
    return refitted(fitted, problem.with_latents(latents))


def _allowing(allowed: Allowance, observed: Observed, shares: Repeatability) -> Allowance:
    """Courses of its own of each scale that is slow enough to be seen; what is quicker is noise."""
    peak = float(np.ptp(observed.value))
    quick, *slow = (0.0 if np.isnan(share) else share * peak for share in shares.by_scale)
    columns = [_courses(observed.time, scale) * size for scale, size in zip(SCALES, slow, strict=True)]
    return replace(allowed, runs=np.hstack(columns), apart=quick)


def _courses(time: Array, scale: float) -> Array:
    """Piecewise linear functions of unit size with knots ``scale`` (s) apart, shape (m, knots)."""
    apart = max(scale, _LEAST_SAMPLES * float(np.median(np.diff(time))))
    count = max(int(np.ceil((time[-1] - time[0]) / apart)) + 1, 2)
    return hats(time, np.linspace(time[0], time[-1], count)) * _AT_KNOTS
