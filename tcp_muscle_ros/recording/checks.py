"""What is wrong with a recording, before anyone fits a model to it.

Each check looks at one channel alone and says what it found, where, in a sentence. Nothing is mended here.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.recording.inputs import drive_of, hold
from tcp_muscle_ros.recording.instruments import ROUNDED, instrument_faults
from tcp_muscle_ros.recording.plausibility import Misread, misread
from tcp_muscle_ros.recording.recording import CHANNELS, Array, Recording
from tcp_muscle_ros.recording.units import UNITS


class Issue(NamedTuple):
    """One finding.

    kind      gap, pause, jitter, duplicate, backwards, stuck, not_finite, saturation, quantisation, unit, short, and
              of instruments: held, tone, switch, clock, contradiction, undersampled
    interval  s from the recording's start, from where to where it was seen
    misread   of a unit: what was found, for who has other words than the options of the commands
    """

    channel: str
    kind: str
    interval: tuple[float, float]
    sentence: str
    misread: Misread | None = None


_GAP = 5.0  # periods without a sample
_MANY_GAPS = 5  # more are told in one sentence
_JITTER = 0.25  # of the period: the spread (10 % to 90 %) of the intervals
_STUCK_S = 1.0  # s, and
_STUCK_SAMPLES = 20  # samples of one value
_SATURATED = 0.05  # share of all samples at the very top or bottom
_STEPPED = 0.01  # of the samples are steps
_COARSE = 1.0 / 50.0  # quantisation step as a share of the range


def check(recording: Recording) -> list[Issue]:
    """All findings of all channels, in the order of the channels and then of time.

    A gap or an unsteady rhythm that several channels share is told once, with the first of them; a resistance is not
    missed where no current flowed.
    """
    issues: list[Issue] = []
    for channel in recording.channels.values():
        found = check_samples(channel.name, channel.time, channel.value)
        if channel.name == 'resistance':
            found = _without_pauses(channel.time, channel.value, found, recording)
        issues += sorted(found, key=lambda issue: issue.interval)
    for name, kind, sentence in instrument_faults(recording):
        time = recording[name].time
        issues.append(Issue(name, kind, (float(time[0]), float(time[-1])), sentence))
    return _shared(issues)


def _without_pauses(time: Array, value: Array, found: list[Issue], recording: Recording) -> list[Issue]:
    """The findings of a resistance with all the gaps in which no current flowed as one."""
    drive = drive_of(recording)
    if drive is None or not any(issue.kind == 'gap' for issue in found):
        return found
    step = np.diff(time)
    least = 0.05 * float(np.max(np.abs(drive.value)))
    middle = 0.5 * (time[1:] + time[:-1])
    pauses = (step > _GAP * float(np.median(step))) & (np.abs(hold(drive, middle)) <= least)
    pauses &= ~_missing_in_all(middle, step, recording)
    if not pauses.any():
        return found
    # Judged as if the pauses had not been: the instants before and after belong together.
    shift = np.append(0.0, np.cumsum(np.where(pauses, step - np.median(step), 0.0)))
    kept = [issue for issue in found if issue.kind != 'gap']
    for issue in check_samples('resistance', time - shift, value):
        if issue.kind == 'gap':
            start = float(np.interp(issue.interval[0], time - shift, time))
            length = issue.interval[1] - issue.interval[0]
            flowed = float(hold(drive, np.array([start + 0.5 * length]))[0])
            though = ', though current flowed' if abs(flowed) > least else ''
            told = f'resistance: no sample for {length:.3g} s from {start:.3f} s{though}'
            kept.append(Issue('resistance', 'gap', (start, start + length), told))
    first, last = np.flatnonzero(pauses)[[0, -1]]
    told = f'resistance: read under current only; nothing in {np.count_nonzero(pauses)} pause(s)'
    return [*kept, Issue('resistance', 'pause', (float(time[first]), float(time[last + 1])), told)]


def _missing_in_all(middle: Array, step: Array, recording: Recording) -> NDArray[np.bool_]:
    """Which intervals of a resistance are, for most of them, a gap of every other output: the logger paused there."""
    outputs = [c for name, c in recording.channels.items() if CHANNELS[name].role == 'output' and name != 'resistance']
    others = [channel.time for channel in outputs if len(channel) > 1]
    missing = np.full(middle.size, bool(others))
    for time in others:
        after = np.clip(np.searchsorted(time, middle), 1, time.size - 1)
        silence = np.diff(time)[after - 1]
        missing &= (silence > _GAP * float(np.median(np.diff(time)))) & (silence > 0.5 * step)
    return missing


def _shared(issues: list[Issue]) -> list[Issue]:
    """One finding where several channels have the same gap, to a fifth of it, or the same rhythm."""
    told: list[Issue] = []
    for issue in issues:
        for k, other in enumerate(told):
            if issue.kind == other.kind and issue.channel != other.channel and _is_same(issue, other):
                names, _, rest = other.sentence.partition(': ')
                told[k] = other._replace(sentence=f'{names}, {issue.channel}: {rest}')
                break
        else:
            told.append(issue)
    return told


def _is_same(one: Issue, other: Issue) -> bool:
    """Whether two channels' findings of one kind are one finding."""
    if one.kind == 'jitter':
        return one.sentence.partition(': ')[2] == other.sentence.partition(': ')[2]
    lasts = one.interval[1] - one.interval[0]
    apart = max(abs(a - b) for a, b in zip(one.interval, other.interval, strict=True))
    return one.kind == 'gap' and apart < 0.2 * lasts


