"""What a hypothesis says of one recording that was not recorded, no equation foretells, and no unknown of the fit is.

A recording stays as it was read. How old the muscle was in it, when its drive switched, how a draught went, when the
end slipped, and by how much each channel may err is inferred, and held beside it: by the problem that is fitted, not by
the data.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from tcp_muscle_ros.diagnosis.model.model import Model, ages
from tcp_muscle_ros.diagnosis.noise.discrepancy import NO_ALLOWANCE, Allowance
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Earlier, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.muscle.effects.effect import SWING


@dataclass(frozen=True)
class Draught:
    """The course of a draught or of a room that drifts, known at the ``knots`` (s): ``warmer``, the change of the room
    (K) that takes as much heat, at each instant that is followed; ``effects``: which of the two it is, or both;
    ``gust``: how they were described before; ``unsure``: by channel, how what stays unknown of it shows (SI), one
    column each."""

    knots: Array
    warmer: Array
    effects: frozenset[str] = frozenset()
    gust: tuple[float, ...] = ()
    unsure: Mapping[str, Array] = field(default_factory=dict)

    def only(self, keep: Mapping[str, Mask]) -> 'Draught':
        """The same where only these values of each channel are kept."""
        return replace(self, unsure={name: c[keep[name]] for name, c in self.unsure.items() if name in keep})


@dataclass(frozen=True)
class Slip:
    """A sudden slip of the end at ``time`` (s): a channel shows less by ``size`` (SI; known to ``unsure``) after it.

    ``half``: half the time over which one value was averaged, s.
    """

    channel: str
    time: float
    size: float
    unsure: float
    half: float

    def after(self, time: Array) -> Array:
        """0 before, 1 after, in between for a mean over both; shape as ``time``."""
        return np.clip(0.5 + 0.5 * (time - self.time) / self.half, 0.0, 1.0)


@dataclass(frozen=True)
class Switched:
    """What was ``imposed``, where the drive switched at other instants than its record shows; ``moves``: by which
    switches it differs; ``notes`` say so."""

    imposed: Imposed
    notes: tuple[str, ...] = ()
    moves: tuple[Earlier, ...] = ()


@dataclass(frozen=True)
class Before:
    """What the muscle went through in the recordings before one: ``cycles``, ``used`` (s), ``hottest`` (K)."""

    cycles: float = 0.0
    used: float = 0.0
    hottest: float = 0.0

    def then(self, state: Array, duration: float) -> 'Before':
        """After one more recording of so many seconds, in which the state that ages it (K) took this course."""
        cycles = self.cycles + float(np.sum(np.abs(np.diff(state)))) / (2.0 * SWING)
        return Before(cycles, self.used + duration, max(self.hottest, float(state.max())))

    def aged(self, parameters: Parameters, model: Model) -> dict[str, float]:
        """Those parameters of a machine that count what was before the first recording, as they are now."""
        names = ages(model, parameters.effects)
        return {name: self.counted(parameters[name], model.specifications[name].unit) for name in names}

    def counted(self, parameter: float, unit: str) -> float:
        """A parameter that counts what was before the first recording, as it is now, by its unit."""
        if unit == 'K':
            return max(parameter, self.hottest)
        return parameter + {'1': self.cycles, 's': self.used}[unit]


@dataclass(frozen=True)
class Latent:
    """What is inferred of one recording.

    ``before``: what the muscle went through before it; ``draught``: the course of one, if any; ``slips``:
    those of the end; ``allowances``: by channel, in which ways it may err, where there are any; ``together``: ways in
    which all channels err at once, by channel, a column each (SI), and as AMBIENT what each is of the room (K, at the
    knots of its course); ``switched``: what was imposed, where that is not what was read.
    """

    before: Before = Before()
    draught: Draught | None = None
    slips: tuple[Slip, ...] = ()
    allowances: Mapping[str, Allowance] = field(default_factory=dict)
    together: Mapping[str, Array] = field(default_factory=dict)
    switched: Switched | None = None

    def followed(self, experiment: Experiment) -> Experiment:
        """A recording as the model follows it: the same, under what was imposed on it."""
        if self.switched is None:
            return experiment
        notes = (*experiment.notes, *self.switched.notes)
        return replace(experiment, imposed=self.switched.imposed, notes=notes)

    def allowance(self, channel: str) -> Allowance:
        """In which ways a channel may err."""
        return self.allowances.get(channel, NO_ALLOWANCE)

    def room(self, ambient: Array) -> Array:
        """The ambient (K) that takes as much heat as this one and the draught, shape as ``ambient``."""
        return ambient if self.draught is None else ambient + self.draught.warmer

    def slipped(self, shown: Mapping[str, Array], observed: Mapping[str, Observed]) -> dict[str, Array]:
        """What a model shows of each channel observed, less what the slips took."""
        less = dict(shown)
        for slip in self.slips:
            if slip.channel in less:
                less[slip.channel] = less[slip.channel] - slip.size * slip.after(observed[slip.channel].time)
        return less

    def only(self, keep: Mapping[str, Mask]) -> 'Latent':
        """The same of a part of the recording: of each channel in it, which values it keeps."""
        return replace(
            self,
            draught=self.draught and self.draught.only(keep),
            allowances={name: allowed.only(keep[name]) for name, allowed in self.allowances.items() if name in keep},
            together={name: columns[keep[name]] for name, columns in self.together.items() if name in keep},
        )
