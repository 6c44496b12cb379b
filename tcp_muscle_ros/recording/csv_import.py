"""A lab's files as recordings, as an import map says."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.inputs import not_readable
from tcp_muscle_ros.recording.import_map import (
    CLOCK,
    ColumnSource,
    ConstantSource,
    ImportMap,
    Run,
    ScheduleSource,
    Source,
    StampSource,
    TimeSource,
)
from tcp_muscle_ros.recording.lab.binary_file import KINDS, is_binary
from tcp_muscle_ros.recording.lab.cells import DAY_S, NO_NUMBER, day, decimal_of, is_value, number
from tcp_muscle_ros.recording.lab.grid import Layout, Row, count_named, joined_headings
from tcp_muscle_ros.recording.lab.heading_lines import misfit
from tcp_muscle_ros.recording.lab.reading import grid_of
from tcp_muscle_ros.recording.lab.text_file import SPACES
from tcp_muscle_ros.recording.lab.times import time_in
from tcp_muscle_ros.recording.lab.timing import falls_throughout, past_midnight, unwrapped
from tcp_muscle_ros.recording.lab.wide_rows import whole_rows
from tcp_muscle_ros.recording.recording import CHANNELS, UNDATED_NS, Array, Channel, Recording
from tcp_muscle_ros.recording.units import UNITS

_LONGEST_S = 366 * 86400.0
LAB_KINDS = ('.csv', *KINDS)  # that are looked for in directories; a file that is named may be of any kind
_BAG_KINDS = ('.mcap', '.db3')
_SPREAD = '; where rows come evenly, say dt_s (s from row to row) in a map in place of time'
_SLOWEST_S = 2.0  # from row to row, of a logger, by which the unit of its time is guessed


@dataclass(frozen=True)
class Imported:
    """A run that was read; ``name`` is that of its bag."""

    name: str
    recording: Recording


def lab_files(paths: Sequence[str | Path]) -> list[Path]:
    """The files among `paths`, and every file that a lab's could be below the directories. BadInput: one is missing."""
    found: list[Path] = []
    for path in map(Path, paths):
        if path.is_dir():
            below = sorted(file for file in path.rglob('*') if file.suffix.lower() in LAB_KINDS and file.is_file())
            if not below and any(file.suffix in _BAG_KINDS for file in path.iterdir()):
                raise BadInput(f"{path}: is a bag already; 'tcp_muscle info {path}' shows what is in it")
            if not below:
                raise BadInput(f'{path}: no {", ".join(LAB_KINDS)} file in this directory')
            found += below
        elif path.is_file() and path.suffix in _BAG_KINDS:
            raise BadInput(f"{path}: is of a bag already; 'tcp_muscle info {path}' shows what is in it")
        elif path.is_file():
            found.append(path)
        else:
            raise not_readable(path, 'file')
    return list(dict.fromkeys(found))


def import_runs(import_map: ImportMap, files: Sequence[Path]) -> Iterator[Imported]:
    """Every run of the map that is in one of `files`, as a recording; file by file.

    BadInput: no file is a run of the map, two runs of one name, or a file that does not hold what the map says, with
    file, row and column.
    """
    matches = [(run, file) for file in files for run in import_map.runs if run.matches(file.absolute())]
    if not matches:
        raise BadInput(
            f'{import_map.path}: none of the {len(files)} file(s) is a run of this map, '
            f'for example {files[0]} does not match {import_map.runs[0].file}'
        )
    names: dict[str, Path] = {}
    for run, file in matches:
        name = _name(run, file)
        if name in names:
            raise BadInput(
                f"{run.where}: two runs are named '{name}' ({names[name]} and {file}); "
                'tell them apart with name: and {stem}, {parent}'
            )
        names[name] = file
    for run, file in matches:
        yield Imported(_name(run, file), _recording(run, _Table(file, run.layout)))


def unclaimed(import_map: ImportMap, files: Sequence[Path]) -> list[Path]:
    """The files that are no run of the map and that it does not ignore."""
    return [
        file
        for file in files
        if not import_map.ignores(file) and not any(run.matches(file.absolute()) for run in import_map.runs)
    ]


def _name(run: Run, file: Path) -> str:
    try:
        name = run.name.format(stem=file.stem, parent=file.absolute().parent.name)
    except (AttributeError, LookupError, TypeError, ValueError):
        raise BadInput(f"{run.where}: name is '{run.name}', expected a text with {{stem}} or {{parent}}") from None
    if '/' in name or not name.strip('.'):
        raise BadInput(f"{run.where}: name is '{name}', expected a name without '/'")
    return name


