"""The figures of a diagnosis: what was recorded and what the models make of it, where they differ, what decides.

Each ``draw_*`` writes one PNG and says what it shows, or None where there is nothing to draw. The two models are the
recalibrated one without and with the findings; where nothing was found, the nominal and the recalibrated one. Series
are thinned to what a picture can show.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis, Series
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, SHOWN, shown
from tcp_muscle_ros.report.style import (
    AFTER,
    BEFORE,
    COOLING,
    DRIVE,
    HEATING,
    LOAD,
    OTHER,
    RECORDED,
    canvas,
    save,
    stacked,
)
from tcp_muscle_ros.report.words import chance, percent, plain

_MOST_POINTS = 3000  # a picture is some thousand pixels wide
_MOST_BARS = 12
_BINS = 16
_CYCLES_SHOWN = 8
_STEP = 0.15  # of a cycle's stroke between neighbours is a step of the load
_WARMS = 0.05  # of the largest rate of temperature is no rest
_GAP = 5.0  # intervals: after a longer pause a line is interrupted
Places = NDArray[np.intp]


# The recording is drawn broad, so that a model that meets it does not hide it.
_BROAD: dict[str, Any] = {'color': RECORDED, 'linewidth': 2.6, 'alpha': 0.8}


class Model(NamedTuple):
    """One of the models that are set against the recording: its part of a Series, its name and its line."""

    part: str
    label: str
    look: dict[str, Any]

    def of(self, series: Series) -> Array:
        """What it predicts for a channel."""
        values: Array = getattr(series, self.part)
        return values


def compared(diagnosis: Diagnosis) -> tuple[Model, Model]:
    """The two models whose difference is the outcome."""
    parts = ('before', 'recalibrated'), ('after', 'with the findings')
    if all(np.array_equal(s.before, s.after) for series in diagnosis.series for s in series):
        parts = ('nominal', 'nominal'), ('before', 'recalibrated')
    first, second = (
        Model(part, label, {'color': colour, 'linewidth': 1.1, 'alpha': 0.9})
        for (part, label), colour in zip(parts, (BEFORE, AFTER), strict=True)
    )
    return first, second


class Said(NamedTuple):
    """What is said of a figure: a caption below it, and a text for whoever cannot see it."""

    caption: str
    alternative: str


class Figure(NamedTuple):
    """One figure that was drawn: its file in ``figures/``, and what is said of it."""

    file: str
    said: Said


def draw_all(folder: str | Path, diagnosis: Diagnosis) -> list[Figure]:
    """Write every figure for which there is something to show; those that were written, in order."""
    drawn = [(file, draw(Path(folder) / file, diagnosis)) for file, draw in FIGURES.items()]
    return [Figure(file, said) for file, said in drawn if said is not None]


def draw_channels(path: Path, diagnosis: Diagnosis) -> Said | None:
    """Recorded, before and after of each channel, residuals below, for the recording that shows most."""
    if not diagnosis.series:
        return None
    k, models = telling_recording(diagnosis), compared(diagnosis)
    where = telling_channel(diagnosis)
    series = sorted(diagnosis.series[k], key=lambda s: s.channel != where)  # the one that shows most comes first
    start, end = _window(diagnosis, k)
    figure, drive, rows = stacked(len(series))
    if k < len(diagnosis.drive):
        kind, time, value = diagnosis.drive[k]
        drive.step(time, value, where='post', color=DRIVE, linewidth=1.2)
        drive.set_ylabel(CHANNEL_AXIS[kind])
    drive.set_title(_name(diagnosis, k), fontsize=10)
    for (axis, below), s in zip(rows, series, strict=True):
        axis.plot(*_line(s, shown(s.channel, s.recorded), start, end), label='recorded', **_BROAD)
        for model in models:
            axis.plot(*_line(s, shown(s.channel, model.of(s)), start, end), label=model.label, **model.look)
        axis.set_ylabel(CHANNEL_AXIS[s.channel])
        unit, factor = SHOWN[s.channel]
        band = 2.0 * factor * diagnosis.noise.get(s.channel, float('nan'))
        if np.isfinite(band):
            below.axhspan(-band, band, color=RECORDED, alpha=0.12, linewidth=0)
        for model in models:
            left = factor * (s.recorded - model.of(s))
            below.plot(*_line(s, left, start, end), **model.look)
        below.set_ylabel(f'residual ({unit})', fontsize=8)
    marked = [(a, b) for a, b in shaded(diagnosis, k) if series[0].channel == where and a < end and b > start]
    for a, b in marked:
        for axis in rows[0]:
            axis.axvspan(max(a, start), min(b, end), color=BEFORE, alpha=0.08, linewidth=0)
    rows[0][0].legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), fontsize=8, ncols=3, frameon=False)
    drive.set_xlim(start, end)
    rows[-1][1].set_xlabel('time (s)')
    save(figure, path)
    one, two = (model.label for model in models)
    what = f'Recorded (black), {one} (orange), {two} (blue). Below each channel: recorded minus model'
    what += ', twice the noise in grey.' if diagnosis.noise else '.'
    what += f' Shaded: where the {where} is missed most.' if marked else ''
    channels = ', '.join(s.channel for s in series)
    return Said(what, f'{_name(diagnosis, k)}, {start:.0f} s to {end:.0f} s: {channels}, recorded and from two models')


def shaded(diagnosis: Diagnosis, k: int) -> list[tuple[float, float]]:
    """From when to when (s) recording k is among what is missed most."""
    found = diagnosis.location.intervals if diagnosis.location else ()
    return sorted((a, b) for owner, a, b in found if owner == k)


def draw_driver(path: Path, diagnosis: Diagnosis) -> Said | None:
    """The residual against what it goes with, warming and cooling apart, before and after."""
    if not diagnosis.series:
        return None
    channel = telling_channel(diagnosis)
    variable = _variable(diagnosis)
    mine = [s for series in diagnosis.series for s in series if s.channel == channel]
    if not mine:
        return None
    x = np.concatenate([_driver(s, variable, series) for s, series in _owners(diagnosis, channel)])
    warms = np.concatenate([s.rate > 0.0 for s in mine])
    unit, factor = SHOWN[channel]
    figure, axes = canvas(1, 2, height=3.6, sharey=True)
    for axis, model in zip(axes, compared(diagnosis), strict=True):
        left = factor * np.concatenate([s.recorded - model.of(s) for s in mine])
        band = 2.0 * factor * diagnosis.noise.get(channel, float('nan'))
        if np.isfinite(band):
            axis.axhspan(-band, band, color=RECORDED, alpha=0.12, linewidth=0, label='noise')
        for phase, colour, name in ((warms, HEATING, 'warming'), (~warms, COOLING, 'cooling')):
            if not phase.any():
                continue
            few = thin(int(phase.sum()))
            axis.plot(x[phase][few], left[phase][few], '.', color=colour, markersize=2, alpha=0.35)
            axis.plot(*_means(x[phase], left[phase]), color=colour, linewidth=2.0, label=name)
        axis.set_title(model.label, fontsize=10)
        axis.set_xlabel(_DRIVERS[variable])
        axis.xaxis.set_major_locator(MaxNLocator(nbins=7, prune='both'))
    axes[0].set_ylabel(f'{channel}, recorded - model ({unit})')
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, path)
    goes = _DRIVERS[variable].split(' (')[0]
    what = f'Recorded minus model against {goes}, all recordings, warming and cooling apart; lines are means.'
    one, two = (model.label for model in compared(diagnosis))
    return Said(what, f'Two scatter plots of what each model leaves of the {channel} against {goes}: {one}, and {two}')


def draw_loop(path: Path, diagnosis: Diagnosis) -> Said | None:
    """What is left of stroke (or force) over temperature in the last cycle of a recording: a loop shows a memory."""
    if not diagnosis.series:
        return None
    series = {s.channel: s for s in diagnosis.series[telling_recording(diagnosis)]}
    moved = series.get('displacement') or series.get('force')
    if moved is None:
        return None
    last = _last_cycle(moved)
    few = last[thin(last.size)]
    unit, factor = SHOWN[moved.channel]
    figure, axes = canvas(1, 2, height=3.6, sharey=True)
    for axis, model in zip(axes, compared(diagnosis), strict=True):
        left = factor * (moved.recorded - model.of(moved))[few]
        warm = shown('temperature', moved.temperature[few])
        band = 2.0 * factor * diagnosis.noise.get(moved.channel, float('nan'))
        if np.isfinite(band):
            axis.axhspan(-band, band, color=RECORDED, alpha=0.12, linewidth=0)
        axis.plot(warm, left, color=OTHER, linewidth=0.6, alpha=0.6)
        for phase, colour, name in ((moved.rate > 0.0, HEATING, 'warming'), (moved.rate <= 0.0, COOLING, 'cooling')):
            axis.plot(warm[phase[few]], left[phase[few]], '.', color=colour, markersize=3, label=name)
        axis.set_title(model.label, fontsize=10)
        axis.set_xlabel('fibre temperature (degC)')
    axes[0].set_ylabel(f'{moved.channel}, recorded - model ({unit})')
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, path)
    span = f'{moved.time[last[0]]:.0f} s to {moved.time[last[-1]]:.0f} s'
    where = f'the last cycle of {_name(diagnosis, telling_recording(diagnosis))}'
    return Said(
        f'Recorded minus model over one cycle ({span}): a loop means memory or a lag, a single curve a wrong law.',
        f'What each of two models leaves of the {moved.channel} against fibre temperature, over {where}',
    )


def draw_ranking(path: Path, diagnosis: Diagnosis) -> Said | None:
    """The candidates by what each explains alone; which were refitted, which were found, which explain as much."""
    ranking = sorted(diagnosis.ranking, key=lambda r: r.gain, reverse=True)[:_MOST_BARS]
    if not ranking or ranking[0].gain <= 0.0:
        return None
    found = {finding.effect: finding for finding in diagnosis.findings}
    rivals = {other for finding in diagnosis.findings for other in finding.indistinguishable_from}
    figure, (axis,) = canvas(1, width=8.0, height=0.9 + 0.3 * len(ranking))
    for place, r in enumerate(ranking):
        rival = r.effect in rivals and r.effect not in found
        share = max(r.gain, 0.0) / ranking[0].gain
        axis.barh(
            place,
            100.0 * share,
            height=0.7,
            color=AFTER if rival or r.effect in found else OTHER,
            alpha=1.0 if r.refitted else 0.4,
            hatch='///' if rival else None,
            edgecolor='white',
            linewidth=0.0,
        )
        remark = 'explains it as well' if rival else '' if r.refitted else 'estimated'
        if r.effect in found:
            remark = 'found' if not found[r.effect].indistinguishable_from else 'found, not alone'
        axis.annotate(
            f'{percent(share)}   {remark}'.rstrip(),
            (100.0 * share, place),
            xytext=(5, 0),
            textcoords='offset points',
            va='center',
            fontsize=8,
        )
    axis.set_yticks(range(len(ranking)), [f'{plain(r.effect)} ({r.stage})' for r in ranking], fontsize=8)
    axis.set_ylim(len(ranking) - 0.4, -0.6)
    axis.set_xlim(0.0, 150.0)
    axis.set_xticks([0, 25, 50, 75, 100])
    axis.set_xlabel('tried alone: per cent of what the best explains')
    axis.grid(visible=False, axis='y')
    save(figure, path)
    pale = ' Pale bars are estimates.' if not all(r.refitted for r in ranking) else ''
    hatched = ' Hatched: explains as much as what was found.' if rivals & {r.effect for r in ranking} else ''
    bars = ', '.join(f'{plain(r.effect)} {percent(max(r.gain, 0.0) / ranking[0].gain)}' for r in ranking)
    return Said(f'What each effect explains when it is tried alone.{pale}{hatched}', f'Bars: {bars}')


def draw_experiment(path: Path, diagnosis: Diagnosis) -> Said | None:
    """The current and load of the experiment that would decide between two effects."""
    proposal = diagnosis.next_experiment
    if proposal is None:
        return None
    edges = np.concatenate([[0.0], np.cumsum([step.duration for step in proposal.steps])])
    figure, (current, load) = canvas(2, height=1.9, sharex=True)
    for axis, name, colour in ((current, 'current', DRIVE), (load, 'load', LOAD)):
        levels = [getattr(step, name) for step in proposal.steps]
        axis.step(edges, [*levels, levels[-1]], where='post', color=colour, linewidth=1.6)
        axis.set_ylim(0.0, 1.15 * max(*levels, 1e-9))
    current.set_ylabel('current (A)')
    load.set_ylabel('load (N)')
    load.set_xlabel(f'time (s); all of it {proposal.repeat} times' if proposal.repeat > 1 else 'time (s)')
    load.set_xlim(0.0, float(edges[-1]))
    first, second = (plain(name) for name in proposal.separates)
    current.set_title(f'{first} or {second}? It decides with probability {chance(proposal.power)}', fontsize=10)
    save(figure, path)
    length = proposal.repeat * float(edges[-1])
    levels = sorted({step.current for step in proposal.steps})
    loads = ', '.join(f'{load:.2g}' for load in sorted({step.load for step in proposal.steps}))
    return Said(
        'The experiment that would decide: current and load over time.',
        f'{plain(proposal.name)}, {length:.0f} s: currents from {levels[0]:.3g} to {levels[-1]:.3g} A, loads {loads} N',
    )


def draw_sticking(path: Path, diagnosis: Diagnosis) -> Said | None:
    """One simulated run that sticks and slips beside the recorded one: the same kind of motion at other instants."""
    run = diagnosis.imitated
    if run is None:
        return None
    figure, axes = canvas(1, 2, height=3.2, sharey=True)
    for axis, value, label, colour in zip(
        axes, (run.recorded, run.simulated), ('recorded', 'simulated with stick_slip'), (RECORDED, AFTER), strict=True
    ):
        axis.step(run.time, shown(run.channel, value), where='post', color=colour, linewidth=1.1)
        axis.set_title(label, fontsize=10)
        axis.set_xlabel('time (s)')
    axes[0].set_ylabel(CHANNEL_AXIS[run.channel])
    save(figure, path)
    return Said(
        'One recorded run and one simulated: the same kind of motion; the instants of the jumps are chance.',
        f'The {run.channel} of {run.name}, recorded, and simulated with stick-slip: both rest and jump',
    )


FIGURES: dict[str, Callable[[Path, Diagnosis], Said | None]] = {
    'channels.png': draw_channels,
    'driver.png': draw_driver,
    'loop.png': draw_loop,
    'ranking.png': draw_ranking,
    'experiment.png': draw_experiment,
    'sticking.png': draw_sticking,
}


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
    """The recording in which that channel is furthest from the first model."""
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


def _name(diagnosis: Diagnosis, k: int) -> str:
    named = Path(diagnosis.recordings[k].path).name if k < len(diagnosis.recordings) else ''
    return f'{named} (recording {k + 1} of {len(diagnosis.series)})' if len(diagnosis.series) > 1 else named


def _switches(s: Series) -> Array:
    """Instants at which the drive comes on, or the muscle begins to warm where the drive is never off."""
    on = s.heating > 0.5
    if on.all():
        on = s.rate > _WARMS * np.max(np.abs(s.rate))
    return np.asarray(s.time[1:][on[1:] & ~on[:-1]])


def _window(diagnosis: Diagnosis, k: int) -> tuple[float, float]:
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


def _line(s: Series, value: Array, start: float, end: float) -> tuple[Array, Array]:
    """Time and value between two instants, thinned, interrupted where nothing was recorded."""
    at = np.flatnonzero((s.time >= start) & (s.time <= end))
    if at.size < 2:
        return s.time[at], value[at]
    gap = np.diff(s.time[at]) > _GAP * float(np.median(np.diff(s.time[at])))
    few = np.union1d(thin(at.size), np.flatnonzero(gap))
    after = np.searchsorted(few, np.flatnonzero(gap), side='right')
    time, drawn = s.time[at][few], value[at][few]
    return np.insert(time, after, time[np.maximum(after - 1, 0)]), np.insert(drawn, after, np.nan)


_DRIVERS = {
    'temperature': 'fibre temperature (degC)',
    'rate': 'rate of temperature (K/s)',
    'since_switch': 'time since the drive was switched (s)',
    'elapsed': 'elapsed time (s)',
    'displacement': 'displacement (mm)',
}


def _variable(diagnosis: Diagnosis) -> str:
    """The driver that carries most, among those that can be drawn."""
    told = []
    if diagnosis.location is not None:
        ordered = sorted(diagnosis.location.drivers, key=lambda d: d.share if np.isfinite(d.share) else 0.0)
        told = [driver.variable for driver in reversed(ordered)]
    if diagnosis.unexplained is not None:
        # What has no name is shown by what it goes with.
        told.insert(0 if not diagnosis.findings else len(told), diagnosis.unexplained.driver)
    words = {'time since': 'since_switch', **{name: name for name in _DRIVERS}}
    for variable in told:
        for word, name in words.items():
            if variable.startswith(word):
                return name
    return 'temperature'


def _owners(diagnosis: Diagnosis, channel: str) -> list[tuple[Series, tuple[Series, ...]]]:
    return [(s, series) for series in diagnosis.series for s in series if s.channel == channel]


def _driver(s: Series, variable: str, series: tuple[Series, ...]) -> Array:
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


def _means(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of y over x in bins of about equal width, bins of few points left out."""
    edges = np.linspace(float(x.min()), float(x.max()) + 1e-12, _BINS + 1)
    place = np.clip(np.digitize(x, edges) - 1, 0, _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    kept = count >= 3
    sums = [np.bincount(place, values, minlength=_BINS)[kept] / count[kept] for values in (x, y)]
    return sums[0], sums[1]


def _last_cycle(s: Series) -> Places:
    """Places of the samples of the last whole cycle, one without a step of the load if there is one; of all else."""
    starts = _switches(s)
    cycles = [np.flatnonzero((s.time >= a) & (s.time < b)) for a, b in pairwise([*starts, s.time[-1] + 1e-9])]
    cycles = [cycle for cycle in cycles if cycle.size > 10 and cycle.size > 0.5 * max(c.size for c in cycles)]
    if not cycles:
        return np.arange(s.time.size)
    smooth = [c for c in cycles if np.abs(np.diff(s.recorded[c])).max() < _STEP * np.ptp(s.recorded[c])]
    return (smooth or cycles)[-1]
