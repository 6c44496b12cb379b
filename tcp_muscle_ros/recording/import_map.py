"""The import map: a YAML file that says what a lab's CSV files hold.

```yaml
time: {column: t, unit: s}         # or  dt_s: 0.2011  where the files have no time
columns:                           # output channels and what else was measured
  displacement: {column: 'Position (cm)', unit: cm, sign: -1, offset: first}
  load: {value: 40, unit: g}       # not a column: the same all the time
input:                             # one of current, power, voltage: from a column ...
  power: {column: 'Input Signal', scale: 3, unit: W}
input:                             # ... or from a schedule
  power: {unit: W, repeat: 3, schedule: [{duration_s: 10, value: 3}, {duration_s: 10, value: 0}]}
end: load                          # load | blocked | spring; kept in known
known: {rest_length_m: 0.205}      # whatever is known of a run
ignore: ['averages.csv']           # files that are no runs
groups:                            # what several runs share; a run may override any of it
  forced_air: {known: {air: forced}}
runs:                              # one bag for each file that matches
  - {file: 'rig/run_*.csv', group: forced_air, name: '{stem}'}
```

A column is its heading (``occurrence: 2`` where headings repeat) or its index, counted from 0. A number x becomes
``unit(sign * (scale * x + offset))``; ``offset: first`` makes the first sample zero. ``file`` matches the end of a
path, folder by folder. Headings and numbers in files are separated by ``delimiter`` (',').

What an odd file needs besides, as ``tcp_muscle import`` without a map writes it:

```yaml
table: {encoding: cp1252, delimiter: ';', decimal: ',', headings: [7], first: 8, last: 37}   # rows, counted from 1
table: {sheet: 'run 1', only: {trial: '2'}, missing: [OL]}    # of a spreadsheet; some rows; texts that are no number
table: {long: {time: _time, name: _field, value: _value}}     # one reading a row: a column for each name
time: {column: Uhrzeit, unit: clock, date: {column: Datum}, fraction: {column: ms, unit: ms}}
time: {column: Zeitstempel, unit: stamp, order: dmy}
time: {column: micros, unit: us, wraps: 4294967296}
columns: {force: {column: F, unit: N, time: {column: 't (2)', unit: s}}}  # a channel with a clock of its own
```
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path, PurePath

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.lab.grid import Layout
from tcp_muscle_ros.recording.protocol import ENDS
from tcp_muscle_ros.recording.recording import DRIVES, channel_kind
from tcp_muscle_ros.recording.units import UNITS, Unit, unit_of
from tcp_muscle_ros.recording.yaml_input import Section, load_yaml

_SHARED = ('time', 'dt_s', 'columns', 'input', 'end', 'known', 'delimiter', 'table')
_TABLE = ('encoding', 'delimiter', 'decimal', 'headings', 'first', 'last', 'sheet', 'only', 'missing', 'long')
_LONG = ('time', 'name', 'value')
_FIRST = 'first'
CLOCK, STAMP = 'clock', 'stamp'  # instead of a unit of time
ORDERS = ('dmy', 'mdy', 'ymd')


@dataclass(frozen=True)
class StampSource:
    """A column of times of day (``clock``), or of dates with them (``stamp``).

    date      the column of the dates, where they stand apart
    fraction  that of the fractions of a second
    """

    column: str | int
    occurrence: int | None
    kind: str
    order: str = 'dmy'
    date: 'ColumnSource | None' = None
    fraction: 'ColumnSource | None' = None


@dataclass(frozen=True)
class ColumnSource:
    """A column of a CSV file: SI value = unit(sign * (scale * x + offset)); offset None: the first sample is zero.

    time   the column of its own times, where they are not those of the run
    wraps  the count at which a counter begins anew; 0: never
    """

    column: str | int
    occurrence: int | None
    unit: Unit
    sign: float = 1.0
    scale: float = 1.0
    offset: float | None = 0.0
    time: 'ColumnSource | StampSource | None' = None
    wraps: float = 0.0


@dataclass(frozen=True)
class ConstantSource:
    """The same value throughout, SI."""

    value: float


@dataclass(frozen=True)
class ScheduleSource:
    """Steps of (duration s, value SI), repeated; the last value holds from then on."""

    steps: tuple[tuple[float, float], ...]


Source = ColumnSource | ConstantSource | ScheduleSource
TimeSource = ColumnSource | StampSource


@dataclass(frozen=True)
class Run:
    """One run of a map: which file it is in, and which channel is what there."""

    where: str
    file: str
    name: str
    time: TimeSource | float  # a column, or the period in s
    channels: Mapping[str, Source]
    layout: Layout = field(default_factory=Layout)
    known: Mapping[str, object] = field(default_factory=dict)

    def matches(self, path: PurePath) -> bool:
        """Does `file` match the end of `path`, folder by folder?"""
        pattern = PurePath(self.file).parts
        end = path.parts[-len(pattern) :]
        return len(end) == len(pattern) and all(map(fnmatchcase, end, pattern))


@dataclass(frozen=True)
class ImportMap:
    """All runs of a rig, and the files that are none."""

    path: str
    runs: tuple[Run, ...]
    ignore: tuple[str, ...] = ()

    def ignores(self, path: PurePath) -> bool:
        """Does the map say that this file is no run?"""
        return any(path.match(pattern) for pattern in self.ignore)


def read_import_map(path: str | Path) -> ImportMap:
    """An import map from its YAML file. BadInput names the key and the nearest valid one."""
    file = load_yaml(path).only(*_SHARED, 'ignore', 'groups', 'runs')
    groups = file.section('groups')
    shared = {name: Section(groups[name], f'{groups.where}: {name}').only(*_SHARED) for name in groups.names()}
    runs = []
    for entry in file.sections('runs'):
        entry.only(*_SHARED, 'file', 'name', 'group')
        layers = [file]
        group = entry.choice('group', shared) if 'group' in entry else ''
        if group:
            layers.append(shared[group])
        runs.append(_run(entry, group, [*layers, entry]))
    return ImportMap(str(path), tuple(runs), _ignored(file))


def _ignored(file: Section) -> tuple[str, ...]:
    patterns = file.content.get('ignore') or []
    if not isinstance(patterns, list):
        raise BadInput(f'{file.where}: ignore: expected a list of file patterns')
    for pattern in patterns:
        if not isinstance(pattern, str) or not PurePath(pattern).parts:
            raise BadInput(f"{file.where}: ignore: {pattern!r} is no file pattern, expected such as 'averages*.csv'")
    return tuple(patterns)


def _run(entry: Section, group: str, layers: list[Section]) -> Run:
    """A run, each key from its innermost layer (map, group, run); `columns` and `known` are joined."""
    section = _merged(entry, layers)
    time = _time_of(section)
    known = dict(section.section('known').content)
    if group:
        known.setdefault('group', group)
    if 'end' in section:
        known['end'] = section.choice('end', ENDS)
    channels: dict[str, Source] = {}
    columns = section.section('columns')
    for name in columns.names():
        kind = channel_kind(name, columns.where)
        channels[kind.name] = _source(columns, name, kind.unit)
    drives = section.section('input')
    drives.only(*DRIVES)
    for name in drives.names():
        channels[name] = _source(drives, name, channel_kind(name, drives.where).unit)
    if not channels:
        raise BadInput(f"{entry.where}: no channel: give 'columns' (and 'input')")
    name = entry.text('name', f'{group}_{{stem}}' if group else '{stem}')
    return Run(entry.where, entry.text('file'), name, time, channels, _layout(section), known)


def _merged(entry: Section, layers: list[Section]) -> Section:
    """What holds for a run, the innermost layer's word being the last."""
    merged: dict[str, object] = {}
    for layer in layers:
        for key in _SHARED:
            if key in layer:
                merged[key] = layer[key]
                if key == 'time':
                    merged.pop('dt_s', None)
                if key == 'dt_s' and 'time' not in layer:
                    merged.pop('time', None)
    for key in ('columns', 'known'):
        joined: dict[str, object] = {}
        for layer in layers:
            joined |= layer.section(key).content
        merged[key] = joined
    return Section(merged, entry.where)


