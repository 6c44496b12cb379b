"""Calibrated parameters of many runs with their 90 % intervals: over muscles, cycles and days."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from tcp_muscle_ros.report.campaign_summary import Row
from tcp_muscle_ros.report.style import AFTER, COOLING, DRIVE, HEATING, LOAD, OTHER, canvas, literal, save

_COLOURS = (AFTER, HEATING, LOAD, DRIVE, COOLING, '#000000')
_AXES = {'muscle': 'muscle', 'cycles': 'cycles', 'day': 'day'}
_TICKS = 6  # so many days are each named
_LEGEND = 6  # more muscles than colours are not told apart
_HEIGHT, _WIDTH = 1.9, 4.6  # inches, of one panel


def draw_trends(path: str | Path, rows: Sequence[Row]) -> bool:
    """A row of panels a parameter that some run fixes, a column for each of muscle, cycles and day that is stated.

    Where none is stated, over the runs in the order of the manifest. False, and no file, where nothing was fixed.
    """
    names = list(dict.fromkeys(name for row in rows for name in row.parameters))
    if not names:
        return False
    over = [key for key in _AXES if any(getattr(row, key) is not None for row in rows if row.parameters)] or ['name']
    width = max(_WIDTH * len(over), 6.0)
    figure, axes = canvas(len(names), len(over), width=width, height=_HEIGHT, sharex='col', sharey='row')
    muscles = sorted({row.muscle for row in rows if row.parameters and row.muscle is not None})
    for place, axis in enumerate(axes):
        name, key = names[place // len(over)], over[place % len(over)]
        seen = [row for row in rows if name in row.parameters and getattr(row, key) is not None]
        _panel(axis, seen, name, key, muscles)
        if place % len(over) == 0:
            unit = next(row.parameters[name]['unit'] for row in rows if name in row.parameters)
            axis.set_ylabel(name if unit in ('', '1') else f'{name} ({unit})')
            axis.ticklabel_format(axis='y', useOffset=False)
        if place >= len(axes) - len(over):
            axis.set_xlabel(_AXES.get(key, 'run'))
    if 1 < len(muscles) <= _LEGEND and over != ['muscle']:
        axes[len(over) - 1].legend(fontsize='small')
    figure.suptitle('Calibrated parameters, 90 % intervals; dashed: nominal', fontsize='medium')
    save(figure, path)
    return True


def _panel(axis: Axes, rows: Sequence[Row], name: str, key: str, muscles: Sequence[str]) -> None:
    named = key in ('muscle', 'name')
    labels = sorted({getattr(row, key) for row in rows}) if key == 'muscle' else [getattr(row, key) for row in rows]
    for muscle in [*muscles, None]:
        mine = [row for row in rows if row.muscle == muscle]
        if not mine:
            continue
        found = [row.parameters[name] for row in mine]
        value, low, high = (np.array([each[k] for each in found], dtype=float) for k in ('value', 'low', 'high'))
        x = [labels.index(getattr(row, key)) if named else getattr(row, key) for row in mine]
        if key == 'muscle':  # the runs of one muscle beside each other
            x = list(np.asarray(x) + 0.3 * (np.linspace(-1, 1, len(x)) if len(x) > 1 else np.zeros(1)))
        colour = _COLOURS[muscles.index(muscle)] if muscle is not None and len(muscles) <= _LEGEND else OTHER
        spread = np.clip([value - low, high - value], 0.0, None)
        label = muscle and literal(muscle)
        axis.errorbar(x, value, spread, fmt='o', markersize=4, capsize=2, linewidth=1, color=colour, label=label)
    nominal = {row.parameters[name]['nominal'] for row in rows} - {None}
    if len(nominal) == 1:
        axis.axhline(nominal.pop(), color=OTHER, linewidth=0.8, linestyle='--')
    if named:
        axis.set_xticks(range(len(labels)), [literal(label) for label in labels], rotation=30 if len(labels) > 4 else 0)
        axis.set_xlim(-0.5, len(labels) - 0.5)
    elif key == 'day':
        days = sorted(set(labels))
        if len(days) <= _TICKS:
            axis.set_xticks(days, [day.isoformat() for day in days])
        axis.tick_params('x', rotation=30)
