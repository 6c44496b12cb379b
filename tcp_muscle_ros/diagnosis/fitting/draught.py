"""The course of a draught: how much more heat each recording lost at which time, given all else that the model says.

One gust is a name, not the weather. Once it is named, its course is inferred: the conductance is a factor 1 + w over
its usual value, w smooth in time and unknown but for its usual size. A conductance so much larger takes as much heat
as a room that is w (T - Tinf) cooler, so that the model needs no other equation.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.generic import hats
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.room import knots_of, responses, thermal_lag
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted, settle_noise
from tcp_muscle_ros.diagnosis.hypothesis.latents import Draught
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array

_APART, _MOST = 0.125, 400  # thermal time constants between the knots of a course; and how many at most
_USUAL, _GUST = 0.5, 6.0  # the size of w; s over which it is much the same
_LEAST = -0.8  # of w: no air is so still that nothing is lost
_UNSURE, _BLURRED = 0.15, 4.0  # of w, that stays unknown; s over which it is
_ROUNDS, _STEPS = 2, 3  # how often the responses are computed; steps by one of them
_COLD = 0.5  # K over the room, below which no draught shows
_WARM, _DRIVEN = 0.2, 0.1  # of the largest excess over the room, above which one shows well; of the largest drive


def with_course(fitted: Fit) -> Fit:
    """The same fit with the course of the draught in every recording."""
    if all(latent.draught is not None for latent in fitted.problem.latents):
        return fitted
    gust = tuple(
        float(z) for z, u in zip(fitted.z, fitted.problem.unknowns, strict=True) if _is_gust(fitted.problem, u.name)
    )
    still = [_still(e, _APART * thermal_lag(fitted), gust) for e in fitted.problem.followed]
    fitted = _blown(fitted, still)
    for _ in range(_ROUNDS):
        shown = [responses(fitted, k, course.knots) for k, course in enumerate(still)]
        for _ in range(_STEPS):
            fitted, _ = settle_noise(_blown(fitted, [_step(fitted, k, mine) for k, mine in enumerate(shown)]), 1)
    return fitted


def without_course(fitted: Fit) -> Fit:
    """The same fit without: the gust is what it was before its course was inferred."""
    problem = fitted.problem
    remembered = next((latent.draught.gust for latent in problem.latents if latent.draught is not None), None)
    if remembered is None:
        return fitted
    z = fitted.z.copy()
    own = [k for k, u in enumerate(problem.unknowns) if _is_gust(problem, u.name)]
    if len(own) == len(remembered):
        z[own] = remembered
    return _blown(replace(fitted, z=z, near=None), [None] * len(problem.experiments))


def strength(fitted: Fit) -> tuple[float, float]:
    """How strong the courses of all recordings are while the drive is on and while it is off and the muscle still warm:
    root mean squares of w about its mean; nothing where a recording has no such time."""
    on, off = [], []
    for k, (experiment, latent) in enumerate(zip(fitted.problem.followed, fitted.problem.latents, strict=True)):
        if latent.draught is None:
            continue
        excess = _excess(fitted, k)
        share = -latent.draught.warmer / np.maximum(excess, _COLD)
        warm = excess > _WARM * float(np.max(excess))
        driven = np.abs(experiment.imposed.drive) > _DRIVEN * float(np.max(np.abs(experiment.imposed.drive)))
        on.append(share[warm & driven])
        off.append(share[warm & ~driven])
    return _spread(on), _spread(off)


def _spread(parts: Sequence[Array]) -> float:
    values = np.concatenate(parts)
    return float(np.std(values)) if values.size else 0.0


def _is_gust(problem: Problem, name: str) -> bool:
    return name.startswith(f'{problem.model.roles.course}.')


def _blown(fitted: Fit, courses: Sequence[Draught | None]) -> Fit:
    latents = [replace(latent, draught=d) for latent, d in zip(fitted.problem.latents, courses, strict=True)]
    return refitted(fitted, fitted.problem.with_latents(latents))


def _still(experiment: Experiment, apart: float, gust: tuple[float, ...]) -> Draught:
    return Draught(knots_of(experiment, apart, _MOST), np.zeros(experiment.imposed.time.size), gust)


def _excess(fitted: Fit, k: int) -> Array:
    """The fibre's temperature over the room's (K), without any draught's share."""
    outputs, experiment = fitted.outputs[k], fitted.problem.followed[k]
    ambient = fitted.values.get((AMBIENT, k))
    state = getattr(outputs, experiment.model.state)
    return np.asarray(state - (experiment.imposed.ambient if ambient is None else ambient))


def _step(fitted: Fit, k: int, warmer: Shown) -> Draught:
    """The most likely course, in linear approximation."""
    experiment, draught = fitted.problem.followed[k], fitted.problem.latents[k].draught
    assert draught is not None
    time, knots = experiment.imposed.time, draught.knots
    excess = np.maximum(np.interp(knots, time, _excess(fitted, k)), _COLD)
    had = -np.interp(knots, time, draught.warmer) / excess
    shown = {name: -mine * excess for name, mine in warmer.items()}
    columns, alike = fitted.problem.columns(shown, k), _persisting(knots)
    pull = columns.T @ fitted.residuals[k] + alike @ had
    share = np.maximum(had - np.linalg.solve(columns.T @ columns + alike, pull), _LEAST)
    blurred = hats(knots, knots_of(experiment, max(_BLURRED, knots[1] - knots[0]), _MOST))
    return replace(
        draught,
        warmer=-np.interp(time, knots, share * excess),
        unsure={name: _UNSURE * (mine @ blurred) for name, mine in shown.items()},
    )


def _persisting(knots: Array) -> Array:
    """The precision of a course that forgets itself within a gust (an Ornstein-Uhlenbeck process), (knots, knots)."""
    kept = float(np.exp(-(knots[1] - knots[0]) / _GUST))
    own = np.full(knots.size, 1.0 + kept**2)
    own[[0, -1]] = 1.0
    beside = np.full(knots.size - 1, -kept)
    precision: Array = np.diag(own) + np.diag(beside, 1) + np.diag(beside, -1)
    return precision / ((1.0 - kept**2) * _USUAL**2)