class _Table:
    """A table of a file: headings and cells. Row numbers count from 1, as a text editor shows them."""

    def __init__(self, path: Path, layout: Layout) -> None:
        self.path, self.layout = path, layout
        grid = grid_of(path, layout)
        self.left_out: tuple[int, ...] = ()
        rows = [row for row in grid.rows if not row.blank]
        if len(rows) < 2:
            raise BadInput(f'{path}: no data: expected a row of headings and rows of numbers')
        if layout.headings is None and all(is_value(cell) for cell in rows[0].cells if cell):
            self.headings, self.rows = [''] * len(rows[0].cells), rows  # no headings, and none is lost
        elif layout.headings is None:
            self.headings, self.rows = list(rows[0].cells), rows[1:]
        else:
            width = max(len(row.cells) for row in rows)
            named = tuple(row for row in rows if row.number in layout.headings)
            self.headings, below = joined_headings(named, width), max(layout.headings, default=0)
            self.rows = [row for row in rows if row.number > below and any(map(is_value, row.cells))]
            if not is_binary(path):
                whole, self.left_out = whole_rows(self.rows, count_named(named), layout.delimiter)
                self.rows = list(whole)
        self._below = tuple(self.rows)
        first, last = layout.first or 0, layout.last or max(row.number for row in rows)
        self.rows = [row for row in self.rows if first <= row.number <= last]
        for heading, text in layout.only.items():
            column = self.find(ColumnSource(heading, None, UNITS['s']), 'only')
            self.rows = [row for row in self.rows if column < len(row.cells) and row.cells[column] == text]
        if not self.rows:
            raise BadInput(f'{path}: no rows from {first} to {last} as its map says')
        self.notes = list(grid.notes if self.rows[-1].number == rows[-1].number else ())  # of the run at the file's end
        if left_out := [number for number in self.left_out if first <= number <= last]:
            self.notes.append(
                f'{len(left_out)} row(s) with more numbers than headings are left out, the first is row {left_out[0]}'
            )

    def find(self, source: ColumnSource, where: str) -> int:
        """The index of a column."""
        if isinstance(source.column, int):
            if source.column >= len(self.headings):
                raise BadInput(
                    f'{self.path}: no column {source.column}, it has {len(self.headings)} (counted from 0); see {where}'
                )
            return source.column
        if self.layout.delimiter == SPACES:
            ((width, _),) = Counter(len(row.cells) for row in self.rows).most_common(1)
            if wrong := misfit(self.headings, width):
                raise BadInput(f'{self.path}: {wrong}; or say columns by their indices, counted from 0; see {where}')
        at = [k for k, heading in enumerate(self.headings) if heading == source.column.strip()]
        if not at:
            raise BadInput(
                f"{self.path}: no column '{source.column}'{nearest(source.column, set(self.headings))}; see {where}"
            )
        if source.occurrence is None and len(at) > 1:
            raise BadInput(
                f"{self.path}: the heading '{source.column}' stands over columns {', '.join(map(str, at))}; "
                f'say which with occurrence: 1 to {len(at)}; see {where}'
            )
        occurrence = source.occurrence or 1
        if occurrence > len(at):
            raise BadInput(f"{self.path}: the heading '{source.column}' occurs {len(at)} time(s), not {occurrence}")
        return at[occurrence - 1]

    def texts(self, column: int) -> list[str]:
        """The cells of a column, '' where a row is shorter."""
        return _cells(self.rows, column)

    def drop_repeats(self, notes: list[str]) -> None:
        """Leave out rows that say the same as the one before, time and all: a logger wrote them twice."""
        kept = [row for k, row in enumerate(self.rows) if k == 0 or row.cells != self.rows[k - 1].cells]
        if len(kept) < len(self.rows):
            notes.append(f'{len(self.rows) - len(kept)} row(s) that repeat the one before, time and all, are left out')
            self.rows = kept

    def numbers(self, column: int) -> Array:
        """A column as float64[rows], NaN where a cell has no number."""
        values = np.full(len(self.rows), np.nan)
        decimal = decimal_of(_cells(self._below, column), self.layout.decimal)
        for k, cell in enumerate(self.texts(column)):
            if cell.lower() in NO_NUMBER or cell in self.layout.missing:
                continue
            value = number(cell, decimal)
            if value is None:
                raise BadInput(f"{self.at(k, column)}: '{cell}' is not a number")
            values[k] = value
        return values

    def at(self, k: int, column: int) -> str:
        """Where a cell is."""
        heading = self.headings[column] if column < len(self.headings) else str(column)
        return f"{self.path}: row {self.rows[k].number}, column '{heading}'"


