"""Fit the muscle to recordings: nonlinear least squares of whitened residuals inside the simulator.

The residual of every channel is divided by its noise and whitened; the zero of displacement and of force is a linear
unknown of each recording and is projected out exactly. Uses scipy's trust-region solver; the Jacobian is by forward
differences, the columns of one recording's own unknowns cost one recording, and is updated in between.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from tcp_muscle_ros.diagnosis.experiment import Experiment
from tcp_muscle_ros.diagnosis.form import clusters, inflation
from tcp_muscle_ros.diagnosis.noise import Noise, whitening
from tcp_muscle_ros.diagnosis.unknowns import AMBIENT, START, Unknown
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.muscle.arrays import Array

FLOATING_ZERO = ('displacement', 'force')  # channels whose zero is a convention of the rig
_STEP = 1e-5
_RESOLUTION = 0.2
# Nylon 6,6 melts near 260 degC; well before, the coil's set is lost.
_SURVIVED, _MELTING_SPREAD = 273.15 + 220.0, 5.0  # K
_WORKERS = 2
_UPDATES = 4  # of the slopes, before they are taken anew

Values = Mapping[tuple[str, int | None], float]


@dataclass(frozen=True)
class Problem:
    """What is fitted to what: experiments, the muscle that the unknowns start from, noise by channel."""

    experiments: tuple[Experiment, ...]
    parameters: Parameters
    unknowns: tuple[Unknown, ...]
    noise: Mapping[str, Noise]

    def with_noise(self, noise: Mapping[str, Noise]) -> 'Problem':
        """The same with other noise."""
        return replace(self, noise=noise)

    def start(self) -> Array:
        """The unknowns' nominal values in the fit's coordinates."""
        return np.array([u.to_fit(u.start) for u in self.unknowns])

    def spreads(self) -> Array:
        """The priors' standard deviations in the fit's coordinates."""
        return np.array([u.prior_spread for u in self.unknowns])

    def values(self, z: Array) -> dict[tuple[str, int | None], float]:
        """Coordinates to values."""
        return {u.key: u.from_fit(float(zi)) for u, zi in zip(self.unknowns, z, strict=True)}

    def muscle(self, values: Values, recording: int | None = None) -> Parameters:
        """The muscle that these values make, for one recording where some unknowns are its own."""
        mine = {n: v for (n, owner), v in values.items() if owner in (None, recording) and n not in (AMBIENT, START)}
        return self.parameters.replace(mine)

    def outputs(self, values: Values, recording: int) -> Outputs:
        """The model's outputs under the inputs of one recording."""
        experiment = self.experiments[recording]
        ambient = values.get((AMBIENT, recording))
        if ambient is not None:
            imposed = replace(experiment.imposed, ambient=np.full(experiment.imposed.time.size, ambient))
            experiment = replace(experiment, imposed=imposed)
        return experiment.outputs(self.muscle(values, recording), values.get((START, recording)), _RESOLUTION)

    def predict(self, values: Values, recording: int) -> dict[str, Array]:
        """What the model shows in one recording at the observed instants (SI)."""
        return self.experiments[recording].shown(self.outputs(values, recording))

    def residual(self, values: Values, recording: int, zeros: Mapping[str, float] | None = None) -> Array:
        """Whitened residuals of one recording, channel after channel, floating zeros projected out, shape (m,).

        ``zeros``: those that are known, by channel. The last entry is not data: it keeps the fibre below the melting
        point, for the muscle survived.
        """
        outputs = self.outputs(values, recording)
        predicted = self.experiments[recording].shown(outputs)
        whitened = [
            self._whitened(name, observed.value - predicted[name], recording, (zeros or {}).get(name))
            for name, observed in self.experiments[recording].observed.items()
        ]
        melting = max(0.0, float(outputs.fibre_temperature.max()) - _SURVIVED) / _MELTING_SPREAD
        return np.concatenate([*whitened, [melting]])

    def _whitened(self, channel: str, raw: Array, recording: int, zero: float | None) -> Array:
        observed = self.experiments[recording].observed[channel]
        white = self._whitening[channel, recording]((raw - (zero or 0.0)) * observed.weight)
        if channel not in FLOATING_ZERO or zero is not None:
            return white
        constant = self._constants[channel, recording]
        return np.asarray(white - constant * (constant @ white))

    @cached_property
    def _whitening(self) -> dict[tuple[str, int], Callable[[Array], Array]]:
        """What removes the colour of every channel of every recording."""
        return {
            (name, k): whitening(observed.time, self.noise[name])
            for k, experiment in enumerate(self.experiments)
            for name, observed in experiment.observed.items()
        }

    @cached_property
    def _constants(self) -> dict[tuple[str, int], Array]:
        """The whitened constant of every channel with a floating zero, as a unit vector."""
        constants = {}
        for k, experiment in enumerate(self.experiments):
            for name in FLOATING_ZERO:
                if name in experiment.observed:
                    white = self._whitening[name, k](experiment.observed[name].weight)
                    constants[name, k] = white / np.linalg.norm(white)
        return constants

    def zeros(self, values: Values, recording: int) -> dict[str, float]:
        """The floating zeros that the projection took out (SI): recorded minus predicted, by channel."""
        return self._zeros(self.predict(values, recording), recording)

    def _zeros(self, predicted: Mapping[str, Array], recording: int) -> dict[str, float]:
        found = {}
        for name, observed in self.experiments[recording].observed.items():
            if name in FLOATING_ZERO:
                whitened = self._whitening[name, recording]
                constant = whitened(observed.weight)
                white = whitened((observed.value - predicted[name]) * observed.weight)
                found[name] = float(constant @ white / (constant @ constant))
        return found

    def raw_residuals(
        self, values: Values, recording: int, zeros: Mapping[str, float] | None = None
    ) -> dict[str, Array]:
        """Recorded minus predicted (SI) by channel, after the floating zeros (those of ``zeros`` where known)."""
        predicted = self.predict(values, recording)
        zeros = {**self._zeros(predicted, recording), **(zeros or {})}
        return {
            name: observed.value - predicted[name] - zeros.get(name, 0.0)
            for name, observed in self.experiments[recording].observed.items()
        }


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted problem: the unknowns ``z`` in the fit's coordinates, whitened residuals by recording, and the misfit.

    ``misfit`` is the sum of squared whitened residuals of the data; ``penalty`` that of the priors.
    """

    problem: Problem
    z: Array
    residuals: tuple[Array, ...]
    misfit: float
    penalty: float

    @cached_property
    def jacobian(self) -> Array:
        """d residual / d z at ``z``, shape (sum m, unknowns)."""
        return jacobian(self.problem, self.z, self.residuals)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the unknowns in the fit's coordinates, from the linearisation at ``z`` and the priors.

        Wider where what is left over pulls in the same states of the muscle each time (see form.py).
        """
        information = self.jacobian.T @ self.jacobian + np.diag(self.problem.spreads() ** -2.0)
        covariance = np.asarray(np.linalg.pinv(information, hermitian=True))
        experiments, values = self.problem.experiments, self.values
        labels = clusters(experiments, [self.problem.outputs(values, k) for k in range(len(experiments))])
        wider = inflation(covariance, self.jacobian, np.concatenate(self.residuals), labels)
        return covariance * np.outer(wider, wider)

    @cached_property
    def left(self) -> list[dict[str, Array]]:
        """Recorded minus fitted (SI), by channel, one a recording."""
        values = self.values
        return [self.problem.raw_residuals(values, k) for k in range(len(self.problem.experiments))]

    @cached_property
    def mean_square(self) -> dict[str, float]:
        """Of what is left (SI squared), by channel."""
        names = sorted({name for left in self.left for name in left})
        return {
            name: float(np.mean(np.concatenate([left[name] for left in self.left if name in left]) ** 2))
            for name in names
        }

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

    def interval(self, k: int, width: float = 1.645, beside: float = 0.0) -> tuple[float, float]:
        """The interval of unknown k, ``width`` standard deviations either way (1.645: 90 %).

        ``beside``: a further standard deviation, in the fit's coordinate.
        """
        unknown, spread = self.problem.unknowns[k], float(np.hypot(np.sqrt(self.covariance[k, k]), beside))
        low, high = self.z[k] - width * spread, self.z[k] + width * spread
        return unknown.from_fit(float(low)), unknown.from_fit(float(high))


