"""A draft as the text of an import map, with comments: what a person reads and mends."""

import glob
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import yaml

from tcp_muscle_ros.files.tails import tail_of
from tcp_muscle_ros.files.yaml_text import quoted
from tcp_muscle_ros.recording.lab.draft import ColumnRef, DraftColumn, DraftRun, DraftTime
from tcp_muscle_ros.recording.lab.grid import Layout
from tcp_muscle_ros.recording.recording import DRIVES

_HEADER = """\
# What was understood of {files}. If it is wrong, change it here and import again:
#
#   tcp_muscle import FILE... --map {map} --output NEW_DIR
#
# A number x of a column becomes unit(sign * (scale * x + offset)); units and keys: docs/recording.md.
"""


def map_text(drafts: Mapping[Path, Sequence[DraftRun]], path: Path) -> str:
    """The map that imports these runs; ``path`` is where it will be."""
    lines = [_HEADER.format(files=', '.join(file.name for file in drafts), map=path), 'runs:']
    for file, runs in drafts.items():
        for run in runs:
            lines += _run('/'.join(_tail(file, drafts)), run)
    return '\n'.join(lines) + '\n'


def _tail(file: Path, files: Iterable[Path]) -> tuple[str, ...]:
    """The end of a file's path that no other of the files has, wherever the paths begin."""
    return tail_of(file.absolute(), [other.absolute() for other in files])


def told_apart(drafts: Mapping[Path, Sequence[DraftRun]]) -> dict[Path, list[DraftRun]]:
    """The runs of several files; those of one name with their folders before it, or the kind of file after it."""
    count = Counter(run.name for runs in drafts.values() for run in runs)
    found: dict[Path, list[DraftRun]] = {}
    for file, runs in drafts.items():
        folders = _tail(file, drafts)[:-1]
        ends = [file.suffix[1:]] if not folders and file.suffix else []
        found[file] = [
            replace(run, name='_'.join([*folders, run.name, *ends])) if count[run.name] > 1 else run for run in runs
        ]
    return found


def _run(file: str, run: DraftRun) -> Iterator[str]:
    yield f'- file: {quoted(glob.escape(file))}'
    yield f'  name: {quoted(run.name.replace("{", "{{").replace("}", "}}"))}'
    yield f'  table: {_flow(_layout(run.layout))}'
    if isinstance(run.time, float):
        yield f'  dt_s: {run.time!r}  # as is written above the table'
    else:
        yield f'  time: {_flow(_time(run.time))}'
    outputs = [column for column in run.columns if column.channel not in DRIVES]
    drives = [column for column in run.columns if column.channel in DRIVES]
    for key, columns in (('columns', outputs), ('input', drives)):
        if columns:
            yield f'  {key}:'
            yield from (f'    {column.channel}: {_flow(_column(column))}' for column in columns)
    if run.known:
        yield f'  known: {_flow(run.known)}'
    yield from (f'  # {note}' for note in run.notes)
    if run.left_out:
        yield f'  # left out: {", ".join(" ".join(name.split()) for name in run.left_out)}'


def _layout(layout: Layout) -> dict[str, object]:
    """What is not as in a plain CSV, and always where the table stands."""
    usual = Layout()
    found: dict[str, object] = {}
    for key in ('encoding', 'delimiter', 'decimal', 'sheet'):
        if getattr(layout, key) != getattr(usual, key):
            found[key] = getattr(layout, key)
    found |= {'headings': list(layout.headings or ()), 'first': layout.first, 'last': layout.last}
    if layout.long:
        found['long'] = dict(zip(('time', 'name', 'value'), layout.long, strict=True))
    if layout.missing:
        found['missing'] = list(layout.missing)
    return found


def _reference(ref: ColumnRef) -> dict[str, object]:
    found: dict[str, object] = {'column': ref.column}
    return found | ({'occurrence': ref.occurrence} if ref.occurrence is not None else {})


def _time(time: DraftTime) -> dict[str, object]:
    found = {**_reference(time.ref), 'unit': time.unit}
    if time.unit in ('clock', 'stamp') and (time.date or time.unit == 'stamp'):
        found['order'] = time.order  # of a date that does not begin with the year
    if time.date is not None:
        found['date'] = _reference(time.date)
    if time.fraction is not None:
        found['fraction'] = {**_reference(time.fraction), 'unit': time.fraction_unit}
    if time.wraps:
        found['wraps'] = int(time.wraps)
    return found


def _column(column: DraftColumn) -> dict[str, object]:
    found = {**_reference(column.ref), 'unit': column.unit}
    if column.sign < 0:
        found['sign'] = -1
    if column.scale != 1.0:
        found['scale'] = column.scale
    if column.from_first:
        found['offset'] = 'first'
    if column.time is not None:
        found['time'] = _time(column.time)
    return found


def _flow(value: object) -> str:
    """YAML on one line; every text that is no plain word in double quotes."""
    if isinstance(value, Mapping):
        return '{' + ', '.join(f'{key}: {_flow(each)}' for key, each in value.items()) + '}'
    if isinstance(value, list):
        return '[' + ', '.join(map(_flow, value)) + ']'
    if isinstance(value, str) and value.isidentifier() and value.isascii() and yaml.safe_load(value) == value:
        return value  # no `on`, which is true
    return quoted(value) if isinstance(value, str) else json.dumps(value)
