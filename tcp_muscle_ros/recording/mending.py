"""What can be saved of a damaged recording: stretches of a dead sensor are left out, and it is cut where input is lost.

A model run needs to know what was imposed at every instant. Where the input falls silent, or where the muscle is
suddenly another than a sample before (two runs in one bag), the recording is cut, and each part starts anew.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.recording.checks import Issue, is_noisy, runs
from tcp_muscle_ros.recording.inputs import drive_of, hold, window
from tcp_muscle_ros.recording.recording import CHANNELS, OUTPUTS, Array, Channel, Recording

FEWEST = 8  # values of a channel: of fewer no noise is told (see diagnosis/noise/noise.py), and no motion
RESUMED = 'resumed'  # in Recording.known: begins in the middle of something, at no known temperature
_STILL = 20  # samples, and
_STILL_S = 2.0  # s of one value, in a channel that is noisy
_LONG_STILL_S = 15.0  # s of one value, in any channel, while the input switches
_UNKNOWN_S = 5.0  # s without the input
_CHANGED_S = 1.0  # s without it, when it then has another value
_SEAM = {'temperature': 0.25, 'displacement': 0.5}  # of the span, within a sample
_QUICK = 1.0  # s between neighbours
_SHORTEST = 5.0  # s of a part


class Mended(NamedTuple):
    """The parts of one recording that a model can follow, and the sensors of it that stood still."""

    parts: tuple[Recording, ...]
    faults: tuple[Issue, ...]


def mend(recording: Recording) -> Mended:
    """Leave out what a dead sensor shows, cut where the input is lost or another run begins. Notes say what was done.

    A sound recording comes back as it is.
    """
    channels, faults, notes = dict(recording.channels), [], list(recording.notes)
    for name in _live_outputs(recording):
        channel, drive = recording[name], drive_of(recording)
        dead = standing_still(channel, drive)
        if not dead.any():
            continue
        faults.append(_fault(channel, dead))
        notes.append(f'{faults[-1].sentence}: left out')
        if np.count_nonzero(~dead) < _STILL:
            del channels[name]
        else:
            channels[name] = Channel(name, channel.time[~dead], channel.value[~dead], channel.topic)
    whole = Recording(recording.path, channels, recording.start_ns, recording.known, tuple(notes), recording.units)
    return Mended(_parts(whole), tuple(faults))


def _live_outputs(recording: Recording) -> list[str]:
    """The outputs that should move: a held end has no stroke, a hanging weight a constant force."""
    found = [n for n, c in recording.channels.items() if CHANNELS[n].role == 'output' and len(c) >= _STILL]
    force = recording.channels.get('force')
    moves = force is not None and float(np.ptp(force.value)) > 0.05 * max(float(np.max(np.abs(force.value))), 1e-9)
    return [name for name in found if not (name == 'displacement' and moves) and name != 'force']


def standing_still(channel: Channel, drive: Channel | None) -> NDArray[np.bool_]:
    """Which samples a dead sensor gave: bit for bit one value, although it is noisy elsewhere or the input switches."""
    time, value = channel.time, channel.value
    dead = np.zeros(len(channel), dtype=bool)
    stretches = [
        (first, last)
        for first, last in runs(np.diff(value) == 0)
        if last - first >= _STILL and time[last] - time[first] >= _STILL_S
    ]
    for first, last in stretches:
        # The value before and after belongs to the living sensor; a stretch at the very beginning has no before.
        others = np.concatenate([value[: first + 1], value[last:]])
        if (len(others) > _STILL and is_noisy(others)) or _while_switching(drive, time[first], time[last]):
            dead[first if first == 0 else first + 1 : last + 1] = True
    return dead


def _while_switching(drive: Channel | None, start: float, end: float) -> bool:
    """Does the input switch in a stretch, and stay for seconds?"""
    if drive is None or end - start < _LONG_STILL_S:
        return False
    inside = hold(drive, np.linspace(start, end, 200))
    large = float(np.max(np.abs(drive.value)))
    on = np.abs(inside) > 0.4 * large
    return large > 0.0 and bool(0.2 < np.mean(on) < 1.0)


def _fault(channel: Channel, dead: NDArray[np.bool_]) -> Issue:
    time = channel.time[dead]
    start, end = float(time[0]), float(time[-1])
    share = f'{100 * np.mean(dead):.0f} % of its samples'
    told = f'{channel.name} stands still from {start:.1f} s to {end:.1f} s ({share}) while the muscle is driven'
    return Issue(channel.name, 'stuck', (start, end), told)


def _parts(recording: Recording) -> tuple[Recording, ...]:
    drive = drive_of(recording)
    if drive is None or len(drive) < 2 or not any(CHANNELS[n].role == 'output' for n in recording.channels):
        return (recording,)
    cuts = _merged([*_silences(drive), *((t, t, why) for t, why in _seams(recording))])
    if not cuts:
        return (recording,)
    ends = [0.0, *(t for cut in cuts for t in cut[:2]), recording.duration]
    spans = [
        (a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a >= _SHORTEST and _seen(recording, a, b)
    ]
    why = '; '.join(cut[2] for cut in cuts)
    if not spans:
        return (recording,)
    found = []
    for k, (start, end) in enumerate(spans, 1):
        note = f'part {k} of {len(spans)}, {start:.1f} s to {end:.1f} s of the recording, which was cut: {why}'
        known: Mapping[str, object] = recording.known if start == 0.0 else {**recording.known, RESUMED: True}
        channels = {n: c for n, c in ((n, window(c, start, end)) for n, c in recording.channels.items()) if len(c)}
        start_ns = recording.start_ns + round(start * 1e9)
        found.append(Recording(recording.path, channels, start_ns, known, (*recording.notes, note), recording.units))
    return tuple(found)


def _seen(recording: Recording, start: float, end: float) -> bool:
    """Whether an output has values enough in a part."""
    times = (recording[name].time for name in OUTPUTS if name in recording)
    return any(np.count_nonzero((time >= start) & (time < end)) >= FEWEST for time in times)


def _merged(cuts: list[tuple[float, float, str]]) -> list[tuple[float, float, str]]:
    """(start, end, sentence) in order of time; those that overlap as one: a run may begin within a silence."""
    merged: list[tuple[float, float, str]] = []
    for start, end, why in sorted(cuts):
        if merged and start <= merged[-1][1]:
            first, last, said = merged.pop()
            start, end, why = first, max(last, end), f'{said}; {why}'
        merged.append((start, end, why))
    return merged


def _silences(drive: Channel) -> list[tuple[float, float, str]]:
    """(last word, next word, sentence) of an input that otherwise speaks regularly and falls silent."""
    step = np.diff(drive.time)
    period = float(np.median(step))
    if drive.name.endswith('_command') or len(step) < 20 or float(np.percentile(step, 95)) > 2.0 * period:
        return []  # it speaks when it changes, and holds until then
    unlike = np.abs(np.diff(drive.value)) > 0.02 * max(float(np.ptp(drive.value)), 1e-12)
    silent = (step > max(_UNKNOWN_S, 5.0 * period)) | (unlike & (step > max(_CHANGED_S, 5.0 * period)))
    return [
        (
            float(drive.time[k]) + period,
            float(drive.time[k + 1]),
            f'no {drive.name} for {step[k]:.1f} s from {drive.time[k]:.1f} s',
        )
        for k in np.flatnonzero(silent)
    ]


def _seams(recording: Recording) -> list[tuple[float, str]]:
    """(instant, sentence) at which the muscle is another than a sample before: neither heat nor stroke can leap."""
    load = recording.channels.get('load')
    loaded = load.time[1:][np.diff(load.value) != 0.0] if load is not None else np.empty(0)
    for name, share in _SEAM.items():
        channel = recording.channels.get(name)
        if channel is None or len(channel) < 50:
            continue
        step = np.abs(_sustained_steps(channel.value))
        large = max(share * float(np.ptp(channel.value)), 4.0 * float(np.percentile(step, 99.0)))
        found: list[float] = []
        for k in np.flatnonzero((step > large) & (np.diff(channel.time) < _QUICK)).tolist():
            at = float(channel.time[k + 1])
            by_load = name == 'displacement' and bool(np.any(np.abs(loaded - at) < 1.0))
            if not by_load and (not found or at - found[-1] > _SHORTEST):
                found.append(at)
        if found:
            return [(at, f'{name} jumps at {at:.1f} s, which no muscle does: another run begins there') for at in found]
    return []


def _sustained_steps(value: Array) -> Array:
    """The step from each sample to the next where it stays: of the medians of three either side, shape (n - 1,)."""
    padded = np.concatenate([np.full(2, value[0]), value, np.full(2, value[-1])])
    median = np.median(np.lib.stride_tricks.sliding_window_view(padded, 3), axis=1)  # around k - 1
    step = median[3:] - median[:-3]
    alone = np.diff(value)
    return np.where(np.abs(step) < np.abs(alone), step, alone)
