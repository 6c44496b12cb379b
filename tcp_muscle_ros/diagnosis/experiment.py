"""A recording as the model sees it: what was imposed, what held the end, and what was seen.

An input holds from its stamp to the next. The model is stepped at the instants of the observations and at every
change of an input, so that its exact step answers for any rate.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tcp_muscle_ros.diagnosis.between import bends, weights
from tcp_muscle_ros.muscle import Outputs, Parameters, simulate
from tcp_muscle_ros.muscle.arrays import Array, Mask, Places

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.late import Late

STROKE = ('displacement', 'force')  # the channels that show it: free, and held
FOLLOWS_SETPOINT = 'follows_setpoint'  # in Experiment.known: a setpoint of the displacement was recorded
_CONTIGUOUS = 1.5  # times the width of two blocks: what lies farther apart has a gap between
_GROWS = 5.0  # at most, towards a step
_HOTTER = 20.0  # K: the fibre than its thermometer, at most


@dataclass(frozen=True)
class Imposed:
    """What was imposed: drive (A, W or V by ``kind``), load (N), ambient (K) at ``time`` (s), each shape (n,).

    ``switches``: when a record that samples the drive last showed a level, and first the next one (s), shape (k, 2);
    ``lost``: the same where samples between the two were lost. ``unsure``: what of the ambient its thermometer does not
    tell, K.
    """

    kind: str
    time: Array
    drive: Array
    load: Array
    ambient: Array
    switches: Array = field(default_factory=lambda: np.empty((0, 2)))
    lost: Array = field(default_factory=lambda: np.empty((0, 2)))
    unsure: float = 0.0


@dataclass(frozen=True)
class Holding:
    """What holds the end: as the arguments of Muscle."""

    end: str = 'load'
    starting_load: float = 0.0
    held_length: float = 0.0
    spring_rate: float = 0.0
    spring_rest_length: float = 0.0


@dataclass(frozen=True, eq=False)
class Observed:
    """One output channel: ``value`` (SI) at ``time`` (s), both shape (m,); ``count`` samples were averaged in each.

    ``spacing``: s between these samples; ``stretch``: which stretch without a step of an input each value lies in,
    shape (m,), None where nothing was averaged.
    ``swinging``: which were taken while a weight may swing, shape (m,), None: none of them; ``calm``: what these weigh.
    ``discrepancy``: ways in which the model may err here, each a column as large (SI) as it usually does, shape (m, n);
    ``unsure``: the same of what was imposed.
    """

    time: Array
    value: Array
    count: Array
    swinging: Mask | None = None
    calm: float = 1.0
    discrepancy: Array | None = None
    spacing: float = 0.0
    stretch: Array | None = None
    unsure: Array | None = None

    @cached_property
    def ways(self) -> Array | None:
        """All in which the model may err here, shape (m, n); None: none."""
        known = [columns for columns in (self.discrepancy, self.unsure) if columns is not None]
        return np.hstack(known) if known else None

    def averaged(self, shown: Array) -> Array:
        """What the mean over each block is where ``shown`` is what a model shows in its middle, both shape (m,).

        They differ by a 24th of the second difference over its width. The first and last of a stretch have that of
        their neighbour, which grows towards a step of the drive as it does from one to the next.
        """
        inner, first, last, width = self._bends
        if not inner.size:
            return shown
        slope = np.diff(shown) / np.diff(self.time)
        bend = np.zeros(shown.size)
        bend[inner] = 2.0 * (slope[inner] - slope[inner - 1]) / (self.time[inner + 1] - self.time[inner - 1])
        with np.errstate(divide='ignore', invalid='ignore'):
            growth = np.nan_to_num(bend[first + 1] / bend[first + 2], nan=1.0)
        bend[first] = bend[first + 1] * np.clip(growth, 1.0, _GROWS)
        bend[last] = bend[last - 1]
        return np.asarray(shown + bend * width / 24.0)

    @cached_property
    def _bends(self) -> tuple[Places, Places, Places, Array]:
        """The places of values between two others of their stretch, of those that follow a step, and of those before
        one; and the squared width of each (s^2)."""
        none = np.empty(0, dtype=int)
        if self.stretch is None or self.time.size < 4:
            return none, none, none, np.empty(0)
        wide = self.spacing * self.count
        near = np.diff(self.time) < _CONTIGUOUS * 0.5 * (wide[1:] + wide[:-1])
        joined = near & (np.diff(self.stretch) == 0)
        before, after = np.append(False, joined), np.append(joined, False)
        inside = before & after
        first = after & ~before & np.append(inside[1:], False) & np.append(inside[2:], [False, False])
        last = before & ~after & np.append(False, inside[:-1])
        width = self.spacing**2 * np.maximum(self.count**2 - 1.0, 0.0)
        return inside.nonzero()[0], first.nonzero()[0], last.nonzero()[0], width

    @cached_property
    def weight(self) -> Array:
        """What one value weighs beside a usual one: means of fewer samples are noisier."""
        weight = np.minimum(np.sqrt(self.count / np.median(self.count)), 1.0) if self.count.size else self.count
        return weight if self.swinging is None else np.where(self.swinging, self.calm, 1.0) * weight

    def only(self, keep: Mask) -> 'Observed':
        """Some of the values."""
        each = ('time', 'value', 'count', 'swinging', 'discrepancy', 'stretch', 'unsure')
        kept = {name: getattr(self, name) for name in each if getattr(self, name) is not None}
        return replace(self, **{name: entry[keep] for name, entry in kept.items()})


@dataclass(frozen=True)
class Draught:
    """The course of a draught, known at the ``knots`` (s): ``warmer``, the change of the room (K) that takes as much
    heat, shape as ``Imposed.time``; ``gust``: how it was described before; ``unsure``: by channel, how what stays
    unknown of it shows (SI), one column each."""

    knots: Array
    warmer: Array
    gust: tuple[float, ...] = ()
    unsure: Mapping[str, Array] = field(default_factory=dict)


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
class Experiment:
    """One recording as the model sees it.

    ``notes`` say what was assumed, for people to read; ``cycles`` and ``used`` (s): those of the recordings before it;
    ``draught``: what was inferred of one; ``slips``: those that were.
    """

    name: str
    imposed: Imposed
    holding: Holding
    observed: Mapping[str, Observed]
    known: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cycles: float = 0.0
    used: float = 0.0
    draught: Draught | None = None
    slips: tuple[Slip, ...] = ()

    def outputs(
        self,
        parameters: Parameters,
        temperature: float | None = None,
        resolution: float = 1.0,
        only: Collection[str] | None = None,
    ) -> Outputs:
        """The model's outputs (or only some) at ``imposed.time``; ``temperature`` (K) at the start, default the
        ambient."""
        imposed, holding = self.imposed, self.holding
        return simulate(
            parameters,
            imposed.time,
            imposed.drive,
            kind=imposed.kind,
            load=imposed.load,
            ambient=imposed.ambient if self.draught is None else imposed.ambient + self.draught.warmer,
            end=holding.end,
            starting_load=holding.starting_load,
            held_length=holding.held_length,
            spring_rate=holding.spring_rate,
            spring_rest_length=holding.spring_rest_length,
            temperature=temperature,
            resolution=resolution,
            hottest=self.hottest,
            only=only,
        )

    def predict(self, parameters: Parameters, temperature: float | None = None) -> dict[str, Array]:
        """What the model shows at the instants of each observed channel (SI, shapes as observed)."""
        return self.shown(self.outputs(parameters, temperature, only=self.observed))

    def until(self, end: float) -> 'Experiment':
        """Its beginning, with the first instant at or after ``end`` (s)."""
        inputs = self.imposed
        n = int(np.searchsorted(inputs.time, end)) + 1
        imposed = Imposed(inputs.kind, inputs.time[:n], inputs.drive[:n], inputs.load[:n], inputs.ambient[:n])
        observed = {name: o.only(o.time <= end) for name, o in self.observed.items()}
        return replace(self, imposed=imposed, observed=observed)

    def shown(self, outputs: Outputs, late: 'Late | None' = None) -> dict[str, Array]:
        """The model's outputs at the instants of each observed channel, read ``late`` where it is, less what slips
        took."""
        shown = {}
        for name, channel in self.observed.items():
            if late is not None and late.channel == name:
                shown[name] = late.seen(self.imposed, getattr(outputs, name), channel)
            else:
                places, weights = self._read[name]
                shown[name] = channel.averaged(np.sum(weights * getattr(outputs, name)[places], axis=1))
        for slip in self.slips:
            if slip.channel in shown:
                shown[slip.channel] -= slip.size * slip.after(self.observed[slip.channel].time)
        return shown

    @cached_property
    def _read(self) -> dict[str, tuple[Places, Array]]:
        """How the instants of each channel are read between those of the model."""
        imposed = self.imposed
        corner, jump = bends(imposed.drive, imposed.load)
        return {name: weights(imposed.time, corner, jump, observed.time) for name, observed in self.observed.items()}

    @cached_property
    def hottest(self) -> float | None:
        """K, that the muscle certainly did not exceed: a bead in its surface may show less than the fibre has."""
        seen = self.observed.get('temperature')
        return None if seen is None or not seen.value.size else float(seen.value.max()) + _HOTTER

    @property
    def duration(self) -> float:
        """From the first to the last instant, s."""
        return float(self.imposed.time[-1] - self.imposed.time[0])
