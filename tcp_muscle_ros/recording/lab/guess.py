"""A lab file without a map: which column is which channel, in which unit, and how many runs it holds."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.lab.binary_file import is_binary
from tcp_muscle_ros.recording.lab.cells import NO_NUMBER, is_value, number
from tcp_muscle_ros.recording.lab.channels import channels_of, is_steady
from tcp_muscle_ros.recording.lab.columns import Column, columns_of
from tcp_muscle_ros.recording.lab.draft import DraftColumn, DraftRun, DraftTime
from tcp_muscle_ros.recording.lab.grid import Layout
from tcp_muscle_ros.recording.lab.heading_lines import misfit
from tcp_muscle_ros.recording.lab.preamble import hanging_load, load_before, room_temperature
from tcp_muscle_ros.recording.lab.reading import LabSheet, sheets_of
from tcp_muscle_ros.recording.lab.tables import SHARE, Table, find_tables
from tcp_muscle_ros.recording.lab.text_file import SPACES
from tcp_muscle_ros.recording.lab.timing import falls_throughout, time_of, times
from tcp_muscle_ros.recording.lab.vocabulary import ROLES
from tcp_muscle_ros.recording.lab.wide_rows import too_many, whole_rows, with_thousands
from tcp_muscle_ros.recording.options import A_MAP
from tcp_muscle_ros.recording.units import UNITS

_HELP = ('say it in ', *A_MAP)
_MOST_RUNS = 200  # that one column of names can tell apart
_GAP = 3.0  # rows that may be missing where a line of words stands


@dataclass(frozen=True)
class Part:
    """Columns that belong together: a table, or one of several side by side, of some rows."""

    table: Table
    columns: tuple[Column, ...]
    layout: Layout
    title: str = ''
    only: tuple[str, str] | None = None


def guess(path: Path) -> list[DraftRun]:
    """The runs of a lab file. BadInput: one line that says what cannot be told from it."""
    runs: list[DraftRun] = []
    without: list[tuple[Table, BadInput]] = []
    notes: list[str] = []
    for sheet in sheets_of(path):
        tables = _joined(find_tables(sheet.grid), sheet)
        most = max((len(table.rows) for table in tables), default=0)
        for table in tables:
            found = _runs_of(table, sheet.layout, path)
            if len(table.rows) < SHARE * most:
                notes += [] if isinstance(found, BadInput) else [_too_short(table)]
            elif isinstance(found, BadInput):
                without.append((table, found))
            else:
                runs += found
    longest = max(((run.layout.last or 0) - (run.layout.first or 0) for run in runs), default=0)
    for table, why in without:
        if len(table.rows) >= SHARE * longest:
            raise why
    if without:
        sheets = ', '.join(dict.fromkeys(f"'{table.sheet}'" for table, _ in without))
        notes.append(f'sheets that hold no run are left out: {sheets}')
    if not runs:
        raise BadInput(f'{path}: no table of numbers in it; expected a row of headings and rows of numbers below it')
    runs[0] = replace(runs[0], notes=(*runs[0].notes, *notes))
    return _named(runs, path)


def _too_short(table: Table) -> str:
    first, last = table.rows[0].number, table.rows[-1].number
    sheet = f" of sheet '{table.sheet}'" if table.sheet else ''
    return f'rows {first} to {last}{sheet} are left out: a run that is far shorter than the longest'


def _joined(tables: list[Table], sheet: LabSheet) -> list[Table]:
    """Tables between which a program wrote a line of its own ("WARN: overrun") while the time went on, as one."""
    found: list[Table] = []
    for table in tables:
        if found and _goes_on(found[-1], table, sheet):
            found[-1] = replace(found[-1], rows=(*found[-1].rows, *table.rows))
        else:
            found.append(table)
    return found


def _goes_on(before: Table, after: Table, sheet: LabSheet) -> bool:
    """Has a table no headings of its own, and times that follow those of the one before, row after row?"""
    between = [row for row in sheet.grid.rows if before.rows[-1].number < row.number < after.rows[0].number]
    words = {word.lower() for row in between for cell in row.cells for word in re.findall(r'[^\W\d_]+', cell)}
    if (
        after.above != before.above
        or words & {*ROLES['run'].split()}
        or any(is_value(c) for r in between for c in r.cells)
    ):
        return False
    columns = columns_of(before, sheet.layout)
    time = time_of(columns, before.preamble)
    if not isinstance(time, DraftTime):
        return False
    first = times(columns, time)
    second = times(columns_of(after, sheet.layout), time)
    return bool(0.0 < second[0] - first[-1] <= _GAP * np.median(np.diff(first)))


def _runs_of(table: Table, layout: Layout, path: Path) -> list[DraftRun] | BadInput:
    """The runs in a table, or why there are none."""
    try:
        return [run for part in _parts(table, layout, path) for run in _runs(part, path)]
    except BadInput as error:
        return error


def _parts(table: Table, layout: Layout, path: Path) -> Iterator[Part]:
    """What stands side by side, each with a time of its own and the same headings; else the table as it is."""
    if not is_binary(path):
        table = replace(table, rows=whole_rows(table.rows, table.named, layout.delimiter)[0])
    layout = replace(layout, headings=table.above, first=table.rows[0].number, last=table.rows[-1].number)
    columns = columns_of(table, layout)
    if not any(column.heading for column in columns):
        raise BadInput(
            f'{path}: no headings above row {table.rows[0].number}, so its {len(columns)} columns could be anything; '
            "expected a row as 'Time (s),Temperature (°C),Current (A)'"
        )
    _refuse_shifted(table, columns, layout, path)
    starts = [k for k, column in enumerate(columns) if column.heading and column.heading == _first_time(columns)]
    groups = [columns[a:b] for a, b in pairwise([*starts, len(columns)])]
    names = [tuple(column.heading for column in group if column.heading) for group in groups]
    if len(groups) > 1 and len(set(names)) == 1:
        for group in groups:
            yield Part(table, tuple(group), layout, table.titles[group[0].index])
    else:
        yield from _by_name(Part(table, tuple(columns), layout))


def _refuse_shifted(table: Table, columns: Sequence[Column], layout: Layout, path: Path) -> None:
    """BadInput where there are fewer headings than columns, or spaces part more, so that they may stand over others
    than their own. In a sheet of cells they cannot."""
    width = max((column.index + 1 for column in columns if any(column.cells)), default=0)
    if layout.delimiter == SPACES and (wrong := misfit([column.heading for column in columns], width)):
        raise BadInput(f'{path}: {wrong}')
    if not is_binary(path) and (width := too_many(table.rows, table.named)):
        found = with_thousands(table.rows, table.named) if layout.delimiter == ',' else ''
        quotes = f'where a comma parts thousands, put such numbers in quotes, as "{found}"; ' if found else ''
        raise BadInput(
            f'{path}: {table.named} headings stand over {width} columns, so that none is surely over its own; expected '
            f'one over each; {quotes}where the last columns are those without, ',
            *_HELP,
        )


def _first_time(columns: Sequence[Column]) -> str:
    return next((column.heading for column in columns if column.meaning.kind == 'time'), '')


def _by_name(part: Part) -> Iterator[Part]:
    """A table with a column that numbers or names the runs, one after the other; else as it is."""
    for column in part.columns:
        if column.meaning.kind != 'run' or not column.heading:
            continue
        names = list(dict.fromkeys(column.cells))
        changes = sum(a != b for a, b in pairwise(column.cells))
        if 1 < len(names) <= _MOST_RUNS and changes == len(names) - 1:
            for name in names:
                keep = [k for k, cell in enumerate(column.cells) if cell == name]
                yield _rows_of(part, keep[0], keep[-1] + 1, title=f'{column.heading} {name}')
            return
    yield part


def _rows_of(part: Part, first: int, last: int, title: str = '') -> Part:
    """The same columns, of some of the rows."""
    rows = part.table.rows[first:last]
    return Part(
        replace(part.table, rows=rows),
        tuple(replace(column, cells=column.cells[first:last]) for column in part.columns),
        replace(part.layout, first=rows[0].number, last=rows[-1].number),
        title or part.title,
    )


def _runs(part: Part, path: Path) -> Iterator[DraftRun]:
    """The runs of a part: cut where its time begins anew."""
    time = time_of(part.columns, part.table.preamble)
    if time is None:
        _refuse_disordered(part, path)
        raise BadInput(
            f'{path}: no time: none of the columns {_list(part.columns)} is one, and no sample rate is stated above; '
            f'add a column of times or a line such as "Sample rate: 20 Hz", or ',
            *_HELP,
        )
    if isinstance(time, float):
        yield _run(part, time, path)
        return
    part = _forwards(part, time)
    for first, last in _stretches(part, time, path):
        yield _run(part if last - first == len(part.table.rows) else _rows_of(part, first, last), time, path)


def _refuse_disordered(part: Part, path: Path) -> None:
    """BadInput where a column is called a time, and its numbers stand still or fall in too many rows for one."""
    for column in part.columns:
        change = np.diff(column.numbers)
        odd = np.flatnonzero(change <= 0.0)
        if column.meaning.kind != 'time' or not len(odd):
            continue
        still, first = int(np.count_nonzero(change == 0.0)), int(odd[0]) + 1
        stands = 2 * still >= len(odd)
        what = f'stands still in {still}' if stands else f'falls in {len(odd) - still}'
        mend = 'give it more digits' if stands else 'sort the rows'
        raise BadInput(
            f'{path}: the time {column.ref} {what} of {len(change) + 1} rows, first in row '
            f'{part.table.rows[first].number}: {column.numbers[first]:g} after {column.numbers[first - 1]:g}; '
            f'{mend}, or where rows come evenly, say dt_s (s from row to row) in a map (--map, see docs/recording.md)'
        )


def _forwards(part: Part, time: DraftTime) -> Part:
    """The rows from the oldest to the newest, where a logger writes the newest first."""
    at = times(part.columns, time)
    if not falls_throughout(at):
        return part
    return replace(
        part,
        table=replace(part.table, rows=part.table.rows[::-1]),
        columns=tuple(replace(column, cells=column.cells[::-1]) for column in part.columns),
    )


def _stretches(part: Part, time: DraftTime, path: Path) -> list[tuple[int, int]]:
    """Rows [first, last) through which the time goes on; it begins anew where it falls back to where it began."""
    at = times(part.columns, time)
    known = np.flatnonzero(np.isfinite(at))
    if not len(known):
        raise BadInput(f'{path}: {time.ref} has no time in it')
    value = at[known]
    step = float(np.median(np.abs(np.diff(value)))) if len(value) > 1 else 0.0
    cuts = [0]
    for k in np.flatnonzero(np.diff(value) < 0.0):
        start = value[np.searchsorted(known, cuts[-1])]
        if value[k + 1] > start + 5.0 * step:
            raise BadInput(
                f'{path}: row {part.table.rows[known[k + 1]].number}: the time runs backwards, {value[k + 1]:g} after '
                f'{value[k]:g}, but not to the start of another run; cut the file there'
            )
        cuts.append(int(known[k + 1]))
    ends = [*cuts[1:], len(at)]
    return [(a, b) for a, b in zip(cuts, ends, strict=True) if b - a > 1]


def _run(part: Part, time: DraftTime | float, path: Path) -> DraftRun:
    columns, left_out, notes = channels_of(part.columns, time, part.table.preamble, path)
    if not columns:
        raise BadInput(
            f'{path}: no column of a muscle: none of {_list(part.columns)} is a current, power, voltage, '
            f'temperature, resistance, displacement or force by its heading or unit; ',
            *_HELP,
        )
    used = {column.ref for column in columns}
    missing = sorted({text for column in part.columns if column.ref in used for text in _texts(column)})
    known: dict[str, object] = {'title': part.title} if part.title else {}
    stated, told = _stated_above(part, columns)
    known, notes = known | stated, [*notes, *_assumed(time), *told]
    if 'load_n' not in known and not {'load', 'force'} & {column.channel for column in columns}:
        notes.append(
            'no load is stated; where one hangs on the muscle, add to columns in the map: load: {value: 60, unit: g}'
        )
    layout = replace(part.layout, missing=tuple(missing))
    return DraftRun(part.title, layout, time, tuple(columns), known, tuple(left_out), tuple(notes))


def _assumed(time: DraftTime | float) -> list[str]:
    """What was taken for granted of the time."""
    return [time.note] if isinstance(time, DraftTime) and time.note else []


def _stated_above(part: Part, columns: Sequence[DraftColumn]) -> tuple[dict[str, object], list[str]]:
    """What the words above a table state that no column has, and what was made of it."""
    refs = {column.channel: column.ref for column in columns}
    force = next((column for column in part.columns if column.ref == refs.get('force')), None)
    load = (hanging_load if force is None else load_before)(part.table.preamble)
    room = room_temperature(part.table.preamble)
    known: dict[str, object] = {}
    notes = []
    if load is not None and 'load' not in refs:
        if force is not None and is_steady(force.numbers[np.isfinite(force.numbers)]):
            # A force that stays is that of what hangs, and was measured: one load is enough.
            notes.append(f'the load of {load:.6g} N that is written above is not taken: the force was measured')
        else:
            # A force that varies is that of an end that is held or on a spring: the load is what it started from.
            known['load_n'] = round(load, 6)
            start = '' if force is None else ' at the start'
            notes.append(f'a load of {known["load_n"]:g} N{start}, as is written above')
    if room is not None and 'ambient' not in refs:
        known['ambient_c'] = round(UNITS['degC'].from_si(room), 3)
        notes.append(f'a room of {known["ambient_c"]:g} degC, as is written above')
    return known, notes


def _texts(column: Column) -> Iterator[str]:
    """What stands in a column in place of a number."""
    yield from column.stand_ins
    for cell in column.cells:
        if cell.lower() not in NO_NUMBER and number(cell, column.decimal) is None:
            yield cell


def _list(columns: Sequence[Column]) -> str:
    return ', '.join(str(column.ref) for column in columns if column.heading)


def _named(runs: list[DraftRun], path: Path) -> list[DraftRun]:
    """Each run with the name of its bag: the file's, and where there are several, a title or a number."""
    stem = _slug(path.stem) or 'run'
    if len(runs) == 1:
        return [replace(runs[0], name=stem)]
    sheets = len({run.layout.sheet for run in runs}) == len(runs)
    titles = [_slug(run.layout.sheet if sheets else run.name) for run in runs]
    if not all(titles) or len(set(titles)) < len(titles):
        titles = [str(k) for k in range(1, len(runs) + 1)]
    return [replace(run, name=f'{stem}_{title}') for run, title in zip(runs, titles, strict=True)]


def _slug(text: str) -> str:
    """A text as part of a file's name."""
    return re.sub(r'[^\w.+-]+', '_', text).strip('_.')
