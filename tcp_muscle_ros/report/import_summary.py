"""What an import without a map understood of a file, as text."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tcp_muscle_ros.recording.lab.draft import DraftColumn, DraftRun, DraftTime
from tcp_muscle_ros.recording.recording import CHANNELS, Recording
from tcp_muscle_ros.recording.units import UNITS

_ROWS = 3
_SEPARATORS = {'\t': 'tabs', 'spaces': 'spaces', 'pairs': 'name:value pairs', 'json': 'JSON objects'}


def understood(file: Path, runs: Sequence[DraftRun], first: Recording) -> str:
    """How a file is written, what its columns are, and its first rows as they were read, in SI (temperatures in degC).

    ``first`` is the first of its runs.
    """
    run = runs[0]
    lines = [f'{file}: {_written(run)}']
    if len(runs) > 1:
        lines[0] += f'; {len(runs)} runs'
    lines += [f'  {name:<13} {what}' for name, what in [('time', _time(run.time)), *map(_column, run.columns)]]
    lines += [f'  {"left out":<13} {", ".join(run.left_out)}'] if run.left_out else []
    lines += [f'  note: {note}' for each in runs for note in each.notes if each is run or note not in run.notes]
    return '\n'.join([*lines, *_first_rows(first)])


def _written(run: DraftRun) -> str:
    layout = run.layout
    rows = f'rows {layout.first} to {layout.last}'
    if layout.sheet:
        return f"sheet '{layout.sheet}', {rows}"
    separator = _SEPARATORS.get(layout.delimiter, f"'{layout.delimiter}'")
    comma = ', decimal commas' if layout.decimal == ',' else ''
    heads = [row for row in layout.headings or () if row]
    above = f', headings in row {", ".join(map(str, heads))}' if heads else ''
    return f'{layout.encoding}, separated by {separator}{comma}{above}, {rows}'


def _time(time: DraftTime | float) -> str:
    if isinstance(time, float):
        return f'a row every {time:g} s, as is written above'
    more = [str(ref) for ref in (time.date, time.fraction) if ref is not None]
    return f'{time.ref} in {time.unit}' + (f', with {" and ".join(more)}' if more else '')


def _column(column: DraftColumn) -> tuple[str, str]:
    scaled = f', times {column.scale:g}' if column.scale != 1.0 else ''
    turned = ', sign turned: contraction is positive' if column.sign < 0 else ''
    zero = ', from its first value' if column.from_first else ''
    own = f', at the times of {column.time.ref}' if column.time is not None else ''
    return column.channel, f'{column.ref} in {column.unit}{scaled}{turned}{zero}{own}'


def _first_rows(recording: Recording) -> list[str]:
    time = np.unique(np.concatenate([channel.time for channel in recording.channels.values()]))[:_ROWS]
    heads = ['time s', *(f'{name} {CHANNELS[name].unit}' for name in recording)]
    rows = [heads]
    for t in time:
        cells = [f'{t:.6g}']
        for name, channel in recording.channels.items():
            at = np.flatnonzero(channel.time == t)
            value = UNITS[CHANNELS[name].unit].from_si(channel.value[at])
            cells.append(f'{float(value[0]):.6g}' if len(at) else '')
        rows.append(cells)
    widths = [max(len(row[k]) for row in rows) for k in range(len(heads))]
    return ['    ' + '  '.join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