def check_samples(name: str, time: Array, value: Array) -> list[Issue]:
    """All findings of one channel; `time` (s) and `value` (SI) float64[n], in the order recorded, of any quality."""
    if len(time) < 2:
        if len(time) == 1 and CHANNELS[name].role != 'output':
            return []  # an input that was said once holds
        at = float(time[0]) if len(time) else 0.0
        return [Issue(name, 'short', (at, at), f'{name} has {len(time)} sample(s)')]
    issues = [*_order(name, time), *_finiteness(name, time, value)]
    sound = np.isfinite(value) & np.isfinite(time)
    time, value = time[sound], value[sound]
    order = np.argsort(time, kind='stable')
    time, value = time[order], value[order]
    if len(time) < 2:
        return issues
    issues += _rhythm(name, time)
    if CHANNELS[name].role == 'output':  # an input may well rest, and sit at its limit
        rests = name == 'force' and np.count_nonzero(np.diff(value)) < _STEPPED * len(value)  # weights, put on and off
        looked_at = () if rests else (_stuck, _saturation, _quantisation)
        issues += [issue for look in looked_at for issue in look(name, time, value)]
    issues += _unit(name, time, value)
    return issues


def _order(name: str, time: Array) -> Iterator[Issue]:
    step = np.diff(time)
    back = np.flatnonzero(step < 0)
    if len(back):
        k = int(back[0])
        yield Issue(
            name,
            'backwards',
            (float(time[k + 1]), float(time[k])),
            f'{name}: time runs backwards {len(back)} time(s), first by {-step[k]:.3g} s at {time[k]:.3f} s',
        )
    same = np.flatnonzero(step == 0)
    if len(same):
        yield Issue(
            name,
            'duplicate',
            (float(time[same[0]]), float(time[same[-1]])),
            f'{name}: {len(same)} sample(s) repeat the time of the one before, first at {time[same[0]]:.3f} s',
        )


def _finiteness(name: str, time: Array, value: Array) -> Iterator[Issue]:
    bad = np.flatnonzero(~np.isfinite(value))
    if len(bad):
        yield Issue(
            name,
            'not_finite',
            (float(time[bad[0]]), float(time[bad[-1]])),
            f'{name}: {len(bad)} of {len(value)} values are NaN or infinite',
        )


def _rhythm(name: str, time: Array) -> Iterator[Issue]:
    step = np.diff(time)
    step_at = time[:-1][step > 0]
    step = step[step > 0]
    if len(step) < 8 or CHANNELS[name].role == 'commanded':  # a command comes when it comes
        return
    period = float(np.median(step))
    gaps = np.flatnonzero(step > _GAP * period)
    if len(gaps) > _MANY_GAPS:
        yield Issue(
            name,
            'gap',
            (float(step_at[gaps[0]]), float(step_at[gaps[-1]] + step[gaps[-1]])),
            f'{name}: {len(gaps)} gaps, {step[gaps].sum():.3g} s in all, the longest {step[gaps].max():.3g} s'
            f' (period {period:.3g} s)',
        )
        gaps = gaps[:0]
    for k in gaps:
        start = float(step_at[k])
        yield Issue(
            name,
            'gap',
            (start, start + float(step[k])),
            f'{name}: no sample for {step[k]:.3g} s from {start:.3f} s (period {period:.3g} s)',
        )
    if CHANNELS[name].role != 'output':  # an input is known between its samples, whenever they are
        return
    low, high = np.percentile(step, [10, 90])
    if high - low > _JITTER * period:
        yield Issue(
            name,
            'jitter',
            (float(time[0]), float(time[-1])),
            f'{name}: intervals spread from {low:.3g} s to {high:.3g} s about a period of {period:.3g} s',
        )