def _cells(rows: Sequence[Row], column: int) -> list[str]:
    return [row.cells[column].strip() if column < len(row.cells) else '' for row in rows]


def _recording(run: Run, table: _Table) -> Recording:
    notes = list(table.notes)
    began = 0.0
    if isinstance(run.time, float):
        lasts = run.time * (len(table.rows) - 1)
        if lasts > _LONGEST_S:
            raise BadInput(
                f'{run.where}: dt_s is {run.time:g} s, with which the {len(table.rows)} rows of {table.path} last '
                f'{lasts:.3g} s, but no run lasts a year; expected the time from one row to the next, in s'
            )
        time: Array = run.time * np.arange(len(table.rows), dtype=np.float64)
    else:
        if falls_throughout(_as_written(run.time, table, run.where)):
            table.rows.reverse()  # the newest stood first
        table.drop_repeats(notes)
        time = _time(run.time, table, run.where)
        began = _first(time)
    channels = {}
    for name, source in run.channels.items():
        own = source.time if isinstance(source, ColumnSource) else None
        rows = time - began if own is None else _own_times(name, own, run, table, time, notes)
        at, value = _samples(name, source, table, rows, run.where, notes)
        if not len(at):
            raise BadInput(f"{table.path}: no number for channel '{name}'; see {run.where}")
        channels[name] = Channel(name, at, value, '/' + CHANNELS[name].topic)
    folders = len(PurePath(run.file).parts)  # as far as the map names them: where the data lie is of no interest
    known: dict[str, object] = {**run.known, 'source_file': '/'.join(table.path.absolute().parts[-folders:])}
    return Recording(str(table.path), channels, UNDATED_NS, known, tuple(notes))


def _own_times(name: str, own: TimeSource, run: Run, table: _Table, time: Array, notes: list[str]) -> Array:
    """The times of a channel that has its own, s from the first of the run's ``time``.

    Two columns of seconds are of one count, two of stamps of one clock: what one began later stays. Where only one of
    them has dates, or none, they are taken to begin less than half a day apart. Of a count and a stamp nothing tells
    how far they began apart.
    """
    rows = _time(own, table, run.where)
    if isinstance(own, ColumnSource):
        return rows - (_first(time) if isinstance(run.time, ColumnSource) else 0.0)
    if not isinstance(run.time, StampSource):
        return rows - _first(rows)
    since = rows - _first(time)
    if _is_dated(own) and _is_dated(run.time):
        return since
    since = since - DAY_S * round(_first(since) / DAY_S)
    if np.nanmax(since) < 0.0 or np.nanmin(since) > np.nanmax(time) - _first(time):
        notes.append(f'{name}: its own times of day are not those of the run; taken to begin with it')
        return rows - _first(rows)
    return since


def _first(time: Array) -> float:
    """The first time that is known."""
    return float(time[np.isfinite(time)][0])


def _is_dated(source: StampSource) -> bool:
    return source.kind != CLOCK or source.date is not None


def _time(source: TimeSource, table: _Table, where: str) -> Array:
    """The time of each row, s. NaN where a table that has parts of unequal length has no time in a row."""
    if isinstance(source, StampSource):
        return _stamps(source, table, where)
    column = table.find(source, where)
    time = _as_written(source, table, where)
    known = _known(time, table, column)
    for k in np.flatnonzero(np.diff(time[known]) <= 0):
        before, after = time[known[k]], time[known[k + 1]]
        raise BadInput(
            f'{table.at(int(known[k + 1]), column)}: time runs backwards, {after:g} s after {before:g} s'
            if after < before
            else f'{table.at(int(known[k + 1]), column)}: time stands still at {before:g} s{_SPREAD}'
        )
    since_first: Array = time[known] - time[known[0]]
    if len(known) > 1 and since_first[-1] > _LONGEST_S:
        raise BadInput(_too_long(source, table, column, since_first, where))
    return time


