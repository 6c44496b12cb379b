"""A recording made ready for the model: what was imposed, when the model is stepped, and what was seen.

An input holds from its stamp to the next. The model is stepped at the instants of the observations and at every
change of an input, so that its exact step answers for any rate. Long recordings are averaged in blocks that never
straddle a change of the drive.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import overload

import numpy as np

from tcp_muscle_ros.diagnosis.noise import white_sigma
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import KINDS, Outputs, Parameters, simulate
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.recording.plausibility import distance
from tcp_muscle_ros.recording.recording import OUTPUTS, Channel, Recording

FOLLOWS_SETPOINT = 'follows_setpoint'  # in Experiment.known: a setpoint of the displacement was recorded
_SAME_INSTANT = 1e-6  # s: stamps closer than this are one
_INTERPOLATED = 0.15  # s: a muscle's temperature bends by less than a hundredth of a kelvin in twice that
_UNSURE = 1.6  # sampling periods either side of a step of the load
_JUMP = 0.05  # of an input's span: more from one sample to the next is a step, not noise or a ramp
_RINGING, _SWINGING = 1.5, 5.0  # s after a step of the load: a swing is strong, and may still be seen
_QUICK = 0.01  # s: a swing at 5 Hz is smaller by half a percent when averaged over so long
_STEPS_APART = 2.0  # s, on average: steps of a load that are closer are none
_BEYOND_NOISE, _CONSTANT = 8.0, 2.0  # of the noise of a force: a step of it, and what a constant one may scatter by
_HOTTER = 20.0  # K: the fibre than its thermometer, at most
_LEAST_SENSE_CURRENT = 1e-3  # A: resistance from voltage and current needs a current


@dataclass(frozen=True)
class Imposed:
    """What was imposed: drive (A, W or V by ``kind``), load (N), ambient (K) at ``time`` (s), each shape (n,)."""

    kind: str
    time: Array
    drive: Array
    load: Array
    ambient: Array


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

    ``swinging``: which were taken while a weight may swing, shape (m,), None: none of them; ``calm``: what these weigh.
    ``discrepancy``: ways in which the model may err here, each a column as large (SI) as it usually does, shape (m, n).
    """

    time: Array
    value: Array
    count: Array
    swinging: Mask | None = None
    calm: float = 1.0
    discrepancy: Array | None = None

    @cached_property
    def weight(self) -> Array:
        """What one value weighs beside a usual one: means of fewer samples are noisier."""
        weight = np.minimum(np.sqrt(self.count / np.median(self.count)), 1.0) if self.count.size else self.count
        return weight if self.swinging is None else np.where(self.swinging, self.calm, 1.0) * weight

    def only(self, keep: Mask) -> 'Observed':
        """Some of the values."""
        swinging = None if self.swinging is None else self.swinging[keep]
        discrepancy = None if self.discrepancy is None else self.discrepancy[keep]
        return Observed(self.time[keep], self.value[keep], self.count[keep], swinging, self.calm, discrepancy)


@dataclass(frozen=True)
class Draught:
    """The course of a draught: ``share``, by which it raises the conductance, shape (knots,); ``warmer``, the change of
    the room (K) that takes as much heat, shape as ``Imposed.time``; ``gust``: how it was described before; ``unsure``:
    by channel, how what stays unknown of it shows (SI), one column each."""

    share: Array
    warmer: Array
    gust: tuple[float, ...] = ()
    unsure: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Experiment:
    """One recording as the model sees it.

    ``notes`` say what was assumed, for people to read; ``cycles``: those of the recordings before it; ``draught``: what
    was inferred of one.
    """

    name: str
    imposed: Imposed
    holding: Holding
    observed: Mapping[str, Observed]
    known: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cycles: float = 0.0
    draught: Draught | None = None

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

    def shown(self, outputs: Outputs) -> dict[str, Array]:
        """The model's outputs at the instants of each observed channel."""
        return {
            name: np.interp(channel.time, outputs.time, getattr(outputs, name))
            for name, channel in self.observed.items()
        }

    @cached_property
    def hottest(self) -> float | None:
        """K, that the muscle certainly did not exceed: a bead in its surface may show less than the fibre has."""
        seen = self.observed.get('temperature')
        return None if seen is None or not seen.value.size else float(seen.value.max()) + _HOTTER

    @property
    def duration(self) -> float:
        """From the first to the last instant, s."""
        return float(self.imposed.time[-1] - self.imposed.time[0])


@dataclass(frozen=True)
class Conditions:
    """What a recording may not say itself (SI): used where no channel and no known fact does."""

    load: float | None = None
    ambient: float | None = None
    end: str | None = None
    held_length: float = 0.0
    spring_rate: float = 0.0
    spring_rest_length: float = 0.0


