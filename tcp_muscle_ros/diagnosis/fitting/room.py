"""What a room warmer than it was read does to what a recording shows, and what the instruments may have missed."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import refitted
from tcp_muscle_ros.diagnosis.hypothesis.latents import Draught
from tcp_muscle_ros.diagnosis.hypothesis.problem import Shown
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array

_ECHO = 6.0  # thermal time constants, after which nothing is left of a change
_STEP, _WORKERS = 1.0, 2  # K
_INSTANT = 3e-3  # s, to which a log knows when a sensor read: messages are a few milliseconds on their way
_APART, _MOST = 20.0, 40  # s between the knots of what a thermometer may have missed; and how many at most


def thermal_lag(fitted: Fit) -> float:
    """The thermal time constant, s."""
    return fitted.problem.model.time_constant(fitted.muscle)


def knots_of(experiment: Experiment, apart: float, most: int) -> Array:
    """Instants so far ``apart`` (s) or farther, from the first to the last of a recording."""
    count = int(np.clip(experiment.duration / apart, 8, most))
    return np.linspace(experiment.imposed.time[0], experiment.imposed.time[-1], count)


def responses(fitted: Fit, k: int, knots: Array) -> Shown:
    """What a warmer room at each knot changes of what one recording shows (SI/K), by channel, shape (m, knots).

    Knots so far apart that nothing is left of one when the next begins are told from each other in one run.
    """
    problem, experiment = fitted.problem, fitted.problem.followed[k]
    base, values = fitted.predictions[k], fitted.values
    latent = problem.latents[k]
    draught = latent.draught or Draught(knots, np.zeros(experiment.imposed.time.size))
    apart = knots[1] - knots[0]
    every = int(np.ceil(_ECHO * thermal_lag(fitted) / apart)) + 2
    turn = np.arange(knots.size) % every

    def columns(first: int) -> Shown:
        warmer = replace(
            draught, warmer=draught.warmer + _STEP * np.interp(experiment.imposed.time, knots, turn == first)
        )
        return problem.with_latent(replace(latent, draught=warmer), k).predict(values, k)

    with ThreadPoolExecutor(_WORKERS) as pool:
        moved = list(pool.map(columns, range(min(every, knots.size))))
    found = {}
    for name, shown in base.items():
        found[name] = np.column_stack([(moved[j][name] - shown) / _STEP for j in turn])
        if name in experiment.observed:
            since = experiment.observed[name].time[:, None] - (knots - apart)
            found[name][(since < 0.0) | (since >= every * apart)] = 0.0
    return found


def persisting(knots: Array, pace: float) -> Array:
    """The factor L of the covariance L L' of a course of size 1 that forgets itself at a pace (s; an
    Ornstein-Uhlenbeck process), (knots, knots)."""
    return np.linalg.cholesky(np.exp(-np.abs(knots[:, None] - knots) / pace))


def as_well_as_read(fitted: Fit, wandering: bool = False) -> Fit:
    """The same fit, in which each recording may err by what its instruments do not tell: the room by what the steps and
    the noise of its thermometer hide, every channel by a little in its instants.

    A stroke of a millimetre a kelvin shows a hundredth of a kelvin, and physics would be found to explain it.
    ``wandering``: rooms that no thermometer read went their own ways, as rooms do.
    """
    problem, latents = fitted.problem, []
    for k, (experiment, latent) in enumerate(zip(problem.followed, problem.latents, strict=True)):
        late = {
            name: _INSTANT * np.gradient(fitted.predictions[k][name], o.time)[:, None]
            for name, o in experiment.observed.items()
            if o.time.size > 1
        }
        knots = knots_of(experiment, _APART, _MOST)
        usual, together = _usual(experiment, knots, wandering), {}
        if usual is not None:
            warmer = responses(fitted, k, knots)
            together = {AMBIENT: usual, **{name: warmer[name] @ usual for name in experiment.observed}}
        allowed = {name: replace(latent.allowance(name), readings=mine) for name, mine in late.items()}
        latents.append(replace(latent, allowances={**latent.allowances, **allowed}, together=together))
    return refitted(fitted, problem.with_latents(latents))


def wandered(fitted: Fit) -> float:
    """How far the rooms of a fit that are expected to go their own ways most likely did, from the coldest to the
    warmest of each recording, K (root mean square over those)."""
    problem, ranges = fitted.problem, []
    for k, left in enumerate(fitted.left):
        course = problem.shared_error(left, k, frozenset(left)).get(AMBIENT)
        if course is not None and problem.experiments[k].imposed.unread:
            ranges.append(float(np.ptp(course)))
    return float(np.sqrt(np.mean(np.square(ranges)))) if ranges else 0.0


def _usual(experiment: Experiment, knots: Array, wandering: bool) -> Array | None:
    """The factor L of the covariance L L' of what is unknown of a room at the knots (K), (knots, knots); None where
    nothing is: of one that was read, each reading errs by itself."""
    imposed, room = experiment.imposed, experiment.model.surroundings
    if wandering and imposed.unread and room.wander > 0.0:
        return room.wander * persisting(knots, room.pace)
    return imposed.unsure * np.eye(knots.size) if imposed.unsure > 0.0 else None