def _as_written(source: TimeSource, table: _Table, where: str) -> Array:
    """The time of each row as it stands there, s; NaN where there is none."""
    if isinstance(source, ColumnSource):
        return _si(source, unwrapped(table.numbers(table.find(source, where)), source.wraps))
    column = table.find(ColumnSource(source.column, source.occurrence, UNITS['s']), where)
    of_day = source.kind == CLOCK
    time = _read(
        table,
        column,
        lambda cell: time_in(cell, source.kind, source.order),
        f'a time as 14:03:22.5{"" if of_day else " after its date"}',
    )
    if source.date is not None:
        time = time + _read(table, table.find(source.date, where), lambda cell: day(cell, source.order), 'a date')
    elif of_day:
        time = past_midnight(time)
    if source.fraction is not None:
        time = time + _si(source.fraction, table.numbers(table.find(source.fraction, where)))
    return time


def _known(time: Array, table: _Table, column: int) -> NDArray[np.int64]:
    """The rows that have a time: all of them, unless the map says where the table stands."""
    missing = np.flatnonzero(~np.isfinite(time))
    if len(missing) and (table.layout.headings is None or len(missing) == len(time)):
        raise BadInput(f'{table.at(int(missing[0]), column)}: no time')
    return np.flatnonzero(np.isfinite(time))


def _stamps(source: StampSource, table: _Table, where: str) -> Array:
    """Times of day or dates, s."""
    column = table.find(ColumnSource(source.column, source.occurrence, UNITS['s']), where)
    time = _as_written(source, table, where)
    known = _known(time, table, column)
    for k in np.flatnonzero(np.diff(time[known]) <= 0):
        raise BadInput(f'{table.at(int(known[k + 1]), column)}: the time is not later than in the row before{_SPREAD}')
    return time


def _read(table: _Table, column: int, read: Callable[[str], float | None], expected: str) -> Array:
    values = np.full(len(table.rows), np.nan)
    for k, cell in enumerate(table.texts(column)):
        value = read(cell) if cell else math.nan
        if value is None:
            raise BadInput(f"{table.at(k, column)}: '{cell}', expected {expected}")
        values[k] = value
    return values


def _too_long(source: ColumnSource, table: _Table, column: int, time: Array, where: str) -> str:
    """What is wrong with a time column that spans more than a year: a leap, or its unit."""
    step = np.diff(time)
    k, usual = int(np.argmax(step)), float(np.median(step))
    if time[-1] - step[k] <= _LONGEST_S and step[k] > 10.0 * usual:
        return (
            f'{table.at(k + 1, column)}: time jumps by {step[k]:.3g} s, where a row is usually {usual:.3g} s after the '
            'last: was the clock set? Make two files of it'
        )
    factors = {unit.name: unit.scale / source.unit.scale for unit in UNITS.values() if unit.quantity == 'time'}
    fitting = [u for u, f in factors.items() if f < 1.0 and usual * f < _SLOWEST_S and time[-1] * f <= _LONGEST_S]
    meant = max(fitting, key=factors.__getitem__, default='')
    return (
        f"{table.at(len(time) - 1, column)}: the run lasts {time[-1]:.3g} s, its time being in '{source.unit.name}', "
        f'but no run lasts a year{f"; did you mean unit: {meant}?" if meant else ""}; see time in {where}'
    )


def _samples(
    name: str, source: Source, table: _Table, time: Array, where: str, notes: list[str]
) -> tuple[Array, Array]:
    """A channel's own time and SI values."""
    if not isinstance(source, ColumnSource):
        time = time[np.isfinite(time)]  # below the shorter of two tables there is none
    if isinstance(source, ConstantSource):
        return time, np.full(len(time), source.value)
    if isinstance(source, ScheduleSource):
        edges = np.cumsum([0.0, *(duration for duration, _ in source.steps)])
        at = np.union1d(time, edges[(edges > time[0]) & (edges < time[-1])])
        step = np.clip(np.searchsorted(edges, at, side='right') - 1, 0, len(source.steps) - 1)
        return at, np.array([value for _, value in source.steps])[step]
    value = _si(source, table.numbers(table.find(source, where)))
    finite = np.isfinite(value) & np.isfinite(time)
    rows = np.count_nonzero(np.isfinite(time))
    if np.count_nonzero(finite) < rows:
        notes.append(f'{name}: {rows - np.count_nonzero(finite)} of {rows} rows have no number')
    return time[finite], value[finite]


def _si(source: ColumnSource, x: Array) -> Array:
    scaled = source.scale * x
    if source.offset is None:
        finite = scaled[np.isfinite(scaled)]
        scaled = scaled - (finite[0] if len(finite) else 0.0)
    else:
        scaled = scaled + source.offset
    return source.unit.to_si(source.sign * scaled)
