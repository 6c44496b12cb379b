"""A recording as the model sees it: what was imposed, what held the end, and what was seen.

An input holds from its stamp to the next. The model is stepped at the instants of the observations and at every
change of an input, so that its exact step answers for any rate.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tcp_muscle_ros.diagnosis.model.model import Model
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.observation.between import bends, weights
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.late import Late
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.reading import read
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.muscle.arrays import Array, Mask, Places

_ONE_LOAD = 0.05  # of the load: a cell beside a weight scatters by less, and a load that differs by less tells little


@dataclass(frozen=True)
class Experiment:
    """One recording as the model sees it: what was read, and nothing that is inferred (see hypothesis/latents.py).

    ``notes`` say what was assumed, for people to read; ``start_ns``: when it began, by its own clock;
    ``model``: what it was recorded of; ``fingerprint``: that of the recording, empty where there is none.
    """

    name: str
    imposed: Imposed
    holding: Holding
    observed: Mapping[str, Observed]
    known: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    start_ns: int = 0
    model: Model = TCP_MUSCLE
    fingerprint: str = ''

    def outputs(
        self,
        parameters: Parameters,
        temperature: float | None = None,
        resolution: float = 1.0,
        only: Collection[str] | None = None,
        ambient: Array | None = None,
    ) -> Outputs:
        """The model's outputs (or only some) at ``imposed.time``; ``temperature`` (K) at the start, default the
        ambient; ``ambient`` (K, shape as ``imposed.time``), default as it was read."""
        found: Outputs = self.model.simulate(self, parameters, temperature, resolution, only, ambient)
        return found

    def predict(
        self, parameters: Parameters, temperature: float | None = None, ambient: Array | None = None
    ) -> dict[str, Array]:
        """What the model shows at the instants of each observed channel (SI, shapes as observed)."""
        return self.shown(self.outputs(parameters, temperature, only=self.observed, ambient=ambient))

    def only(self, keep: Mapping[str, Mask]) -> 'Experiment':
        """A part of it: of each channel in it, which values it keeps."""
        return replace(self, observed={n: o.only(keep[n]) for n, o in self.observed.items() if n in keep})

    def weighing(self, beside: Mapping[str, float]) -> 'Experiment':
        """The same, of which these channels weigh so much beside those of other recordings."""
        observed = {n: replace(o, beside=beside.get(n, o.beside)) for n, o in self.observed.items()}
        return replace(self, observed=observed)

    def until(self, end: float) -> 'Experiment':
        """Its beginning, with the first instant at or after ``end`` (s)."""
        inputs = self.imposed
        n = int(np.searchsorted(inputs.time, end)) + 1
        imposed = Imposed(inputs.kind, inputs.time[:n], inputs.drive[:n], inputs.load[:n], inputs.ambient[:n])
        observed = {name: o.only(o.time <= end) for name, o in self.observed.items()}
        return replace(self, imposed=imposed, observed=observed)

    def shown(self, outputs: Outputs, late: Late | None = None) -> dict[str, Array]:
        """The model's outputs at the instants of each observed channel, read ``late`` where it is."""
        shown = {}
        for name, channel in self.observed.items():
            if late is not None and late.channel == name:
                shown[name] = late.seen(self.imposed, getattr(outputs, name), channel)
            else:
                places, weights = self._read[name]
                middle = np.empty(channel.time.size)
                read(np.ascontiguousarray(getattr(outputs, name)), places, weights, middle)
                shown[name] = channel.averaged(middle)
        return shown

    @cached_property
    def _read(self) -> dict[str, tuple[Places, Array]]:
        """How the instants of each channel are read between those of the model."""
        imposed = self.imposed
        corner, jump = bends(imposed.drive, imposed.load)
        return {name: weights(imposed.time, corner, jump, observed.time) for name, observed in self.observed.items()}

    @property
    def duration(self) -> float:
        """From the first to the last instant, s."""
        return float(self.imposed.time[-1] - self.imposed.time[0])


def one_load(experiments: Sequence[Experiment]) -> bool:
    """Whether no recording tells a stiffness: one and the same load hangs in all of them."""
    if not all(e.holding.hangs for e in experiments):
        return False
    loads = np.concatenate([e.imposed.load for e in experiments])
    return bool(np.ptp(loads) <= _ONE_LOAD * float(np.median(loads)))
