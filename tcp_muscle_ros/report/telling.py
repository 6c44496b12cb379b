"""What of a diagnosis a picture shows: the recording and the channel that tell most, a stretch and a cycle of them, and
what the residual goes with. Series are thinned to what a picture can show.
"""

from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Series
from tcp_muscle_ros.diagnosis.search.location import share_of_range
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.as_read import shown
from tcp_muscle_ros.report.style import AFTER, BEFORE

_MOST_POINTS = 3000  # a picture is some thousand pixels wide
_BINS = 16
_CYCLES_SHOWN = 8
_STEP = 0.15  # of a cycle's stroke between neighbours is a step of the load
_WARMS = 0.05  # of the largest rate of temperature is no rest
_GAP = 5.0  # intervals: after a longer pause a line is interrupted
_MISSED = ('unexplained', 'not_repeatable', 'sensor_or_setup')  # verdicts on what the recalibrated model misses
Places = NDArray[np.intp]


class Model(NamedTuple):
    """One of the models that are set against the recording: its part of a Series, its name and its line."""

    part: str
    label: str
    look: dict[str, Any]

    def of(self, series: Series) -> Array:
        """What it predicts for a channel."""
        values: Array = getattr(series, self.part)
        return values


def compared(diagnosis: Diagnosis) -> tuple[Model, ...]:
    """The two models whose difference is the outcome; one alone where what it misses is the outcome: beside another,
    which misses more, that could not be seen."""
    parts = [('before', 'recalibrated'), ('after', 'with the findings')]
    same = all(np.array_equal(s.before, s.after) for series in diagnosis.series for s in series)
    if not diagnosis.findings or same:
        parts = parts[:1] if diagnosis.verdict in _MISSED else [('nominal', 'nominal'), *parts[:1]]
    return tuple(
        Model(part, label, {'color': colour, 'linewidth': 1.1, 'alpha': 0.9})
        for (part, label), colour in zip(parts, (BEFORE, AFTER), strict=False)
    )


def shaded(diagnosis: Diagnosis, k: int) -> list[tuple[float, float]]:
    """From when to when (s) recording k is among what is missed most."""
    found = diagnosis.location.intervals if diagnosis.location else ()
    return sorted((a, b) for owner, a, b in found if owner == k)


def telling_channel(diagnosis: Diagnosis) -> str:
    """The channel that shows most: where the misfit was located, else where it is largest against the noise."""
    recorded = {s.channel for series in diagnosis.series for s in series}
    if diagnosis.location is not None and diagnosis.location.channel in recorded:
        return diagnosis.location.channel

    model = compared(diagnosis)[0]

    def size(channel: str) -> float:
        mine = [s for series in diagnosis.series for s in series if s.channel == channel]
        return max(_misfit(diagnosis, s, model) for s in mine)

    return max(sorted(recorded), key=size)


def telling_recording(diagnosis: Diagnosis) -> int:
    """The recording in which the channel that tells most is furthest from the first model."""
    channel, model = telling_channel(diagnosis), compared(diagnosis)[0]
    sizes = [
        max((_misfit(diagnosis, s, model) for s in series if s.channel == channel), default=-1.0)
        for series in diagnosis.series
    ]
    return int(np.argmax(sizes))


def thin(size: int, most: int = _MOST_POINTS) -> Places:
    """Places of at most ``most`` of ``size`` points, evenly, both ends kept."""
    return np.unique(np.linspace(0, size - 1, min(size, most)).astype(np.intp))


def _misfit(diagnosis: Diagnosis, s: Series, model: Model) -> float:
    noise = diagnosis.noise.get(s.channel, float('nan'))
    scale = noise if np.isfinite(noise) and noise > 0.0 else max(float(np.ptp(s.recorded)), 1e-12)
    return float(np.sqrt(np.mean((s.recorded - model.of(s)) ** 2))) / scale


def recording_name(diagnosis: Diagnosis, k: int) -> str:
    """The name of recording k, with its number where there are several."""
    named = Path(diagnosis.recordings[k].path).name if k < len(diagnosis.recordings) else ''
    return f'{named} (recording {k + 1} of {len(diagnosis.series)})' if len(diagnosis.series) > 1 else named


def _switches(s: Series) -> Array:
    """Instants at which the drive comes on, or the muscle begins to warm where the drive is never off."""
    on = s.heating > 0.5
    if on.all():
        on = s.rate > _WARMS * np.max(np.abs(s.rate))
    return np.asarray(s.time[1:][on[1:] & ~on[:-1]])