def prepare(
    recording: Recording, nominal: Parameters, conditions: Conditions | None = None, most: int | None = None
) -> Experiment:
    """Make a recording ready for the model.

    Args:
        recording: channels in SI.
        nominal: the muscle as assumed; gives the ambient (T0) where nothing else does.
        conditions: what the user states about the run.
        most: the largest number of observations a channel; longer ones are averaged in blocks.

    Raises:
        BadInput: no input, no output, or fewer than two samples of them.
    """
    conditions = conditions or Conditions()
    notes: list[str] = list(recording.notes)
    kind, drive = _drive(recording)
    observed = {name: recording[name] for name in OUTPUTS if name in recording and len(recording[name]) > 1}
    if 'resistance' not in observed and {'voltage', 'current'} <= set(recording.channels):
        derived = _resistance(recording)
        if derived is not None:
            observed['resistance'] = derived
            notes.append('resistance was derived as voltage over current')
    holding, load, used = _holding(recording, observed, conditions, notes)
    if used is not None:
        observed.pop(used, None)
    if not observed:
        raise BadInput(
            f'{recording.path}: nothing to compare: expected at least one of {", ".join(OUTPUTS)} beside {kind}'
        )
    ambient = recording.channels.get('ambient')
    still = _number(recording.known.get('ambient_c'), 273.15)
    if still is None:
        still = conditions.ambient if conditions.ambient is not None else nominal['T0']
    drive = _coarsened(drive, most, 1.0 if kind == 'power' else 2.0)
    load = _coarsened(load, most, 1.0)
    start = max(float(drive.time[0]), 0.0)
    end = max(float(channel.time[-1]) for channel in observed.values())
    blocks: dict[str, Observed] = {}
    for name, channel in observed.items():
        made = _blocks(channel, drive, load, most, start)
        same = next((b.time for b in blocks.values() if np.array_equal(b.time, made.time)), made.time)
        blocks[name] = replace(made, time=same)
    grid = _grid([channel.time for channel in blocks.values()], drive, load, start, end)
    imposed = Imposed(
        kind,
        grid,
        _hold(drive, grid),
        np.maximum(_hold(load, grid), 0.0) if isinstance(load, Channel) else np.full(grid.size, load),
        _hold(ambient, grid) if ambient is not None and len(ambient) else np.full(grid.size, still),
    )
    known = dict(recording.known)
    if len(recording.channels.get('displacement_setpoint', ())):
        known[FOLLOWS_SETPOINT] = True
    return Experiment(recording.path, imposed, holding, blocks, known, tuple(notes))


def _drive(recording: Recording) -> tuple[str, Channel]:
    """The input that was applied; the commanded one where the applied was not recorded."""
    for suffix in ('', '_command'):
        for kind in KINDS:
            name = f'{kind}{suffix}'
            if name in recording and len(recording[name]) > 0:
                return kind, recording[name]
    raise BadInput(
        f'{recording.path}: no input recorded: expected a channel current, power or voltage '
        '(name one with --channel current=TOPIC)'
    )


def _resistance(recording: Recording) -> Channel | None:
    current, voltage = recording['current'], recording['voltage']
    i = _hold(current, voltage.time)
    flows = np.abs(i) > _LEAST_SENSE_CURRENT
    if flows.sum() < 2:
        return None
    return Channel(
        'resistance', voltage.time[flows], voltage.value[flows] / i[flows], f'{voltage.topic}/{current.topic}'
    )


def _number(value: object, offset: float = 0.0) -> float | None:
    return float(value) + offset if isinstance(value, int | float) and not isinstance(value, bool) else None


def _holding(
    recording: Recording, observed: Mapping[str, Channel], conditions: Conditions, notes: list[str]
) -> tuple[Holding, Channel | float, str | None]:
    """What holds the end, the load (a channel or a constant), and the output that thereby became an input."""
    known = recording.known
    stated = known.get('end') if isinstance(known.get('end'), str) else conditions.end
    end = str(stated) if stated else _guess_end(observed)
    load: Channel | float
    used = None
    constant = _number(known.get('load_n'))
    if constant is None:
        constant = conditions.load
    if 'load' in recording and len(recording['load']):
        force = observed.get('force') if end == 'load' else None
        if force is not None and _in_steps(force, recording['load']):
            load = Channel('load', force.time, force.value, force.topic)  # stamped with its ticks, as a message is not
        else:
            load = _from_the_start(recording['load'], constant, force)
        used = 'force' if end == 'load' else None
    elif end == 'load' and 'force' in observed:
        load, used = observed['force'], 'force'  # the force at a loaded end is the load
        if np.ptp(load.value) <= 0.02 * max(float(np.median(load.value)), 1e-9):
            load = float(np.median(load.value))
        else:
            load = _levels(load)
    elif constant is not None:
        load = constant
    else:
        load = 0.0
        notes.append('no load was recorded or stated: taken as 0 N; state load_n in --params')
    if end == 'blocked' and 'displacement' in observed:
        used = 'displacement'
    first = _first(load) if isinstance(load, Channel) else load
    rate = _number(known.get('spring_rate_n_per_m')) or conditions.spring_rate
    if end == 'spring' and not rate:
        rate = _spring_rate(observed, recording.path)
        notes.append(f'spring rate {rate:.3g} N/m taken from force against displacement')
    start = constant if constant is not None else max(first, 0.0)
    return (
        Holding(
            end,
            start,
            _number(known.get('held_length_m')) or conditions.held_length,
            rate,
            _number(known.get('spring_rest_length_m')) or conditions.spring_rest_length,
        ),
        load,
        used,
    )