def residual_vector(problem: Problem, z: Array) -> list[Array]:
    """Whitened residuals of all recordings at ``z``."""
    values = problem.values(z)
    return [problem.residual(values, k) for k in range(len(problem.experiments))]


def jacobian(problem: Problem, z: Array, base: Sequence[Array], which: Sequence[int] | None = None) -> Array:
    """d residual / d z, shape (sum m, len(which)), by differences away from the nearer bound."""
    which = range(len(problem.unknowns)) if which is None else which
    sizes = [r.size for r in base]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    out = np.zeros((int(starts[-1]), len(which)))

    def column(task: tuple[int, int]) -> None:
        place, k = task
        unknown = problem.unknowns[k]
        step = _STEP if unknown.to_fit(unknown.high) - z[k] > _STEP else -_STEP
        moved = z.copy()
        moved[k] += step
        values = problem.values(moved)
        owners = range(len(sizes)) if unknown.recording is None else [unknown.recording]
        for r in owners:
            out[starts[r] : starts[r + 1], place] = (problem.residual(values, r) - base[r]) / step

    with ThreadPoolExecutor(_WORKERS) as pool:
        list(pool.map(column, enumerate(which)))
    return out


class _Slopes:
    """d residual / d z along a fit: by differences now and then, in between by Broyden's rank-one updates.

    A column by differences costs a simulation of every recording; an update costs none.
    """

    def __init__(self, problem: Problem, known: Array | None) -> None:
        self.problem, self.scale = problem, problem.spreads()
        self.matrix = known
        self.age = 0
        self._at: Array | None = None
        self._residual: Array | None = None
        self._latest: tuple[Array, list[Array]] | None = None

    def residuals(self, z: Array) -> list[Array]:
        """Whitened residuals at ``z``; the latest are kept: slopes are asked for where the solver has just been."""
        if self._latest is None or not np.array_equal(self._latest[0], z):
            self._latest = z.copy(), residual_vector(self.problem, z)
        return self._latest[1]

    def renew(self) -> None:
        """Take differences at the next call."""
        self.matrix = None

    def __call__(self, z: Array) -> Array:
        parts = self.residuals(z)
        residual = np.concatenate(parts)
        if self.matrix is None or self.age >= _UPDATES:
            self.matrix, self.age = jacobian(self.problem, z, parts), 0
        elif self._at is not None and self._residual is not None and not np.array_equal(z, self._at):
            moved = z - self._at
            weighted = moved / self.scale**2
            missed = residual - self._residual - self.matrix @ moved
            self.matrix = self.matrix + np.outer(missed, weighted / float(weighted @ moved))
            self.age += 1
        self._at, self._residual = z.copy(), residual
        return self.matrix