def runs(same: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Stretches of equal samples as (first, last), from which neighbours are the same."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], same, [False])).astype(np.int8)))
    return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]


def _stuck(name: str, time: Array, value: Array) -> Iterator[Issue]:
    """A value that stays bit for bit the same although the channel is noisy, or was moving just before."""
    noisy = is_noisy(value)
    for first, last in runs(np.diff(value) == 0):
        long_enough = last - first >= _STUCK_SAMPLES and time[last] - time[first] >= _STUCK_S
        if long_enough and (noisy or _moving_before(value, first)) and value[first] not in (value.min(), value.max()):
            start, end = float(time[first]), float(time[last])
            yield Issue(
                name,
                'stuck',
                (start, end),
                f'{name}: the same value {_told(name, value[first])} for {end - start:.3g} s from {start:.3f} s',
            )


def _told(name: str, value: float) -> str:
    """An SI value as people read it."""
    unit = UNITS[CHANNELS[name].unit]
    return f'{unit.from_si(float(value)):.6g} {unit.name}'


def is_noisy(value: Array) -> bool:
    """Do most steps change direction? Then even a resting muscle shows ever new values."""
    step = np.diff(value)
    step = step[step != 0]
    return len(step) > 0.5 * len(value) and float(np.mean(np.sign(step[1:]) * np.sign(step[:-1]) < 0)) > 0.25


def _moving_before(value: Array, first: int) -> bool:
    """Was the channel on its way, by more than ten of its steps over ten samples, and did it then stop dead?"""
    if first < 10:
        return False
    travelled = np.abs(value[first] - value[first - 10])
    last_half = np.abs(value[first] - value[first - 5])
    return bool(travelled > 10 * quantum(value) and last_half > 0.35 * travelled)


def _saturation(name: str, time: Array, value: Array) -> Iterator[Issue]:
    """The very top or bottom, run into at speed and kept: a sensor at its limit, not a muscle at rest."""
    for extreme, side in ((float(value.max()), 'top'), (float(value.min()), 'bottom')):
        at = value == extreme
        stretches = [run for run in runs(at[1:] & at[:-1]) if run[1] - run[0] >= _STUCK_SAMPLES]
        hit = [run for run in stretches if _moving_before(value, run[0]) or (is_noisy(value) and run[0] > 0)]
        if hit and np.mean(at) >= _SATURATED:
            yield Issue(
                name,
                'saturation',
                (float(time[hit[0][0]]), float(time[hit[-1][1]])),
                f'{name}: {100 * np.mean(at):.0f} % of all values sit at its {side}, {_told(name, extreme)}: '
                'a sensor or rig at its limit, or stuck?',
            )


def quantum(value: Array) -> float:
    """The step in which a channel is quantised, 0 where all values are equal: the smallest distance of two values."""
    levels = np.unique(value)
    if len(levels) < 2:
        return 0.0
    steps = np.diff(levels)
    span = float(levels[-1] - levels[0])
    return float(steps[steps > 1e-9 * span].min(initial=span))


def _quantisation(name: str, time: Array, value: Array) -> Iterator[Issue]:
    span = float(value.max() - value.min())
    step = quantum(value)
    above_rounding = step > ROUNDED * float(np.max(np.abs(value)))  # else the last bit of a number that is constant
    if above_rounding and len(value) >= 100 and step > _COARSE * span:
        yield Issue(
            name,
            'quantisation',
            (float(time[0]), float(time[-1])),
            f'{name}: in steps of {step:.3g}, {span / step:.0f} steps over its whole range',
        )


def _unit(name: str, time: Array, value: Array) -> Iterator[Issue]:
    found = misread(name, value)
    if found is not None:
        told = ''.join(map(str, found.told()))
        yield Issue(name, 'unit', (float(time[0]), float(time[-1])), told, found)
