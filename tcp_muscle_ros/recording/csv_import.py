"""A lab's CSV files as recordings, as an import map says."""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath

import numpy as np

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.recording.import_map import ColumnSource, ConstantSource, ImportMap, Run, ScheduleSource, Source
from tcp_muscle_ros.recording.recording import CHANNELS, Array, Channel, Recording
from tcp_muscle_ros.recording.units import UNITS

# A CSV file does not say when it was made. Its bag starts at a round number, 9 September 2001: not 0, which means "no
# stamp" in ROS, and not today, so that the same file always gives the same bag.
START_NS = 1_000_000_000 * 1_000_000_000
_LONGEST_S = 366 * 86400.0
_SLOWEST_S = 2.0  # from row to row, of a logger, by which the unit of its time is guessed


@dataclass(frozen=True)
class Imported:
    """A run that was read; ``name`` is that of its bag."""

    name: str
    recording: Recording


def csv_files(paths: Sequence[str | Path]) -> list[Path]:
    """The files among `paths`, and every ``.csv`` below the directories among them. BadInput for a missing one."""
    found: list[Path] = []
    for path in map(Path, paths):
        if path.is_dir():
            below = sorted(path.rglob('*.csv'))
            if not below:
                raise BadInput(f'{path}: no .csv file in this directory')
            found += below
        elif path.is_file():
            found.append(path)
        else:
            siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            raise BadInput(f'{path}: no such file{nearest(path.name, siblings)}')
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
    tables: dict[tuple[Path, str], _Table] = {}
    for run, file in matches:
        table = tables.setdefault((file, run.delimiter), _Table(file, run.delimiter))
        yield Imported(_name(run, file), _recording(run, table))


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
    """A CSV file: headings and cells. Row numbers count from 1 with the headings, as a text editor shows them."""

    def __init__(self, path: Path, delimiter: str) -> None:
        self.path = path
        try:
            with path.open(encoding='utf-8-sig', newline='') as file:
                reader = csv.reader(file, delimiter=delimiter)
                rows = [(reader.line_num, row) for row in reader]
        except OSError as error:
            raise BadInput(f'{path}: cannot be read ({error.strerror})') from None
        except (UnicodeDecodeError, csv.Error, TypeError) as error:
            raise BadInput(f'{path}: not a CSV file ({error})') from None
        rows = [(number, row) for number, row in rows if any(cell.strip() for cell in row)]
        if len(rows) < 2:
            raise BadInput(f'{path}: no data: expected a row of headings and rows of numbers')
        self.headings = [cell.strip() for cell in rows[0][1]]
        self.rows = rows[1:]

    def find(self, source: ColumnSource, where: str) -> int:
        """The index of a column."""
        if isinstance(source.column, int):
            if source.column >= len(self.headings):
                raise BadInput(
                    f'{self.path}: no column {source.column}, it has {len(self.headings)} (counted from 0); see {where}'
                )
            return source.column
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

    def numbers(self, column: int) -> Array:
        """A column as float64[rows], NaN where a cell is empty."""
        values = np.full(len(self.rows), np.nan)
        for k, (_, row) in enumerate(self.rows):
            cell = row[column].strip() if column < len(row) else ''
            if cell:
                try:
                    values[k] = float(cell)
                except ValueError:
                    raise BadInput(f"{self.at(k, column)}: '{cell}' is not a number") from None
        return values

    def at(self, k: int, column: int) -> str:
        """Where a cell is."""
        heading = self.headings[column] if column < len(self.headings) else str(column)
        return f"{self.path}: row {self.rows[k][0]}, column '{heading}'"


def _recording(run: Run, table: _Table) -> Recording:
    notes: list[str] = []
    time: Array
    if isinstance(run.time, float):
        lasts = run.time * (len(table.rows) - 1)
        if lasts > _LONGEST_S:
            raise BadInput(
                f'{run.where}: dt_s is {run.time:g} s, with which the {len(table.rows)} rows of {table.path} last '
                f'{lasts:.3g} s, but no run lasts a year; expected the time from one row to the next, in s'
            )
        time = run.time * np.arange(len(table.rows), dtype=np.float64)
    else:
        time = _time(run.time, table, run.where)
    channels = {}
    for name, source in run.channels.items():
        at, value = _samples(name, source, table, time, run.where, notes)
        if not len(at):
            raise BadInput(f"{table.path}: no number for channel '{name}'; see {run.where}")
        channels[name] = Channel(name, at, value, '/' + CHANNELS[name].topic)
    folders = len(PurePath(run.file).parts)  # as far as the map names them: where the data lie is of no interest
    known: dict[str, object] = {**run.known, 'source_file': '/'.join(table.path.absolute().parts[-folders:])}
    return Recording(str(table.path), channels, START_NS, known, tuple(notes))


def _time(source: ColumnSource, table: _Table, where: str) -> Array:
    """The time of each row, s, from the first on."""
    column = table.find(source, where)
    time = _si(source, table.numbers(column))
    for k in np.flatnonzero(~np.isfinite(time)):
        raise BadInput(f'{table.at(int(k), column)}: no time')
    for k in np.flatnonzero(np.diff(time) <= 0):
        raise BadInput(
            f'{table.at(int(k) + 1, column)}: time runs backwards, {time[k + 1]:g} s after {time[k]:g} s'
            if time[k + 1] < time[k]
            else f'{table.at(int(k) + 1, column)}: time stands still at {time[k]:g} s'
        )
    since_first: Array = time - time[0]
    if len(time) > 1 and since_first[-1] > _LONGEST_S:
        raise BadInput(_too_long(source, table, column, since_first, where))
    return since_first


def _too_long(source: ColumnSource, table: _Table, column: int, time: Array, where: str) -> str:
    """What is wrong with a time column that spans more than a year: a leap, or its unit."""
    step = np.diff(time)
    k, usual = int(np.argmax(step)), float(np.median(step))
    if time[-1] - step[k] <= _LONGEST_S and step[k] > 10.0 * usual:
        return (
            f'{table.at(k + 1, column)}: time leaps by {step[k]:.3g} s, where a row is usually {usual:.3g} s after the '
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
    if isinstance(source, ConstantSource):
        return time, np.full(len(time), source.value)
    if isinstance(source, ScheduleSource):
        edges = np.cumsum([0.0, *(duration for duration, _ in source.steps)])
        at = np.union1d(time, edges[(edges > time[0]) & (edges < time[-1])])
        step = np.clip(np.searchsorted(edges, at, side='right') - 1, 0, len(source.steps) - 1)
        return at, np.array([value for _, value in source.steps])[step]
    value = _si(source, table.numbers(table.find(source, where)))
    finite = np.isfinite(value)
    if not finite.all():
        notes.append(f'{name}: {np.count_nonzero(~finite)} of {len(value)} rows have no number')
    return time[finite], value[finite]


def _si(source: ColumnSource, x: Array) -> Array:
    scaled = source.scale * x
    if source.offset is None:
        finite = scaled[np.isfinite(scaled)]
        scaled = scaled - (finite[0] if len(finite) else 0.0)
    else:
        scaled = scaled + source.offset
    return source.unit.to_si(source.sign * scaled)
