"""A figure of each group of the public rigs' runs: part of scripts/real_recordings.py --diagnose.

Runs of the lowest and of the highest power, each with a gain and a zero of its own, the band in which they repeat each
other, and the paper's model recalibrated and improved.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from real_diagnoses import Outcome, power_of, with_gain

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.style import AFTER, BEFORE, DRIVE, RECORDED, canvas, save


def channel_of(experiment: Experiment) -> str:
    """The one output that was recorded."""
    return next(iter(experiment.observed))


def draw_repeated(runs: Mapping[str, Experiment], outcome: Outcome, path: Path) -> None:
    """One panel for the lowest and one for the highest power, the legend below them."""
    picked = panels(runs)
    figure, axes = canvas(1, len(picked), width=4.8 * max(len(picked), 1.2), height=3.9)
    for axis, names in zip(axes, picked, strict=True):
        _panel(axis, [runs[n] for n in names], outcome)
        axis.set_title(f'{power_of(names[0])}: {len(names)} run{"s" if len(names) > 1 else ""}', fontsize=9)
    lines = {label: line for axis in axes for line, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    columns = 4 if len(picked) > 1 else 2
    figure.legend(lines.values(), lines.keys(), loc='outside lower center', ncols=columns, fontsize=8, frameon=False)
    save(figure, path)


def panels(runs: Mapping[str, Experiment]) -> list[list[str]]:
    """The names of the runs of the lowest and the highest power, of those of one power the kind with the most runs."""
    kinds: dict[str, list[str]] = {}
    for name in sorted(runs):
        kinds.setdefault(power_of(name), []).append(name)
    best: dict[float, list[str]] = {}
    for names in kinds.values():
        power = float(np.max(runs[names[0]].imposed.drive))
        best[power] = max(best.get(power, []), names, key=len)
    return [best[power] for power in sorted({min(best), max(best)})]


def _panel(axis: Axes, runs: list[Experiment], outcome: Outcome) -> None:
    """Runs of one power from the instant at which the power comes on in the first, and the models of that one."""
    first = runs[0]
    channel = channel_of(first)
    time, seen = first.observed[channel].time, first.observed[channel].value
    since = [float(run.imposed.time[np.argmax(run.imposed.drive > 0.0)]) for run in runs]
    alike = []
    for run, start in zip(runs, since, strict=True):
        o = run.observed[channel]
        course = np.interp(time - since[0], o.time - start, o.value, left=np.nan, right=np.nan)
        alike.append(_to_first(course, seen))
    middle = np.nanmean(np.stack(alike), axis=0)
    if outcome.floor is not None and len(runs) > 1:
        half = outcome.floor.own_gain * float(np.ptp(seen))
        low, high = shown(channel, middle - half), shown(channel, middle + half)
        axis.fill_between(time, low, high, color='#999999', alpha=0.35, linewidth=0, label='repeatability')
    for k, course in enumerate(alike):
        label = '' if k else 'runs, own gain and zero'
        axis.plot(time, shown(channel, course), color=RECORDED, linewidth=0.7, alpha=0.6, label=label)
    same = not outcome.diagnosis.findings
    models = [
        ("the paper's model, recalibrated" + (' (nothing was named)' if same else ''), outcome.diagnosis.calibrated)
    ]
    models += [] if same else [('improved', outcome.diagnosis.improved)]
    for (label, muscle), colour in zip(models, (BEFORE, AFTER), strict=False):
        if muscle is not None:
            course = with_gain(first.predict(muscle)[channel], np.where(np.isfinite(middle), middle, seen))
            axis.plot(time, shown(channel, course), color=colour, linewidth=1.8, label=label)
    at, on = first.imposed.time, first.imposed.drive > 0.0
    changes = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]])))
    for begin, end in changes.reshape(-1, 2):
        axis.axvspan(at[begin], at[min(end, at.size - 1)], color=DRIVE, alpha=0.10, linewidth=0)
    axis.set_xlabel('time (s), shaded: heated')
    axis.set_ylabel(CHANNEL_AXIS[channel])


def _to_first(values: Array, seen: Array) -> Array:
    """A run with the gain and zero that bring it nearest to the first, where both were seen."""
    both = np.isfinite(values)
    gain, zero = np.linalg.lstsq(np.stack([values[both], np.ones(both.sum())], axis=1), seen[both], rcond=None)[0]
    return np.asarray(gain * values + zero)
