"""Fit the muscle to recordings: nonlinear least squares of whitened residuals inside the simulator.

Uses scipy's trust-region solver. Slopes are by forward differences, the columns of one recording's own unknowns cost
one recording; they are updated in between, and outlive the fit, for the next one often begins where they were taken,
with another noise or with part of the data.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from tcp_muscle_ros.diagnosis.fitting.sandwich import clusters, inflation
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem, Shown
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.muscle.arrays import Array

WIDTH = 1.645  # standard deviations either way: the interval of 90 %
_RUN_AWAY = 1e75  # whitened or SI: beyond it nothing is of a muscle, and products of two still are numbers
_STEP = 1e-5
_WORKERS = 2
_UPDATES = 5  # of the slopes, before they are taken anew
_SETTLED = 0.005  # of the objective: a fit that gained less was near its optimum, and so were its slopes


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted problem: the unknowns ``z`` in the fit's coordinates, whitened residuals by recording, and the misfit.

    ``misfit`` is the sum of squared whitened residuals of the data; ``penalty`` that of the priors. ``predictions`` are
    what the model shows at ``z``, and ``near`` their slopes where they were last taken, not far from there.
    """

    problem: Problem
    z: Array
    residuals: tuple[Array, ...]
    misfit: float
    penalty: float
    predictions: tuple[Shown, ...]
    near: list[Shown] | None = None

    @cached_property
    def slopes(self) -> list[Shown]:
        """d shown / d z at ``z``."""
        return slopes(self.problem, self.z, self.predictions)

    @property
    def rough_slopes(self) -> list[Shown] | None:
        """To begin another fit with: those at ``z`` where they are known, else those near it."""
        return self.__dict__.get('slopes', self.near)

    @cached_property
    def jacobian(self) -> Array:
        """d residual / d z at ``z``, shape (sum m, unknowns)."""
        return self.problem.jacobian(self.slopes)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the unknowns in the fit's coordinates, from the linearisation at ``z`` and the priors.

        Wider where what is left over pulls in the same states of the muscle each time (see sandwich.py).
        """
        information = self.jacobian.T @ self.jacobian + np.diag(self.problem.spreads() ** -2.0)
        covariance = np.asarray(np.linalg.pinv(information, hermitian=True))
        labels = clusters(self.problem.experiments, self.outputs)
        wider = inflation(covariance, self.jacobian, np.concatenate(self.residuals), labels)
        return covariance * np.outer(wider, wider)

    @cached_property
    def outputs(self) -> tuple[Outputs, ...]:
        """All that the model says of each recording at ``z``."""
        values = self.values
        return tuple(self.problem.outputs(values, k) for k in range(len(self.problem.experiments)))

    @cached_property
    def left(self) -> list[dict[str, Array]]:
        """Recorded minus fitted (SI), by channel, one a recording."""
        return [self.problem.raw_residual(predicted, k) for k, predicted in enumerate(self.predictions)]

    @cached_property
    def mean_square(self) -> dict[str, float]:
        """Of what is left, as it weighs (SI squared), by channel."""
        return _mean_square(self.weighed)

    @cached_property
    def plain_square(self) -> dict[str, float]:
        """The same of what is left, each sample of a recording weighing alike."""
        seen = [experiment.observed for experiment in self.problem.experiments]
        return _mean_square(
            [{n: x * o[n].beside for n, x in mine.items()} for o, mine in zip(seen, self.left, strict=True)]
        )

    @cached_property
    def still_square(self) -> dict[str, float]:
        """The same of what is left while no weight may swing, where there is such a time."""
        still = []
        for experiment, mine in zip(self.problem.experiments, self.weighed, strict=True):
            moves = {name: experiment.observed[name].swinging for name in mine}
            still.append({n: x if (m := moves[n]) is None or m.all() else x[~m] for n, x in mine.items()})
        return _mean_square(still)

    @cached_property
    def weighed(self) -> list[dict[str, Array]]:
        """What is left (SI) of each recording by channel beside the allowed errors of the model, times what each value
        weighs."""
        found = []
        for k, mine in enumerate(self.left):
            allowed = self.problem.expected_discrepancy(mine, k)
            found.append({n: (left - allowed[n]) * self.problem.weight(n, k) for n, left in mine.items()})
        return found

    @property
    def values(self) -> dict[tuple[str, int | None], float]:
        """The fitted values by (name, recording)."""
        return self.problem.values(self.z)

    @property
    def muscle(self) -> Parameters:
        """The fitted muscle (without what belongs to single recordings)."""
        return self.problem.muscle(self.values)

    @property
    def objective(self) -> float:
        """Misfit and penalty: twice the negative log posterior but for a constant."""
        return self.misfit + self.penalty

    def interval(self, k: int, width: float = WIDTH, beside: float = 0.0) -> tuple[float, float]:
        """The interval of unknown k, ``width`` standard deviations either way (90 % unless given).

        ``beside``: a further standard deviation, in the fit's coordinate.
        """
        unknown, spread = self.problem.unknowns[k], float(np.hypot(np.sqrt(self.covariance[k, k]), beside))
        low, high = self.z[k] - width * spread, self.z[k] + width * spread
        return unknown.from_fit(float(low)), unknown.from_fit(float(high))


def _mean_square(found: Sequence[Mapping[str, Array]]) -> dict[str, float]:
    """By channel, over all recordings."""
    names = sorted({name for mine in found for name in mine})
    return {name: float(np.mean(np.concatenate([mine[name] for mine in found if name in mine]) ** 2)) for name in names}


def ran_away(found: Iterable[Array]) -> bool:
    """Whether anything that was simulated is beyond what a muscle shows, or no number."""
    return not all(np.all(np.abs(part) < _RUN_AWAY) for part in found)


def slopes(problem: Problem, z: Array, base: Sequence[Shown], which: Sequence[int] | None = None) -> list[Shown]:
    """d shown / d z of every recording, ``base`` being what is shown at ``z``, by differences away from the nearer
    bound; each of shape (m, len(which)). An unknown with which the model runs away has none: it stays where it is."""
    which = range(len(problem.unknowns)) if which is None else which
    out = [{name: np.zeros((shown.size, len(which))) for name, shown in mine.items()} for mine in base]

    def column(task: tuple[int, int]) -> None:
        place, k = task
        unknown = problem.unknowns[k]
        step = _STEP if unknown.to_fit(unknown.high) - z[k] > _STEP else -_STEP
        moved = z.copy()
        moved[k] += step
        values = problem.values(moved)
        recordings = range(len(base)) if unknown.recording is None else [unknown.recording]
        with np.errstate(over='ignore', invalid='ignore'):  # where the model runs away
            for r in recordings:
                for name, shown in problem.predict(values, r).items():
                    out[r][name][:, place] = (shown - base[r][name]) / step
        found = [mine[:, place] for r in recordings for mine in out[r].values()]
        if ran_away(found):
            for part in found:
                part[:] = 0.0

    with ThreadPoolExecutor(_WORKERS) as pool:
        list(pool.map(column, enumerate(which)))
    return out


def slopes_with_more(fitted: Fit, problem: Problem, z: Array, shown: Sequence[Shown]) -> list[Shown]:
    """The slopes of a fit, and by differences those of the unknowns that ``problem`` has behind the fit's own;
    ``shown`` at ``z``."""
    more = slopes(problem, z, shown, range(fitted.z.size, z.size))
    return [
        {name: np.hstack([columns, added[name]]) for name, columns in mine.items()}
        for mine, added in zip(fitted.slopes, more, strict=True)
    ]


class _Along:
    """Residuals and their slopes along a fit: by differences now and then, in between by Broyden's rank-one updates.

    A column by differences costs a simulation of every recording; an update costs none.
    """

    def __init__(self, problem: Problem, known: list[Shown] | None) -> None:
        self.problem, self.scale = problem, problem.spreads()
        self.slopes = known
        self.matrix = None if known is None else problem.jacobian(known)
        self.age = 0
        self._at: Array | None = None
        self._residual: Array | None = None
        self._latest: tuple[Array, list[Shown], list[Array]] | None = None

    def at(self, z: Array) -> tuple[list[Shown], list[Array]]:
        """What is shown at ``z``, and the residuals; the latest are kept: slopes are asked for where the solver has
        just been."""
        if self._latest is None or not np.array_equal(self._latest[0], z):
            predictions = self.problem.predictions(z)
            self._latest = z.copy(), predictions, self.problem.residuals(predictions)
        return self._latest[1:]

    def renew(self) -> None:
        """Take differences at the next call."""
        self.matrix = None

    def __call__(self, z: Array) -> Array:
        predictions, parts = self.at(z)
        residual = np.concatenate(parts)
        if self.matrix is None or self.age >= _UPDATES:
            self.slopes = slopes(self.problem, z, predictions)
            self.matrix, self.age = self.problem.jacobian(self.slopes), 0
        elif self._at is not None and self._residual is not None and not np.array_equal(z, self._at):
            moved = z - self._at
            weighted = moved / self.scale**2
            missed = residual - self._residual - self.matrix @ moved
            self.matrix = self.matrix + np.outer(missed, weighted / float(weighted @ moved))
            self.age += 1
        self._at, self._residual = z.copy(), residual
        return self.matrix


def _turned(residual: Array, matrix: Array) -> Array:
    """The matrix turned as the residual is into the first axis, with one row more than columns, shape (n + 1, n).

    The solver decomposes its matrix by singular values; of all samples that takes longer than to simulate them.
    """
    rows = np.asarray(np.linalg.qr(np.column_stack([residual, matrix]), mode='r'))
    turned: Array = np.copysign(1.0, rows[0, 0]) * rows[:, 1:]
    return turned


def fit(
    problem: Problem,
    z0: Array | None = None,
    *,
    rounds: int = 30,
    tolerance: float = 1e-7,
    known: list[Shown] | None = None,
    polish: bool = True,
    progress: Callable[[], None] | None = None,
) -> Fit:
    """Fit the unknowns by penalised least squares from ``z0`` (default, and where the model runs away there: their
    nominal values).

    Stops after ``rounds`` evaluations or when the objective changes relatively by less than ``tolerance``, also with
    slopes newly taken unless it has hardly moved. ``known`` are the slopes near ``z0``, where there are any.
    """
    centre, scale = problem.start(), problem.spreads()
    low = np.array([u.to_fit(u.low) if u.low > 0.0 or not u.log else -np.inf for u in problem.unknowns])
    high = np.array([u.to_fit(u.high) for u in problem.unknowns])
    prior = np.diag(1.0 / scale)
    along = _Along(problem, known)

    def missed(z: Array) -> Array:
        return np.concatenate([*along.at(z)[1], (z - centre) / scale])

    # The solver sees both turned alike, the residuals along the first axis.
    def residuals(z: Array) -> Array:
        if progress:
            progress()
        with np.errstate(over='ignore', invalid='ignore'):  # where the model runs away, no step is taken to
            return np.concatenate([[np.linalg.norm(missed(z))], np.zeros(z.size)])

    def all_slopes(z: Array) -> Array:
        return _turned(missed(z), np.vstack([along(z), prior]))

    z, cost = _begun([centre] if z0 is None else [z0, centre], low, high, residuals)
    left, enough = rounds, _SETTLED
    while left > 0:
        solution = least_squares(
            residuals,
            z,
            jac=all_slopes,
            bounds=(low, high),
            x_scale=scale,
            ftol=tolerance,
            xtol=1e-9,
            gtol=1e-9,
            max_nfev=left,
        )
        left -= int(solution.nfev)
        z, gained, cost = np.asarray(solution.x), cost - float(solution.cost), float(solution.cost)
        if not polish or along.age == 0 or gained <= enough * cost:
            break
        along.renew()
        enough = tolerance
    predictions, parts = along.at(z)
    misfit = float(sum(part @ part for part in parts))
    penalty = float(np.sum(((z - centre) / scale) ** 2))
    return Fit(problem, z, tuple(parts), misfit, penalty, tuple(predictions), along.slopes)


def _begun(
    starts: Sequence[Array], low: Array, high: Array, residuals: Callable[[Array], Array]
) -> tuple[Array, float]:
    """The first start, within the bounds, from which the model does not run away, and half its squared residuals."""
    for start in starts:
        margin = 1e-9 * (1.0 + np.abs(start))
        z = np.clip(start, low + margin, high - margin)
        cost = 0.5 * float(np.sum(residuals(z) ** 2))
        if np.isfinite(cost):
            break
    return z, cost