def window(diagnosis: Diagnosis, k: int) -> tuple[float, float]:
    """All of a recording, or the cycles around its largest misfit where there are too many to see."""
    s = max(diagnosis.series[k], key=lambda s: s.time.size)
    start, end = float(s.time[0]), float(s.time[-1])
    starts = _switches(s)
    if starts.size <= _CYCLES_SHOWN:
        return start, end
    told = [a for owner, a, _ in diagnosis.location.intervals if owner == k] if diagnosis.location else []
    first = int(np.clip(np.searchsorted(starts, told[0]) - 1 if told else 0, 0, starts.size - _CYCLES_SHOWN))
    last = first + _CYCLES_SHOWN
    return float(starts[first]), float(starts[last]) if last < starts.size else end


def line(s: Series, value: Array, start: float, end: float) -> tuple[Array, Array]:
    """Time and value between two instants, thinned, interrupted where nothing was recorded."""
    at = np.flatnonzero((s.time >= start) & (s.time <= end))
    if at.size < 2:
        return s.time[at], value[at]
    gap = np.diff(s.time[at]) > _GAP * float(np.median(np.diff(s.time[at])))
    few = np.union1d(thin(at.size), np.flatnonzero(gap))
    after = np.searchsorted(few, np.flatnonzero(gap), side='right')
    time, drawn = s.time[at][few], value[at][few]
    return np.insert(time, after, time[np.maximum(after - 1, 0)]), np.insert(drawn, after, np.nan)


DRIVERS = {
    'temperature': 'fibre temperature (degC)',
    'rate': 'rate of temperature (K/s)',
    'since_switch': 'time since the drive was switched (s)',
    'elapsed': 'elapsed time (s)',
    'displacement': 'displacement (mm)',
}


def telling_driver(diagnosis: Diagnosis) -> str:
    """The driver that carries most, among those that can be drawn."""
    told = []
    if diagnosis.location is not None:
        ordered = sorted(diagnosis.location.drivers, key=lambda d: d.share if np.isfinite(d.share) else 0.0)
        told = [driver.variable for driver in reversed(ordered)]
    if diagnosis.unexplained is not None:
        # What has no name is shown by what it goes with.
        told.insert(0 if not diagnosis.findings else len(told), diagnosis.unexplained.driver)
    words = {'time since': 'since_switch', share_of_range('displacement'): 'displacement'}
    words |= {name: name for name in DRIVERS}
    for variable in told:
        for word, name in words.items():
            if variable.startswith(word):
                return name
    return 'temperature'


def series_of(diagnosis: Diagnosis, channel: str) -> list[tuple[Series, tuple[Series, ...]]]:
    """Each recording's series of a channel, with all of that recording."""
    return [(s, series) for series in diagnosis.series for s in series if s.channel == channel]


def driver_of(s: Series, variable: str, series: tuple[Series, ...]) -> Array:
    """The driver at the instants of a series, as people read it."""
    if variable == 'rate':
        return s.rate
    if variable == 'elapsed':
        return np.asarray(s.time - s.time[0])
    if variable == 'since_switch':
        changed = np.concatenate([[True], np.diff(s.heating > 0.5)])
        return np.asarray(s.time - s.time[changed][np.cumsum(changed) - 1])
    moved = next((other for other in series if other.channel == 'displacement'), None)
    if variable == 'displacement' and moved is not None:
        return shown('displacement', np.interp(s.time, moved.time, moved.recorded))
    return shown('temperature', s.temperature)


def means(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of y over x in bins of about equal width, bins of few points left out."""
    edges = np.linspace(float(x.min()), float(x.max()) + 1e-12, _BINS + 1)
    place = np.clip(np.digitize(x, edges) - 1, 0, _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    kept = count >= 3
    sums = [np.bincount(place, values, minlength=_BINS)[kept] / count[kept] for values in (x, y)]
    return sums[0], sums[1]


def last_cycle(s: Series) -> Places:
    """Places of the samples of the last whole cycle, one without a step of the load if there is one; of all else."""
    starts = _switches(s)
    cycles = [np.flatnonzero((s.time >= a) & (s.time < b)) for a, b in pairwise([*starts, s.time[-1] + 1e-9])]
    cycles = [cycle for cycle in cycles if cycle.size > 10 and cycle.size > 0.5 * max(c.size for c in cycles)]
    if not cycles:
        return np.arange(s.time.size)
    smooth = [c for c in cycles if np.abs(np.diff(s.recorded[c])).max() < _STEP * np.ptp(s.recorded[c])]
    return (smooth or cycles)[-1]