def _first(load: Channel) -> float:
    """What pulls at the start: a measured force is noisy, a load is told as often as it changes."""
    return float(np.median(load.value[:5])) if load.name == 'force' else float(load.value[0])


def _levels(force: Channel) -> Channel:
    """A measured force without its noise, where it is that of weights: constant between few steps; else as it is."""
    noise = white_sigma(force.value)
    steps = np.flatnonzero(np.abs(np.diff(force.value)) > _BEYOND_NOISE * noise) + 1
    if noise == 0.0 or steps.size * _STEPS_APART > force.time[-1] - force.time[0]:
        return force
    segments = np.split(force.value, steps)
    levels = np.array([float(np.median(part)) for part in segments])
    left = np.concatenate([part - level for part, level in zip(segments, levels, strict=True)])
    if float(np.sqrt(np.mean(left**2))) > _CONSTANT * noise:
        return force
    return replace(force, time=force.time[np.append(0, steps)], value=levels)


def _in_steps(force: Channel, load: Channel) -> bool:
    """Whether a force is the load itself, without noise: constant but for about as many steps as were told."""
    return bool(np.count_nonzero(np.diff(force.value)) <= 2 * (1 + _changes(load).size))


def _from_the_start(load: Channel, stated: float | None, force: Channel | None) -> Channel:
    """The load with what pulled before it was first said: the stated load, else the force at the loaded end."""
    first = float(load.time[0])
    if stated is None and force is not None and np.any(force.time < first):
        stated = float(np.median(force.value[force.time < first]))
    if first <= 0.0 or stated is None:
        return load
    return Channel(load.name, np.append(0.0, load.time), np.append(max(stated, 0.0), load.value), load.topic)


def _guess_end(observed: Mapping[str, Channel]) -> str:
    """A force that changes is a held end's; beside a displacement that changes with it, a spring's."""
    if 'force' not in observed:
        return 'load'
    force = observed['force'].value
    if np.ptp(force) <= 0.05 * max(float(np.max(np.abs(force))), 1e-9):
        return 'load'
    if 'displacement' not in observed or np.ptp(observed['displacement'].value) < 1e-5:
        return 'blocked'
    at = observed['displacement']
    f = np.interp(at.time, observed['force'].time, force)
    correlation = float(np.corrcoef(f, at.value)[0, 1])
    return 'spring' if correlation > 0.98 else 'load'


def _spring_rate(observed: Mapping[str, Channel], path: str) -> float:
    if not {'force', 'displacement'} <= set(observed):
        raise BadInput(
            f"{path}: end 'spring' without a rate: state spring_rate_n_per_m, or record force and displacement"
        )
    at = observed['displacement']
    f = np.interp(at.time, observed['force'].time, observed['force'].value)
    return float(max(np.polyfit(at.value, f, 1)[0], 1e-3))


def _hold(channel: Channel | float, grid: Array) -> Array:
    """The value that holds at each instant: the latest at or before it (the first before the first)."""
    if not isinstance(channel, Channel):
        return np.full(grid.size, channel)
    at = np.searchsorted(channel.time, grid + _SAME_INSTANT, side='right') - 1
    return channel.value[np.maximum(at, 0)]


def _changes(channel: Channel | float) -> Array:
    """The stamps at which an input takes a new value."""
    if not isinstance(channel, Channel):
        return np.empty(0)
    return np.asarray(channel.time[1:][np.diff(channel.value) != 0.0])


def _grid(stamps: list[Array], drive: Channel, load: Channel | float, start: float, end: float) -> Array:
    """The instants at which the model is stepped: the densest channel's, what others have beyond it, all changes.

    Channels stamped within a fraction of a second of an instant are interpolated; a channel that goes on where the
    densest has a gap (resistance is read under current only) brings its own.
    """
    by_size = sorted(stamps, key=len, reverse=True)
    instants = by_size[0]
    for other in by_size[1:]:
        instants = np.union1d(instants, other[distance(other, instants) > _INTERPOLATED])
    # The length jumps with the load: the instant just before keeps interpolation from reaching across.
    jumps = _changes(load)
    instants = np.concatenate([np.array([start, end]), instants, _changes(drive), jumps, jumps - 2.0 * _SAME_INSTANT])
    instants = np.unique(instants[(instants >= start) & (instants <= end)])
    keep = np.concatenate([[True], np.diff(instants) > 0.9 * _SAME_INSTANT])
    return np.ascontiguousarray(instants[keep])


