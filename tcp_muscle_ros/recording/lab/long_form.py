"""Tables with one reading a row, as databases and brokers write them: time, what was read, its value.

They become tables with a column for each name, sorted by time.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.lab.cells import is_value, number, stamp
from tcp_muscle_ros.recording.lab.grid import Grid, Row
from tcp_muscle_ros.recording.lab.headings import meaning

NAMES = frozenset(
    ['_field', 'field', 'variable', 'channel', 'sensor', 'signal', 'topic', 'name', 'metric', 'quantity', 'kanal']
)
VALUES = frozenset(['_value', 'value', 'wert', 'valeur', 'valor', 'reading', 'messwert', 'val'])
_ABOVE = 200  # rows, among which the headings are
_MOST = 30  # names
_FEWEST = 3  # readings of each
_SELDOM = 0.1  # of the readings, that may come in the same second as another by chance


@dataclass(frozen=True)
class LongForm:
    """The columns of a long table, by their headings."""

    time: str
    name: str
    value: str


def long_form_of(grid: Grid) -> LongForm | None:
    """The columns, where a sheet is a long table whose names are of channels; None where it is not."""
    for k, row in enumerate(grid.rows[:_ABOVE]):
        lower = [cell.lower() for cell in row.cells]
        name, value = (next((at for at, cell in enumerate(lower) if cell in known), None) for known in (NAMES, VALUES))
        if name is None or value is None:
            continue
        below = [each for each in grid.rows[k + 1 :] if len(each.cells) == len(row.cells)]
        counts = Counter(each.cells[name] for each in below if each.cells[name])
        named = len(counts) > 1 and not any(map(is_value, counts)) and min(counts.values()) >= _FEWEST
        times = [at for at, cell in enumerate(row.cells) if _varies(cell, (each.cells[at] for each in below))]
        if named and len(counts) <= _MOST and times and sum(bool(meaning(text).kind) for text in counts) > 1:
            return LongForm(row.cells[times[0]], row.cells[name], row.cells[value])
    return None


def _varies(heading: str, cells: Iterable[str]) -> bool:
    """Is it a column of times, and not the same one in each row?"""
    return meaning(heading).kind == 'time' and len(set(cells)) > 1


def wide(grid: Grid, form: LongForm, path: Path) -> Grid:
    """A long table as one with a column for each name. Its headings are row 0, which the file does not have.

    Of readings of one name that have the same time and differ, the last counts. BadInput: there are many such of what
    may be a channel; of a state nobody asks.
    """
    heads = next(row for row in grid.rows if {form.time, form.name, form.value} <= set(row.cells))
    at, name, value = (heads.cells.index(heading) for heading in (form.time, form.name, form.value))
    below = [row for row in grid.rows if row.number > heads.number and len(row.cells) == len(heads.cells)]
    names = list(dict.fromkeys(row.cells[name] for row in below))
    named = {each for each in names if meaning(each).kind}
    found: dict[str, dict[str, Row]] = {}
    twice: list[tuple[Row, Row]] = []
    for row in below:
        of_time = found.setdefault(row.cells[at], {})
        before = of_time.setdefault(row.cells[name], row)
        if before.cells[value] != row.cells[value]:
            of_time[row.cells[name]] = row
            if row.cells[name] in named and _reading(before.cells[value]) != _reading(row.cells[value]):
                twice.append((before, row))
    if len(twice) > _SELDOM * len(below):
        raise BadInput(f'{path}: {_clash(*twice[0], heads, (at, name, value))}')
    rows = [
        Row(k, (time, *(found[time][each].cells[value] if each in found[time] else '' for each in names)))
        for k, time in enumerate(_sorted(list(found)), heads.number + 1)
    ]
    note = f'{len(twice)} reading(s) are left out, for a later one of the same name has the same time'
    notes = (*grid.notes, note) if twice else grid.notes
    return replace(grid, rows=(Row(0, (form.time, *names)), *rows), notes=notes)


def _reading(cell: str) -> tuple[float | None, float | None]:
    """The number that a cell has with a decimal point, and with a comma: 23.0 and 23.00 are one reading."""
    return number(cell), number(cell, ',')


def _clash(one: Row, other: Row, heads: Row, used: tuple[int, int, int]) -> str:
    """What is wrong with two readings of one name that have the same time, and how to mend it."""
    at, name, value = used
    differ = [k for k, cell in enumerate(heads.cells) if k not in used and cell and one.cells[k] != other.cells[k]]
    apart = ', '.join(f"'{heads.cells[k]}' ({one.cells[k]}, {other.cells[k]})" for k in differ)
    mend = f'they differ in {apart}: keep one of these, or give' if apart else 'give'
    return (
        f"rows {one.number} and {other.number} both read '{one.cells[name]}' at '{one.cells[at]}', "
        f'{one.cells[value]} and {other.cells[value]}; {mend} the times more digits'
    )


def _sorted(times: Sequence[str]) -> list[str]:
    """Times in their order, where they are numbers or stamps."""
    for read in (number, lambda cell: stamp(cell, 'dmy')):
        values = {cell: value for cell in times if (value := read(cell)) is not None}
        if len(values) == len(times):
            return sorted(times, key=values.__getitem__)
    return list(times)