def _time_of(section: Section) -> TimeSource | float:
    """The column of the times, or the period (s)."""
    if 'time' in section and 'dt_s' in section:
        raise BadInput(f'{section.where}: both time and dt_s are given, expected one')
    if 'time' not in section and 'dt_s' not in section:
        raise BadInput(f"{section.where}: neither 'time' (a column) nor 'dt_s' (a period) is given")
    return _time(section.section('time')) if 'time' in section else section.number('dt_s', above=0.0)


def _layout(section: Section) -> Layout:
    """Where the table stands in its file: `table`, and the older `delimiter` beside it."""
    table = section.section('table').only(*_TABLE)
    headings, missing = table.content.get('headings'), table.content.get('missing') or []
    if headings is not None and not (isinstance(headings, list) and all(isinstance(row, int) for row in headings)):
        raise BadInput(f'{table.where}: headings is {headings!r}, expected a list of row numbers, as [7]')
    if not isinstance(missing, list):
        raise BadInput(f'{table.where}: missing is {missing!r}, expected a list of texts')
    only = table.section('only')
    return Layout(
        table.text('encoding', 'utf-8-sig'),
        table.text('delimiter', section.text('delimiter', ',')),
        table.choice('decimal', ('.', ','), '.'),
        None if headings is None else tuple(headings),
        table.count('first', 1) if 'first' in table else None,
        table.count('last', 1) if 'last' in table else None,
        table.text('sheet', ''),
        {name: only.text(name) for name in only.names()},
        tuple(map(str, missing)),
        _long(table),
    )


