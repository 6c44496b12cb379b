"""The course of a draught: how much more heat each recording lost at which time, given all else that the model says.

One gust is a name, not the weather. Once it is named, its course is inferred: the conductance is a factor 1 + w over
its usual value, w smooth in time and unknown but for its usual size. A conductance so much larger takes as much heat
as a room that is w (T - Tinf) cooler, so that the model needs no other equation.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.experiment import Draught, Experiment
from tcp_muscle_ros.diagnosis.fitting import Fit
from tcp_muscle_ros.diagnosis.generic import hats
from tcp_muscle_ros.diagnosis.unknowns import AMBIENT
from tcp_muscle_ros.diagnosis.weighing import refitted, settle_noise
from tcp_muscle_ros.muscle.arrays import Array

EFFECT = 'airflow'
_APART, _MOST = 4.0, 90  # s between the knots of a course; and how many at most
_USUAL = 0.5  # the size of w
_LEAST = -0.8  # of w: no air is so still that nothing is lost
_UNSURE = 0.15  # of w, that stays unknown
_ROUNDS = 4
_STEP, _WORKERS = 0.05, 2


def with_course(fitted: Fit) -> Fit:
    """The same fit with the course of the draught in every recording."""
    if all(e.draught is not None for e in fitted.problem.experiments):
        return fitted
    gust = tuple(float(z) for z, u in zip(fitted.z, fitted.problem.unknowns, strict=True) if _is_gust(u.name))
    fitted = _blown(fitted, [_still(e, gust) for e in fitted.problem.experiments])
    for _ in range(_ROUNDS):
        responses = [_responses(fitted, k) for k in range(len(fitted.problem.experiments))]
        fitted, _ = settle_noise(_blown(fitted, [_step(fitted, k, mine) for k, mine in enumerate(responses)]), 1)
    return fitted


def without_course(fitted: Fit) -> Fit:
    """The same fit without: the gust is what it was before its course was inferred."""
    problem = fitted.problem
    remembered = next((e.draught.gust for e in problem.experiments if e.draught is not None), None)
    if remembered is None:
        return fitted
    z = fitted.z.copy()
    own = [k for k, u in enumerate(problem.unknowns) if _is_gust(u.name)]
    if len(own) == len(remembered):
        z[own] = remembered
    return _blown(replace(fitted, z=z, near=None), [None] * len(problem.experiments))


def _is_gust(name: str) -> bool:
    return name.startswith(f'{EFFECT}.')


def _blown(fitted: Fit, courses: Sequence[Draught | None]) -> Fit:
    experiments = tuple(replace(e, draught=d) for e, d in zip(fitted.problem.experiments, courses, strict=True))
    return refitted(fitted, replace(fitted.problem, experiments=experiments))


def _knots(experiment: Experiment) -> Array:
    count = int(np.clip(experiment.duration / _APART, 8, _MOST))
    return np.linspace(experiment.imposed.time[0], experiment.imposed.time[-1], count)


def _still(experiment: Experiment, gust: tuple[float, ...]) -> Draught:
    return Draught(np.zeros(_knots(experiment).size), np.zeros(experiment.imposed.time.size), gust)


def _responses(fitted: Fit, k: int) -> dict[str, Array]:
    """What w at each knot changes of what one recording shows (SI), by channel, shape (m, knots)."""
    problem, experiment = fitted.problem, fitted.problem.experiments[k]
    draught, base, values = experiment.draught, fitted.predictions[k], fitted.values
    assert draught is not None
    time, excess = experiment.imposed.time, _excess(fitted, k)
    knots = _knots(experiment)
    shapes = hats(time, knots)

    def column(j: int) -> dict[str, Array]:
        cooler = replace(draught, warmer=draught.warmer - _STEP * shapes[:, j] * excess)
        experiments = (*problem.experiments[:k], replace(experiment, draught=cooler), *problem.experiments[k + 1 :])
        return replace(problem, experiments=experiments).predict(values, k)

    with ThreadPoolExecutor(_WORKERS) as pool:
        moved = list(pool.map(column, range(knots.size)))
    return {name: np.column_stack([(m[name] - base[name]) / _STEP for m in moved]) for name in base}


def _excess(fitted: Fit, k: int) -> Array:
    """The fibre's temperature over the room's (K), without any draught's share."""
    outputs, experiment = fitted.outputs[k], fitted.problem.experiments[k]
    ambient = fitted.values.get((AMBIENT, k))
    return np.asarray(outputs.fibre_temperature - (experiment.imposed.ambient if ambient is None else ambient))


def _step(fitted: Fit, k: int, responses: dict[str, Array]) -> Draught:
    """The most likely course, in linear approximation."""
    experiment = fitted.problem.experiments[k]
    draught = experiment.draught
    assert draught is not None
    columns = fitted.problem.columns(responses, k)
    normal = columns.T @ columns + np.eye(columns.shape[1]) / _USUAL**2
    pull = columns.T @ fitted.residuals[k] + draught.share / _USUAL**2
    share = np.maximum(draught.share - np.linalg.solve(normal, pull), _LEAST)
    return replace(
        draught,
        share=share,
        warmer=-(hats(experiment.imposed.time, _knots(experiment)) @ share) * _excess(fitted, k),
        unsure={name: _UNSURE * shown for name, shown in responses.items()},
    )
