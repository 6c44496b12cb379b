"""A recording whose clock leapt: by days, the part with most of its samples; back, where.

A board without a battery wakes in 1970 and is set by NTP minutes later; a single damaged stamp lies anywhere. Whoever
lays a grid over such a recording asks for more memory than there is.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from tcp_muscle_ros.recording.cdr import Index
from tcp_muscle_ros.recording.recording import UNDATED_NS, Array, Recording

DAY_NS = 86_400 * 1_000_000_000
_APART_NS = 7 * DAY_NS  # a bag that was left open over some days is one recording still
_SEVERAL = 5  # messages before and after, of which the one in the middle counts: a few may overtake others
_BACK_NS, _BACK_PERIODS = 200_000_000, 5.0  # a clock that is set back by less is disciplined, not set


def dated(recording: Recording) -> bool:
    """Whether the start of a recording is a date, and not the beginning of a clock that nobody set."""
    return recording.start_ns >= UNDATED_NS + DAY_NS


def as_made(recordings: Sequence[Recording]) -> list[Recording]:
    """Recordings in the order in which they were made, where all are dated; else as they are given."""
    return sorted(recordings, key=lambda one: one.start_ns) if all(map(dated, recordings)) else list(recordings)


class Part(NamedTuple):
    """From its first sample's time to its last one's, ns, and what to tell of the rest."""

    first: int
    last: int
    note: str


def main_part(times: Sequence[Index]) -> Part | None:
    """The part of most samples, between leaps of more than a week in the times of all channels; None without a leap.

    ``times`` holds each channel's, ns, in any order.
    """
    span = max(int(time.max()) for time in times) - min(int(time.min()) for time in times)
    if span <= _APART_NS:
        return None
    together = np.sort(np.concatenate(times))
    gap = np.diff(together.astype(np.float64))  # of int64 it may overflow
    leaps = np.flatnonzero(gap > _APART_NS)
    if not leaps.size:
        return None
    starts, ends = np.append(0, leaps + 1), np.append(leaps, together.size - 1)
    most = int(np.argmax(ends - starts))
    first, last = int(together[starts[most]]), int(together[ends[most]])
    elsewhere = together.size - 1 - int(ends[most] - starts[most])
    note = (
        f'the clock jumps by up to {float(gap.max()) / DAY_NS:.4g} days (it was set, or a stamp is wrong?): '
        f'{elsewhere} of {together.size} samples lie beyond a jump and were left out'
    )
    return Part(first, last, note)


def within(part: Part, time: Index, value: Array, *, holds: bool) -> tuple[Index, Array]:
    """A channel's samples in the part; one that `holds` until the next begins with what was said last before."""
    kept = (time >= part.first) & (time <= part.last)
    before = np.flatnonzero(time < part.first) if holds else np.empty(0, np.int64)
    if before.size and not np.any(time[kept] == part.first):
        latest = before[int(np.argmax(time[before]))]
        return np.append(part.first, time[kept]), np.append(value[latest], value[kept])
    return time[kept], value[kept]


def set_back(time: Index) -> str | None:
    """How a topic's time (ns, in the order in which it was logged) runs backwards for good, in words; else None.

    Messages that overtake others, a single wrong stamp and leaps of more than a week (see ``main_part``) do not count.
    """
    if time.size < 2 * _SEVERAL or np.all(time[1:] >= time[:-1]):
        return None
    middle = median_filter(time, size=_SEVERAL, mode='nearest')
    # From the middle of those before a place to the middle of those after it.
    step = (middle[_SEVERAL:] - middle[:-_SEVERAL]).astype(np.float64)
    period = float(np.median(np.abs(np.diff(time).astype(np.float64))))
    back = np.flatnonzero((step < -max(_BACK_NS, _BACK_PERIODS * period)) & (step > -_APART_NS))
    if not back.size:
        return None
    places = np.split(back, np.flatnonzero(np.diff(back) > _SEVERAL) + 1)
    first = places[0][int(np.argmin(step[places[0]]))]
    k = first + int(np.argmin(np.diff(time[first : first + _SEVERAL + 1])))
    at, by = (time[k] - time[0]) * 1e-9, (time[k] - time[k + 1]) * 1e-9
    more = f', {len(places)} times in all' if len(places) > 1 else ''
    return (
        f'time runs backwards by {by:.3g} s at {at:.1f} s of the recording{more}: the clock was set '
        'back, or two recordings are in one bag; cut it there'
    )