def _long(table: Section) -> tuple[str, str, str] | None:
    """The columns of a table with one reading a row."""
    if 'long' not in table:
        return None
    entry = table.section('long').only(*_LONG)
    return entry.text('time'), entry.text('name'), entry.text('value')


def _time(entry: Section) -> TimeSource:
    """A column of times: counted in a unit, or written as a clock or with its date."""
    if entry.text('unit', 's') not in (CLOCK, STAMP):
        return _column(entry, 's', 'time')
    entry.only('column', 'occurrence', 'unit', 'order', 'date', 'fraction')
    return StampSource(
        _reference(entry),
        entry.count('occurrence', 1) if 'occurrence' in entry else None,
        entry.text('unit'),
        entry.choice('order', ORDERS, 'dmy'),
        _plain(entry.section('date')) if 'date' in entry else None,
        _column(entry.section('fraction'), 's', 'time') if 'fraction' in entry else None,
    )


def _plain(entry: Section) -> ColumnSource:
    """A column that is no number: of dates."""
    entry.only('column', 'occurrence')
    return ColumnSource(_reference(entry), entry.count('occurrence', 1) if 'occurrence' in entry else None, UNITS['s'])


def _reference(entry: Section) -> str | int:
    """A column by its heading or its index."""
    entry.require('column')
    column = entry['column']
    if isinstance(column, bool) or not isinstance(column, (str, int)) or (isinstance(column, int) and column < 0):
        raise BadInput(f'{entry.where}: column is {column!r}, expected a heading or an index counted from 0')
    return column


def _source(parent: Section, name: str, default_unit: str) -> Source:
    """A channel's entry: a column, a constant or a schedule."""
    entry = Section(parent[name], f'{parent.where}: {name}')
    if 'value' in entry:
        entry.only('value', 'unit')
        unit = _unit(entry, default_unit)
        return ConstantSource(unit.to_si(entry.number('value')))
    if 'schedule' in entry:
        entry.only('schedule', 'repeat', 'unit')
        unit = _unit(entry, default_unit)
        steps = []
        for step in entry.sections('schedule'):
            step.only('duration_s', 'value')
            steps.append((step.number('duration_s', above=0.0), unit.to_si(step.number('value'))))
        return ScheduleSource(tuple(steps) * entry.count('repeat', 1))
    return _column(entry, default_unit, name)


def _column(entry: Section, default_unit: str, name: str) -> ColumnSource:
    entry.only(
        'column',
        'occurrence',
        'unit',
        'sign',
        'scale',
        'offset',
        *(('wraps',) if name == 'time' else ('time', 'value', 'schedule')),
    )
    column = _reference(entry)
    sign = entry.number('sign', 1.0)
    if sign not in (1.0, -1.0):
        raise BadInput(f'{entry.where}: sign is {sign:g}, expected 1 or -1')
    from_first = 'offset' in entry and entry['offset'] == _FIRST
    return ColumnSource(
        column,
        entry.count('occurrence', 1) if 'occurrence' in entry else None,
        _unit(entry, default_unit),
        sign,
        entry.number('scale', 1.0),
        None if from_first else entry.number('offset', 0.0),
        _time(entry.section('time')) if 'time' in entry else None,
        entry.number('wraps', 0.0, least=0.0),
    )


def _unit(entry: Section, default: str) -> Unit:
    return unit_of(entry.text('unit', default), UNITS[default].quantity, entry.where)
