"""When the model is stepped, and what it is compared with: long recordings are averaged in blocks that never straddle a
change of the drive, nor a gap longer than a block."""

from dataclasses import replace
from typing import overload

import numpy as np

from tcp_muscle_ros.diagnosis.model.tcp_muscle import STROKE
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.muscle.arrays import Array, Mask
from tcp_muscle_ros.recording.inputs import SAME_INSTANT, changes, distance
from tcp_muscle_ros.recording.recording import Channel

_INTERPOLATED = 0.15  # s: a muscle's temperature bends by less than a hundredth of a kelvin in twice that
_UNSURE = 1.6  # sampling periods either side of a step of the load
_JUMP = 0.05  # of an input's span: more from one sample to the next is a step, not noise or a ramp
_UNUSUAL = 8.0  # times the usual change of a load that changes all the time: a step
_RINGING, _SWINGING = 1.5, 5.0  # s after a step of the load: a swing is strong, and may still be seen
_SHOWS_SWINGS, _BENDS = 0.1, 2.0  # s; sampling periods
_RINGS, _SINGLE = 2.6, 9.0  # times the square that noise makes: on average, and the most that one counts for
_QUICK = 0.01  # s: a swing at 5 Hz is smaller by half a percent when averaged over so long
# Of the samples; and sampling periods: of what lies farther apart samples were lost; or it was not sampled at a rhythm.
_FEW, _RHYTHM, _LOST = 0.1, 1.5, 10.5
STEPS_APART = 2.0  # s, on average: steps of a load that are closer are none


def instants_of(stamps: list[Array], drive: Channel, load: Channel | float, start: float, end: float) -> Array:
    """The instants at which the model is stepped: the densest channel's, what others have beyond it, all changes.

    Channels stamped within a fraction of a second of an instant are interpolated; a channel that goes on where the
    densest has a gap (resistance is read under current only) brings its own.
    """
    by_size = sorted(stamps, key=len, reverse=True)
    instants = by_size[0]
    for other in by_size[1:]:
        instants = np.union1d(instants, other[distance(other, instants) > _INTERPOLATED])
    # The length jumps with the load: the instant just before keeps interpolation from reaching across.
    jumps = changes(load)
    instants = np.concatenate([np.array([start, end]), instants, changes(drive), jumps, jumps - 2.0 * SAME_INSTANT])
    instants = np.unique(instants[(instants >= start) & (instants <= end)])
    keep = np.concatenate([[True], np.diff(instants) > 0.9 * SAME_INSTANT])
    return np.ascontiguousarray(instants[keep])


def _jumps(channel: Channel) -> Mask:
    """Where an input steps from one sample to the next, shape (n - 1,)."""
    return np.asarray(np.abs(np.diff(channel.value)) > _JUMP * float(np.ptp(channel.value)))


def switches(drive: Channel) -> tuple[Array, Array]:
    """When a record that samples the drive at a rhythm last showed a level, and first the next one (s), shape (k, 2);
    and the same of those where samples between the two were lost.

    None in a record of the changes alone, which says when they were, nor where the drive changes all the time.
    """
    steps = np.flatnonzero(_jumps(drive))
    found = np.column_stack([drive.time[steps], drive.time[steps + 1]])
    if not steps.size or steps.size > _FEW * drive.time.size:
        return np.empty((0, 2)), np.empty((0, 2))
    periods = np.diff(found)[:, 0] / float(np.median(np.diff(drive.time)))
    return found[periods <= _RHYTHM], found[(periods > _RHYTHM) & (periods <= _LOST)]


@overload
def coarsened(channel: Channel, most: int | None, power: float) -> Channel: ...


@overload
def coarsened(channel: Channel | float, most: int | None, power: float) -> Channel | float: ...


def coarsened(channel: Channel | float, most: int | None, power: float) -> Channel | float:
    """An input that changes at nearly every sample, held at its mean over blocks that end at its jumps.

    ``power`` 2 keeps the mean square, by which currents and voltages heat.
    """
    if most is None or not isinstance(channel, Channel) or changes(channel).size <= 2 * most:
        return channel
    jumps = _jumps(channel)
    segment = np.concatenate([[0], np.cumsum(jumps)])
    first = np.concatenate([[0], np.flatnonzero(jumps) + 1])
    position = np.arange(segment.size) - first[segment]
    begins = (position % int(np.ceil(segment.size / most))) == 0
    label = np.cumsum(begins) - 1
    count = np.bincount(label)
    size = (np.bincount(label, np.abs(channel.value) ** power) / count) ** (1.0 / power)
    return replace(channel, time=channel.time[begins], value=size * np.sign(np.bincount(label, channel.value)))


def _edges(drive: Channel, samples: int) -> Array:
    """The changes of the drive that are edges: its jumps where an ammeter's noise changes it at nearly every tick; none
    where it jumps as often."""
    found = changes(drive)
    if found.size > samples // 4:
        found = drive.time[1:][_jumps(drive)]
    return found if found.size <= samples // 4 else np.empty(0)