@overload
def _coarsened(channel: Channel, most: int | None, power: float) -> Channel: ...


@overload
def _coarsened(channel: Channel | float, most: int | None, power: float) -> Channel | float: ...


def _coarsened(channel: Channel | float, most: int | None, power: float) -> Channel | float:
    """An input that changes at nearly every sample, held at its mean over blocks that end at its jumps.

    ``power`` 2 keeps the mean square, by which currents and voltages heat.
    """
    if most is None or not isinstance(channel, Channel) or _changes(channel).size <= 2 * most:
        return channel
    jumps = np.abs(np.diff(channel.value)) > _JUMP * float(np.ptp(channel.value))
    segment = np.concatenate([[0], np.cumsum(jumps)])
    first = np.concatenate([[0], np.flatnonzero(jumps) + 1])
    position = np.arange(segment.size) - first[segment]
    begins = (position % int(np.ceil(segment.size / most))) == 0
    label = np.cumsum(begins) - 1
    count = np.bincount(label)
    size = (np.bincount(label, np.abs(channel.value) ** power) / count) ** (1.0 / power)
    return replace(channel, time=channel.time[begins], value=size * np.sign(np.bincount(label, channel.value)))


def _edges(drive: Channel, samples: int) -> Array:
    """The changes of the drive that are edges: none where it changes at nearly every tick."""
    changes = _changes(drive)
    return changes if changes.size <= samples // 4 else np.empty(0)


def _steps(load: Channel | float, channel: Channel) -> Array:
    """When a weight was changed, while this channel was recorded; in a load that changes all the time, when it changed
    far more than it usually does."""
    steps = _changes(load)
    most = float(channel.time[-1] - channel.time[0]) / _STEPS_APART if channel.time.size else 0.0
    if isinstance(load, Channel) and steps.size > most:
        size = np.abs(np.diff(load.value))
        unusual = max(_JUMP * float(np.ptp(load.value)), _BEYOND_NOISE * float(np.median(size)))
        steps = load.time[1:][size > unusual]
    return steps if steps.size <= most else np.empty(0)


def _blocks(channel: Channel, drive: Channel, load: Channel | float, most: int | None, start: float) -> Observed:
    """The channel from ``start`` on, averaged in blocks where it has more than ``most`` samples.

    A muscle answers a step of the load at once (its temperature may too), and whether the samples around its stamp were
    taken before or after it no recording says (a message may reach the recorder before it reaches the rig): they are
    left out. What follows within seconds, in which a hanging weight swings, is averaged over hundredths of one only.
    """
    kept = channel.time >= start - _SAME_INSTANT
    steps = _steps(load, channel)
    if steps.size and channel.time.size > 1:
        near = _UNSURE * float(np.median(np.diff(channel.time)))
        kept &= distance(channel.time, steps) > near
    time, value = (channel.time, channel.value) if kept.all() else (channel.time[kept], channel.value[kept])
    since = _since(steps, time)
    ringing, swinging = since < _RINGING, since < _SWINGING
    moves = channel.name in ('displacement', 'force') and bool(swinging.any())
    if most is None or time.size <= most:
        return Observed(time, value, np.broadcast_to(1.0, time.size), swinging if moves else None)
    width = int(np.ceil(time.size / most))
    segment = np.searchsorted(np.union1d(_edges(drive, time.size), steps), time, side='right')
    first = np.concatenate([[0], np.flatnonzero(np.diff(segment)) + 1])
    position = np.arange(time.size) - np.repeat(first, np.diff(np.append(first, time.size)))
    quick = max(1, round(_QUICK / max(float(np.median(np.diff(time))), 1e-9)))
    begins = (position % np.where(ringing, quick, width) == 0)[1:] | np.diff(ringing) | (np.diff(segment) != 0)
    label = np.cumsum(np.concatenate([[0], begins]))
    count = np.bincount(label).astype(float)
    means = np.bincount(label, time) / count, np.bincount(label, value) / count
    return Observed(*means, count, np.bincount(label, swinging) > 0.0 if moves else None)


def _since(events: Array, time: Array) -> Array:
    """How long ago (s) the last of the events was at each instant; inf before any."""
    before = np.searchsorted(events, time, side='right')
    return np.asarray(time - np.append(-np.inf, events)[before])
