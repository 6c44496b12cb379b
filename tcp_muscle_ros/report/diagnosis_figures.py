"""The figures of a diagnosis: what was recorded and what the models make of it, where they differ, what decides.

Each ``draw_*`` writes one PNG and says what it shows, or None where there is nothing to draw. The two models are the
recalibrated one without and with the findings; where nothing was found, the nominal and the recalibrated one, or this
alone where something is missed. Series are thinned to what a picture can show.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.recording.recording import CHANNELS
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
    literal,
    save,
    stacked,
)
from tcp_muscle_ros.report.telling import (
    DRIVERS,
    Model,
    compared,
    driver_of,
    last_cycle,
    line,
    means,
    recording_name,
    series_of,
    shaded,
    telling_channel,
    telling_driver,
    telling_recording,
    thin,
    window,
)
from tcp_muscle_ros.report.words import chance, percent, plain

_MOST_BARS = 12
_WIDTH = 4.5  # inches, of a panel of one of the models
# The recording is drawn broad, so that a model that meets it does not hide it.
_BROAD: dict[str, Any] = {'color': RECORDED, 'linewidth': 2.6, 'alpha': 0.8}


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
    start, end = window(diagnosis, k)
    figure, drive, rows = stacked(len(series))
    if k < len(diagnosis.drive):
        kind, time, value = diagnosis.drive[k]
        drive.step(time, value, where='post', color=DRIVE, linewidth=1.2)
        drive.set_ylabel(CHANNEL_AXIS[kind])
    drive.set_title(literal(recording_name(diagnosis, k)), fontsize=10)
    for (axis, below), s in zip(rows, series, strict=True):
        axis.plot(*line(s, shown(s.channel, s.recorded), start, end), label='recorded', **_BROAD)
        for model in models:
            axis.plot(*line(s, shown(s.channel, model.of(s)), start, end), label=model.label, **model.look)
        axis.set_ylabel(CHANNEL_AXIS[s.channel])
        unit, factor = SHOWN[s.channel]
        _shade_noise(below, diagnosis, s.channel)
        for model in models:
            left = factor * (s.recorded - model.of(s))
            below.plot(*line(s, left, start, end), **model.look)
        below.set_ylabel(f'residual ({unit})', fontsize=8)
    marked = [(a, b) for a, b in shaded(diagnosis, k) if series[0].channel == where and a < end and b > start]
    for a, b in marked:
        for axis in rows[0]:
            axis.axvspan(max(a, start), min(b, end), color=BEFORE, alpha=0.08, linewidth=0)
    rows[0][0].legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), fontsize=8, ncols=3, frameon=False)
    drive.set_xlim(start, end)
    rows[-1][1].set_xlabel('time (s)')
    save(figure, path)
    drawn = ', '.join(f'{model.label} ({colour})' for model, colour in zip(models, ('orange', 'blue'), strict=False))
    what = f'Recorded (black), {drawn}. Below each channel: recorded minus model'
    what += ', twice the noise in grey.' if diagnosis.noise else '.'
    what += f' Shaded: where the {where} is missed most.' if marked else ''
    channels = ', '.join(s.channel for s in series)
    return Said(
        what,
        f'{recording_name(diagnosis, k)}, {start:.0f} s to {end:.0f} s: {channels}, recorded and {_names(models)}',
    )


def draw_driver(path: Path, diagnosis: Diagnosis) -> Said | None:
    """The residual against what it goes with, warming and cooling apart, before and after."""
    if not diagnosis.series:
        return None
    channel = telling_channel(diagnosis)
    variable = telling_driver(diagnosis)
    mine = [s for series in diagnosis.series for s in series if s.channel == channel]
    if not mine:
        return None
    x = np.concatenate([driver_of(s, variable, series) for s, series in series_of(diagnosis, channel)])
    warms = np.concatenate([s.rate > 0.0 for s in mine])
    unit, factor = SHOWN[channel]
    models = compared(diagnosis)
    figure, axes = canvas(1, len(models), width=_WIDTH * len(models), height=3.6, sharey=True)
    for axis, model in zip(axes, models, strict=True):
        left = factor * np.concatenate([s.recorded - model.of(s) for s in mine])
        _shade_noise(axis, diagnosis, channel, label='noise')
        for phase, colour, name in ((warms, HEATING, 'warming'), (~warms, COOLING, 'cooling')):
            if not phase.any():
                continue
            few = thin(int(phase.sum()))
            axis.plot(x[phase][few], left[phase][few], '.', color=colour, markersize=2, alpha=0.35)
            axis.plot(*means(x[phase], left[phase]), color=colour, linewidth=2.0, label=name)
        axis.set_title(model.label, fontsize=10)
        axis.set_xlabel(DRIVERS[variable])
        axis.xaxis.set_major_locator(MaxNLocator(nbins=7, prune='both'))
    axes[0].set_ylabel(f'{channel}, recorded - model ({unit})')
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, path)
    goes = DRIVERS[variable].split(' (')[0]
    what = f'Recorded minus model against {goes}, all recordings, warming and cooling apart; lines are means.'
    return Said(what, f'What is left of the {channel} against {goes}, a scatter plot of each: {_names(models)}')


def draw_loop(path: Path, diagnosis: Diagnosis) -> Said | None:
    """What is left of stroke (or force) over temperature in the last cycle of a recording: a loop shows a memory."""
    if not diagnosis.series:
        return None
    series = {s.channel: s for s in diagnosis.series[telling_recording(diagnosis)]}
    moved = series.get('displacement') or series.get('force')
    if moved is None:
        return None
    last = last_cycle(moved)
    few = last[thin(last.size)]
    unit, factor = SHOWN[moved.channel]
    models = compared(diagnosis)
    figure, axes = canvas(1, len(models), width=_WIDTH * len(models), height=3.6, sharey=True)
    for axis, model in zip(axes, models, strict=True):
        left = factor * (moved.recorded - model.of(moved))[few]
        warm = shown('temperature', moved.temperature[few])
        _shade_noise(axis, diagnosis, moved.channel)
        axis.plot(warm, left, color=OTHER, linewidth=0.6, alpha=0.6)
        for phase, colour, name in ((moved.rate > 0.0, HEATING, 'warming'), (moved.rate <= 0.0, COOLING, 'cooling')):
            axis.plot(warm[phase[few]], left[phase[few]], '.', color=colour, markersize=3, label=name)
        axis.set_title(model.label, fontsize=10)
        axis.set_xlabel('fibre temperature (degC)')
    axes[0].set_ylabel(f'{moved.channel}, recorded - model ({unit})')
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, path)
    span = f'{moved.time[last[0]]:.0f} s to {moved.time[last[-1]]:.0f} s'
    where = f'the last cycle of {recording_name(diagnosis, telling_recording(diagnosis))}'
    return Said(
        f'Recorded minus model over one cycle ({span}): a loop means memory or a lag, a single curve a wrong law.',
        f'What is left of the {moved.channel} against fibre temperature, over {where}: {_names(models)}',
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
    """The drive and load of the experiment that would decide between two effects."""
    proposal = diagnosis.next_experiment
    if proposal is None:
        return None
    edges = np.concatenate([[0.0], np.cumsum([step.duration for step in proposal.steps])])
    figure, (current, load) = canvas(2, height=1.9, sharex=True)
    for axis, name, colour in ((current, 'current', DRIVE), (load, 'load', LOAD)):
        levels = [getattr(step, name) for step in proposal.steps]
        axis.step(edges, [*levels, levels[-1]], where='post', color=colour, linewidth=1.6)
        axis.set_ylim(0.0, 1.15 * max(*levels, 1e-9))
    current.set_ylabel(CHANNEL_AXIS[proposal.kind])
    load.set_ylabel('load (N)')
    load.set_xlabel(f'time (s); all of it {proposal.repeat} times' if proposal.repeat > 1 else 'time (s)')
    load.set_xlim(0.0, float(edges[-1]))
    first, second = (plain(name) for name in proposal.separates)
    current.set_title(f'{first} or {second}? It decides with probability {chance(proposal.power)}', fontsize=10)
    save(figure, path)
    length, unit = proposal.repeat * float(edges[-1]), CHANNELS[proposal.kind].unit
    levels = sorted({step.current for step in proposal.steps})
    loads = ', '.join(f'{load:.2g}' for load in sorted({step.load for step in proposal.steps}))
    span = f'{proposal.kind}s from {levels[0]:.3g} to {levels[-1]:.3g} {unit}'
    return Said(
        f'The experiment that would decide: {proposal.kind} and load over time.',
        f'{plain(proposal.name)}, {length:.0f} s: {span}, loads {loads} N',
    )


def draw_sticking(path: Path, diagnosis: Diagnosis) -> Said | None:
    """One simulated run that sticks and slips beside the recorded one: the same kind of motion at other instants."""
    run = diagnosis.imitated
    if run is None:
        return None
    figure, axes = canvas(1, 2, height=3.2, sharey=True)
    labels = ('recorded', 'improved.yaml with stick_slip')
    for axis, value, label, colour in zip(axes, (run.recorded, run.simulated), labels, (RECORDED, AFTER), strict=True):
        axis.step(run.time, shown(run.channel, value), where='post', color=colour, linewidth=1.1)
        axis.set_title(label, fontsize=10)
        axis.set_xlabel('time (s)')
    axes[0].set_ylabel(CHANNEL_AXIS[run.channel])
    save(figure, path)
    return Said(
        'One recorded run and one simulated: the same kind of motion; the instants of the jumps are chance.',
        f'The {run.channel} of {run.name}, recorded, and of improved.yaml with stick-slip: both rest and jump',
    )


def _names(models: Sequence[Model]) -> str:
    """What the models are called, in a sentence."""
    return ' and '.join(model.label for model in models)


def _shade_noise(axis: Axes, diagnosis: Diagnosis, channel: str, **options: Any) -> None:
    """Twice the noise of a channel about zero, where it is known."""
    band = 2.0 * SHOWN[channel][1] * diagnosis.noise.get(channel, float('nan'))
    if np.isfinite(band):
        axis.axhspan(-band, band, color=RECORDED, alpha=0.12, linewidth=0, **options)


FIGURES: dict[str, Callable[[Path, Diagnosis], Said | None]] = {
    'channels.png': draw_channels,
    'driver.png': draw_driver,
    'loop.png': draw_loop,
    'ranking.png': draw_ranking,
    'experiment.png': draw_experiment,
    'sticking.png': draw_sticking,
}