def _steps(load: Channel | float, channel: Channel) -> Array:
    """When a weight was changed, while this channel was recorded; in a load that changes all the time, when it changed
    far more than it usually does."""
    steps = changes(load)
    most = float(channel.time[-1] - channel.time[0]) / STEPS_APART if channel.time.size else 0.0
    if isinstance(load, Channel) and steps.size > most:
        size = np.abs(np.diff(load.value))
        unusual = max(_JUMP * float(np.ptp(load.value)), _UNUSUAL * float(np.median(size)))
        steps = load.time[1:][size > unusual]
    return steps if steps.size <= most else np.empty(0)


def averaged(channel: Channel, drive: Channel, load: Channel | float, most: int | None, start: float) -> Observed:
    """The channel from ``start`` on, averaged in blocks where it has more than ``most`` samples.

    A muscle answers a step of the load at once (its temperature may too), and whether the samples around its stamp were
    taken before or after it no recording says (a message may reach the recorder before it reaches the rig): they are
    left out. What follows within seconds, in which a hanging weight swings, is averaged over hundredths of one only; so
    is what follows an edge of the drive, where the readings swing after those.
    """
    kept = channel.time >= start - SAME_INSTANT
    steps = _steps(load, channel)
    if steps.size and channel.time.size > 1:
        near = _UNSURE * float(np.median(np.diff(channel.time)))
        kept &= ~_within(channel.time, steps - near, 2.0 * near)
    time, value = (channel.time, channel.value) if kept.all() else (channel.time[kept], channel.value[kept])
    edges = _edges(drive, time.size)
    if channel.name in STROKE:  # beside a step of the load it swings anyhow
        alone = edges[distance(edges, steps) > _SWINGING]
        started = np.union1d(steps, _ringing_after(time, value, alone, most))
    else:
        started = steps
    ringing, swinging = _within(time, started, _RINGING), _within(time, started, _SWINGING)
    moves = channel.name in STROKE and bool(swinging.any())
    if most is None or time.size <= most:
        return Observed(time, value, np.broadcast_to(1.0, time.size), swinging if moves else None)
    width = int(np.ceil(time.size / most))
    period = float(np.median(np.diff(time)))
    resumed = time[1:][np.diff(time) > (width + 1) * period]
    ends = np.unique(np.concatenate([edges, steps, resumed]))
    segment = np.searchsorted(ends, time, side='right')
    first = np.concatenate([[0], np.flatnonzero(np.diff(segment)) + 1])
    position = np.arange(time.size) - np.repeat(first, np.diff(np.append(first, time.size)))
    quick = max(1, round(_QUICK / max(period, 1e-9)))
    begins = (position % np.where(ringing, quick, width) == 0)[1:] | np.diff(ringing) | (np.diff(segment) != 0)
    label = np.cumsum(np.concatenate([[0], begins]))
    count = np.bincount(label).astype(float)
    means = np.bincount(label, time) / count, np.bincount(label, value) / count
    return Observed(
        *means,
        count,
        np.bincount(label, swinging) > 0.0 if moves else None,
        spacing=period,
        stretch=segment[np.append(0, np.flatnonzero(begins) + 1)],
        within=white_sigma(value) ** 2 * (1.0 - count.size / value.size),
    )


def _ringing_after(time: Array, value: Array, edges: Array, most: int | None) -> Array:
    """The edges of the drive after which a stroke swings, the widest swings first as far as half of ``most`` reaches;
    none where readings do not change faster there than noise makes them."""
    period = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    if most is None or not 0.0 < period <= _SHOWS_SWINGS or edges.size == 0:
        return np.empty(0)
    quiet = 6.0 * white_sigma(value, _within(time, edges, _SWINGING)) ** 2
    # Across a gap, or as something slips, a few are far larger, and tell nothing of swings.
    whole = time[2:] - time[:-2] < 2.5 * period
    bend, middle = np.minimum(np.diff(value, 2) ** 2, _SINGLE * quiet)[whole], time[1:-1][whole]
    # The stroke bends at the edge itself, whatever hangs on it.
    each = [bend[_within(middle, np.array([edge + _BENDS * period]), _RINGING - _BENDS * period)] for edge in edges]
    after = np.concatenate(each)
    if not after.size or np.mean(after) < _RINGS * quiet:
        return np.empty(0)
    strongest = np.argsort([-float(np.mean(one)) if one.size else 0.0 for one in each])
    return np.sort(edges[strongest[: max(1, int(0.5 * most * period / _RINGING))]])


def _within(time: Array, events: Array, span: float) -> Mask:
    """Which instants are at an event or less than ``span`` (s) after one."""
    found = np.zeros(time.size, dtype=bool)
    for begin, end in zip(np.searchsorted(time, events), np.searchsorted(time, events + span), strict=True):
        found[begin:end] = True
    return found