def fit(
    problem: Problem,
    z0: Array | None = None,
    *,
    rounds: int = 30,
    tolerance: float = 1e-7,
    slopes: Array | None = None,
    polish: bool = True,
    progress: Callable[[], None] | None = None,
) -> Fit:
    """Fit the unknowns by penalised least squares from ``z0`` (default: their nominal values).

    Stops after ``rounds`` evaluations or when the objective changes relatively by less than ``tolerance``, also with
    slopes newly taken. ``slopes`` are those at ``z0``, where they are known.
    """
    centre, scale = problem.start(), problem.spreads()
    low = np.array([u.to_fit(u.low) if u.low > 0.0 or not u.log else -np.inf for u in problem.unknowns])
    high = np.array([u.to_fit(u.high) for u in problem.unknowns])
    prior = np.diag(1.0 / scale)
    along = _Slopes(problem, slopes)

    def residuals(z: Array) -> Array:
        if progress:
            progress()
        return np.concatenate([*along.residuals(z), (z - centre) / scale])

    def all_slopes(z: Array) -> Array:
        return np.vstack([along(z), prior])

    start = centre if z0 is None else z0
    margin = 1e-9 * (1.0 + np.abs(start))
    z, left, cost = np.clip(start, low + margin, high - margin), rounds, np.inf
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
        if not polish or along.age == 0 or gained <= tolerance * cost:
            break
        along.renew()
    parts = along.residuals(z)
    misfit = float(sum(part @ part for part in parts))
    penalty = float(np.sum(((z - centre) / scale) ** 2))
    return Fit(problem, z, tuple(parts), misfit, penalty)
