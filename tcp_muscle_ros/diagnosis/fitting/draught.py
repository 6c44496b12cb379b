"""The course of a draught, or of a room that drifts: how much more heat each recording lost at which time, given all
else that the model says.

One gust, or a cubic, is a name and not the weather. Once it is named, its course is inferred: the conductance is a
factor 1 + w over its usual value, or the room is warmer by w, and w is unknown but for its usual size and pace. A
conductance so much larger takes as much heat as a room that is w (T - Tinf) cooler, so that the model needs no other
equation.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.generic import hats
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.room import knots_of, persisting, responses, thermal_lag
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted, settle_noise
from tcp_muscle_ros.diagnosis.hypothesis.latents import Draught
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import driven
from tcp_muscle_ros.muscle.arrays import Array

_APART, _MOST = 0.125, 400  # thermal time constants between the knots of a course; and how many at most
_USUAL, _GUST = 0.5, 6.0  # of a draught: the size of w; s over which it is much the same
_DRIFTED, _SLOW = 1.0, 40.0  # of a room: the same, in K and s
_LEAST = -0.8  # of a draught's w: no air is so still that nothing is lost
_UNSURE, _BLURRED = 0.3, 4.0  # of the size, that stays unknown; s over which it is
_ROUNDS, _STEPS = 2, 3  # how often the responses are computed; steps by one of them
COLD = 0.5  # K over the room, below which no draught shows
_WARM = 0.2  # of the largest excess over the room, above which one shows well


def with_course(fitted: Fit, effects: Collection[str] | None = None) -> Fit:
    """The same fit with the course of the draught and of the room in every recording: of these ``effects``, None: of
    those that the fit has."""
    roles, on = fitted.problem.model.roles, fitted.problem.parameters.effects
    of = roles.inferred & frozenset(on if effects is None else effects)
    if all(latent.draught is not None and latent.draught.effects == of for latent in fitted.problem.latents):
        return fitted
    fitted = without_course(fitted)
    gust = tuple(float(fitted.z[k]) for k in _described(fitted.problem, of))
    still = [_still(e, _APART * thermal_lag(fitted), of, gust) for e in fitted.problem.followed]
    fitted = _blown(fitted, still)
    for _ in range(_ROUNDS):
        shown = [responses(fitted, k, course.knots) for k, course in enumerate(still)]
        for _ in range(_STEPS):
            fitted, _ = settle_noise(_blown(fitted, [_step(fitted, k, mine) for k, mine in enumerate(shown)]), 1)
    return fitted


def without_course(fitted: Fit) -> Fit:
    """The same fit without: the gust is what it was before its course was inferred."""
    problem = fitted.problem
    course = next((latent.draught for latent in problem.latents if latent.draught is not None), None)
    if course is None:
        return fitted
    z = fitted.z.copy()
    own = _described(problem, course.effects)
    if len(own) == len(course.gust):
        z[own] = course.gust
    return _blown(replace(fitted, z=z, near=None), [None] * len(problem.experiments))


def strength(fitted: Fit) -> tuple[float, float]:
    """How strong the courses of all recordings are while the drive is on and while it is off and the muscle still warm:
    root mean squares of w about its mean; nothing where a recording has no such time."""
    on, off = [], []
    for k, (experiment, latent) in enumerate(zip(fitted.problem.followed, fitted.problem.latents, strict=True)):
        if latent.draught is None:
            continue
        excess = excess_of(fitted, k)
        share = -latent.draught.warmer / np.maximum(excess, COLD)
        warm = excess > _WARM * float(np.max(excess))
        heats = driven(experiment.imposed.drive)
        on.append(share[warm & heats])
        off.append(share[warm & ~heats])
    return _spread(on), _spread(off)


def size(fitted: Fit) -> float:
    """How much warmer or colder than read the course makes the room, K (root mean square over all recordings)."""
    parts = [latent.draught.warmer for latent in fitted.problem.latents if latent.draught is not None]
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def _spread(parts: Sequence[Array]) -> float:
    values = np.concatenate(parts)
    return float(np.std(values)) if values.size else 0.0


def _described(problem: Problem, effects: Collection[str]) -> list[int]:
    """The places of the unknowns that describe a gust, or a drift."""
    return [k for k, u in enumerate(problem.unknowns) if u.name.partition('.')[0] in effects]


def _blown(fitted: Fit, courses: Sequence[Draught | None]) -> Fit:
    latents = [replace(latent, draught=d) for latent, d in zip(fitted.problem.latents, courses, strict=True)]
    return refitted(fitted, fitted.problem.with_latents(latents))


def _still(experiment: Experiment, apart: float, effects: frozenset[str], gust: tuple[float, ...]) -> Draught:
    knots = knots_of(experiment, apart, _MOST)
    return Draught(knots, np.zeros(experiment.imposed.time.size), effects, gust)


def excess_of(fitted: Fit, k: int) -> Array:
    """The fibre's temperature over the room's (K), without any draught's share."""
    outputs, experiment = fitted.outputs[k], fitted.problem.followed[k]
    ambient = fitted.values.get((AMBIENT, k))
    state = getattr(outputs, experiment.model.state)
    return np.asarray(state - (experiment.imposed.ambient if ambient is None else ambient))


def _step(fitted: Fit, k: int, shown: Shown) -> Draught:
    """The most likely course, in linear approximation."""
    experiment, draught = fitted.problem.followed[k], fitted.problem.latents[k].draught
    assert draught is not None
    time, knots = experiment.imposed.time, draught.knots
    excess = np.maximum(np.interp(knots, time, excess_of(fitted, k)), COLD)
    sizes = _sizes(fitted.problem, draught, excess)
    likely = np.hstack([size[:, None] * persisting(knots, pace) for size, pace in sizes])
    had = np.interp(knots, time, draught.warmer)
    columns = fitted.problem.columns(shown, k)
    ways = columns @ likely
    pull = ways.T @ (fitted.residuals[k] - columns @ had)
    warmer = -likely @ np.linalg.solve(ways.T @ ways + np.eye(ways.shape[1]), pull)
    if draught.effects == {fitted.problem.model.roles.course}:
        warmer = np.minimum(warmer, -_LEAST * excess)
    blurred = hats(knots, knots_of(experiment, max(_BLURRED, knots[1] - knots[0]), _MOST))
    unsure = {
        name: np.hstack([_UNSURE * ((mine * size) @ blurred) for size, _ in sizes]) for name, mine in shown.items()
    }
    return replace(draught, warmer=np.interp(time, knots, warmer), unsure=unsure)


def _sizes(problem: Problem, draught: Draught, excess: Array) -> list[tuple[Array, float]]:
    """Of a draught and of a room, as far as it is one, how much warmer it usually is (K) at each knot, and the pace."""
    of_draught, of_room = (_USUAL * excess, _GUST), (np.full(excess.size, _DRIFTED), _SLOW)
    roles = problem.model.roles
    return [size for effect, size in ((roles.course, of_draught), (roles.room, of_room)) if effect in draught.effects]
