"""What is fitted to what: the whitened residuals of recordings as a function of the unknowns.

The residual of every channel is divided by its noise and whitened; the zero of displacement and of force is a linear
unknown of each recording and is projected out exactly.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent, Slip
from tcp_muscle_ros.diagnosis.hypothesis.work import Work
from tcp_muscle_ros.diagnosis.model.model import Model, ages, floating
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT, START, Unknown
from tcp_muscle_ros.diagnosis.noise.discrepancy import allowing_for, expected, whitening_of
from tcp_muscle_ros.diagnosis.noise.noise import Noise
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.late import Late, taken_out
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.settings.policy import Policy, shipped

_RESOLUTION = 0.125  # of the usual substeps
_STRAIN = 'strain'  # beside the channels: how far the machine was beyond what it survives

Values = Mapping[tuple[str, int | None], float]
Shown = dict[str, Array]  # by channel and _STRAIN, what a model shows in one recording; or its slopes, a column each


@dataclass(frozen=True)
class Problem:
    """What is fitted to what: experiments, the muscle that the unknowns start from, noise by channel.

    ``latents``: what is inferred of each experiment; empty: nothing of any. The experiments stay as they were read.
    ``work`` counts what is simulated; ``policy`` decides what is named.
    """

    experiments: tuple[Experiment, ...]
    parameters: Parameters
    unknowns: tuple[Unknown, ...]
    noise: Mapping[str, Noise]
    latents: tuple[Latent, ...] = ()
    work: Work = field(default_factory=Work, compare=False, repr=False)
    policy: Policy = field(default_factory=shipped, compare=False, repr=False)

    def __post_init__(self) -> None:
        latents = self.latents or (Latent(),) * len(self.experiments)
        if len(latents) != len(self.experiments):
            raise ValueError(f'{len(latents)} latents of {len(self.experiments)} experiments')
        object.__setattr__(self, 'latents', latents)

    def with_latents(self, latents: Iterable[Latent]) -> 'Problem':
        """The same with something else inferred of its experiments."""
        return replace(self, latents=tuple(latents))

    def with_latent(self, latent: Latent, recording: int) -> 'Problem':
        """The same with something else inferred of one of them."""
        return self.with_latents((*self.latents[:recording], latent, *self.latents[recording + 1 :]))

    def only(self, keep: Sequence[Mapping[str, Mask]]) -> 'Problem':
        """The problem of a part of the data: of each recording the channels in it, and which values it keeps."""
        return replace(
            self,
            experiments=tuple(experiment.only(mine) for experiment, mine in zip(self.experiments, keep, strict=True)),
            latents=tuple(latent.only(mine) for latent, mine in zip(self.latents, keep, strict=True)),
        )

    def weighing(self, beside: Sequence[Mapping[str, float]]) -> 'Problem':
        """The same, in which the values of a channel weigh so much beside those of other recordings, by their noise."""
        return replace(
            self, experiments=tuple(one.weighing(mine) for one, mine in zip(self.experiments, beside, strict=True))
        )

    @property
    def model(self) -> Model:
        """What the experiments were recorded of."""
        return self.experiments[0].model

    @cached_property
    def followed(self) -> tuple[Experiment, ...]:
        """The experiments as the model follows them: under what was imposed, which is not always what was read."""
        return tuple(latent.followed(mine) for latent, mine in zip(self.latents, self.experiments, strict=True))

    @property
    def slips(self) -> tuple[Slip, ...]:
        """Those of all recordings."""
        return tuple(slip for latent in self.latents for slip in latent.slips)

    def with_noise(self, noise: Mapping[str, Noise]) -> 'Problem':
        """The same with other noise."""
        return replace(self, noise=noise)

    def start(self) -> Array:
        """The unknowns' nominal values in the fit's coordinates."""
        return np.array([u.to_fit(u.start) for u in self.unknowns])

    def spreads(self) -> Array:
        """The priors' standard deviations in the fit's coordinates."""
        return np.array([u.prior_spread for u in self.unknowns])

    @property
    def ages(self) -> tuple[str, ...]:
        """The parameters that say what the muscle went through before a recording."""
        return ages(self.model, self.parameters.effects)

    def values(self, z: Array) -> dict[tuple[str, int | None], float]:
        """Coordinates to values."""
        return {u.key: u.from_fit(float(zi)) for u, zi in zip(self.unknowns, z, strict=True)}

    def muscle(self, values: Values, recording: int | None = None) -> Parameters:
        """The muscle that these values make, for one recording where some unknowns are its own; for none the typical
        one."""
        mine = {n: v for (n, owner), v in values.items() if owner in (None, recording) and n not in (AMBIENT, START)}
        if recording is None:
            mine |= _typical(values, self.model.separate)
        else:
            mine |= self.latents[recording].before.aged(self.parameters, self.model)
        return self.parameters.replace(mine)

    def outputs(self, values: Values, recording: int) -> Outputs:
        """The model's outputs under the inputs of one recording; no channel is late in them."""
        return self._run(values, recording)[0]

    def _run(self, values: Values, recording: int) -> tuple[Outputs, Late | None]:
        """The same, and the channel that is late."""
        experiment = self.followed[recording]
        ambient, fitted = experiment.imposed.ambient, values.get((AMBIENT, recording))
        room = self.latents[recording].room(ambient if fitted is None else np.full(ambient.size, fitted))
        muscle, late = taken_out(self.muscle(values, recording), self.model)
        self.work.add(self.model.steps(experiment, muscle, _RESOLUTION))
        return experiment.outputs(muscle, values.get((START, recording)), _RESOLUTION, ambient=room), late

    def predict(self, values: Values, recording: int) -> Shown:
        """What the model shows in one recording at the observed instants (SI)."""
        outputs, late = self._run(values, recording)
        experiment = self.followed[recording]
        shown = self.latents[recording].slipped(experiment.shown(outputs, late), experiment.observed)
        return shown | {_STRAIN: np.array([self.model.strained(outputs)])}

    def predictions(self, z: Array) -> list[Shown]:
        """What the model shows in every recording."""
        values = self.values(z)
        return [self.predict(values, k) for k in range(len(self.experiments))]

    def residual(self, predicted: Shown, recording: int, zeros: Mapping[str, float] | None = None) -> Array:
        """Whitened residuals of one recording, channel after channel, floating zeros projected out, shape (m,).

        ``zeros``: those that are known, by channel. The last entry is not data: it keeps the machine within what
        it survives, for it did.
        """
        known, seen = zeros or {}, self.experiments[recording].observed
        left = {name: observed.value - predicted[name] - known.get(name, 0.0) for name, observed in seen.items()}
        white = self._white(left, recording, frozenset(known))
        return np.concatenate([*self._beside_shared(white, recording, frozenset(known)), predicted[_STRAIN]])

    def residuals(self, predictions: Sequence[Shown]) -> list[Array]:
        """The same of every recording."""
        return [self.residual(predicted, k) for k, predicted in enumerate(predictions)]

    def jacobian(self, slopes: Sequence[Shown]) -> Array:
        """d residual / d z, shape (sum m, n), from the slopes of what is shown, each of shape (m, n)."""
        return np.vstack([self.columns(mine, k) for k, mine in enumerate(slopes)])

    def columns(self, slopes: Shown, recording: int) -> Array:
        """The rows of the Jacobian that are one recording's, shape (m, n)."""
        white = self._white({name: -slopes[name] for name in self.experiments[recording].observed}, recording)
        return np.vstack([*self._beside_shared(white, recording), slopes[_STRAIN]])

    def weight(self, channel: str, recording: int) -> Array:
        """What each value of a channel weighs beside a usual one, shape (m,)."""
        return self.latents[recording].allowance(channel).weight(self.experiments[recording].observed[channel])

    def _white(self, left: Mapping[str, Array], recording: int, known: frozenset[str] = frozenset()) -> list[Array]:
        """Residuals (m,) or columns (m, n) of each channel of one recording (SI), whitened, the floating zeros that are
        not ``known`` projected out."""
        found = []
        for name in self.experiments[recording].observed:
            weight = self.weight(name, recording)
            weighted = left[name] * (weight if left[name].ndim == 1 else weight[:, None])
            found.append(self._whitened(name, weighted, recording, name not in known))
        return found

    def _whitened(self, channel: str, weighted: Array, recording: int, floating: bool) -> Array:
        """Residuals (m,) or columns (m, n) whitened, the floating zero projected out."""
        white = self._whitening[channel, recording](weighted)
        if not self.model.channels[channel].floating or not floating:
            return white
        constant = self._constants[channel, recording]
        return np.asarray(white - np.multiply.outer(constant, constant @ white))

    def _beside_shared(self, white: list[Array], recording: int, known: frozenset[str] = frozenset()) -> list[Array]:
        """White residuals (m,) or columns (m, n) of the channels of one recording, beside the errors that these share;
        ``known``: the channels whose zeros are."""
        if not self.latents[recording].together or not white:
            return white
        if (recording, known) not in self._shared:
            self._shared[recording, known] = allowing_for(self._shared_columns(recording, known))
        return [self._shared[recording, known](np.concatenate(white))]

    def _shared_columns(self, recording: int, known: frozenset[str] = frozenset()) -> Array:
        """The errors that the channels of one recording share, as residuals are whitened, shape (m, n)."""
        return np.vstack(self._white(self.latents[recording].together, recording, known))

    @cached_property
    def _shared(self) -> dict[tuple[int, frozenset[str]], Callable[[Array], Array]]:
        """What allows for the errors that channels share, by recording and the channels with known zeros."""
        return {}

    def __getstate__(self) -> dict[str, object]:
        """Without the functions that it keeps: they are made anew where it is read."""
        return {name: value for name, value in vars(self).items() if name not in ('_whitening', '_shared')}

    @cached_property
    def _whitening(self) -> dict[tuple[str, int], Callable[[Array], Array]]:
        """What removes the colour of every channel of every recording."""
        return {
            (name, k): whitening_of(observed, latent.allowance(name), self.noise[name])
            for k, (experiment, latent) in enumerate(zip(self.experiments, self.latents, strict=True))
            for name, observed in experiment.observed.items()
        }

    @cached_property
    def _constants(self) -> dict[tuple[str, int], Array]:
        """The whitened constant of every channel with a floating zero, as a unit vector."""
        constants = {}
        for k, experiment in enumerate(self.experiments):
            for name in floating(self.model):
                if name in experiment.observed:
                    white = self._whitening[name, k](self.weight(name, k))
                    constants[name, k] = white / np.linalg.norm(white)
        return constants

    def forget(self) -> None:
        """Let go of what is computed again when it is asked for, and is large: for a problem that is kept."""
        for name in ('_whitening', '_constants', '_shared'):
            self.__dict__.pop(name, None)

    def zeros(self, predicted: Shown, recording: int) -> dict[str, float]:
        """The floating zeros that the projection takes out (SI): recorded minus predicted, by channel."""
        found, seen = {}, self.experiments[recording].observed
        left = {name: observed.value - predicted[name] for name, observed in seen.items()}
        shared = self.shared_error(left, recording, frozenset())
        for name in seen:
            if self.model.channels[name].floating:
                whitened, weight = self._whitening[name, recording], self.weight(name, recording)
                constant = whitened(weight)
                white = whitened((left[name] - shared.get(name, 0.0)) * weight)
                found[name] = float(constant @ white / (constant @ constant))
        return found

    def shared_error(self, left: Mapping[str, Array], recording: int, known: frozenset[str]) -> dict[str, Array]:
        """What of the residuals of one recording (SI, by channel) is most likely an error that its channels share, and
        what that is of its room (K, at the knots of a course)."""
        together = self.latents[recording].together
        if not together:
            return {}
        columns = self._shared_columns(recording, known)
        normal = columns.T @ columns + np.eye(columns.shape[1])
        size = np.linalg.solve(normal, columns.T @ np.concatenate(self._white(left, recording, known)))
        return {name: mine @ size for name, mine in together.items()}

    def raw_residual(
        self, predicted: Shown, recording: int, zeros: Mapping[str, float] | None = None
    ) -> dict[str, Array]:
        """Recorded minus predicted (SI) by channel, after the floating zeros (those of ``zeros`` where known)."""
        zeros = {**self.zeros(predicted, recording), **(zeros or {})}
        return {
            name: observed.value - predicted[name] - zeros.get(name, 0.0)
            for name, observed in self.experiments[recording].observed.items()
        }

    def expected_discrepancy(self, left: Mapping[str, Array], recording: int) -> dict[str, Array]:
        """What of the residuals of one recording (SI, by channel) is most likely the allowed error of the model."""
        observed, latent = self.experiments[recording].observed, self.latents[recording]
        shared = self.shared_error(left, recording, frozenset(left))
        found = {}
        for name, mine in left.items():
            of_all = shared.get(name, 0.0)
            found[name] = of_all + expected(observed[name], latent.allowance(name), self.noise[name], mine - of_all)
        return found


def without_effect(problem: Problem, effect: str) -> tuple[Problem, list[int]]:
    """The problem with one effect taken out, and the places of the unknowns that it keeps."""
    kept = [k for k, u in enumerate(problem.unknowns) if not u.name.startswith(f'{effect}.')]
    effects = tuple(e for e in problem.parameters.effects if e != effect)
    unknowns = tuple(problem.unknowns[k] for k in kept)
    return replace(problem, parameters=problem.parameters.only_effects(effects), unknowns=unknowns), kept


def _typical(values: Values, separate: Collection[str]) -> dict[str, float]:
    """The geometric mean of each parameter of the muscle (above zero) that every recording has for itself."""
    own: dict[str, list[float]] = {}
    for (name, owner), value in values.items():
        if owner is not None and name in separate:
            own.setdefault(name, []).append(value)
    return {name: float(np.exp(np.mean(np.log(found)))) for name, found in own.items()}
