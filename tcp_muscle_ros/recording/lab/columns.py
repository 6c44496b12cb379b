"""The columns of a table with what their headings mean."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tcp_muscle_ros.recording.lab.cells import decimal_of, number, unit_in
from tcp_muscle_ros.recording.lab.draft import ColumnRef
from tcp_muscle_ros.recording.lab.grid import Layout, Row
from tcp_muscle_ros.recording.lab.headings import Meaning, meaning
from tcp_muscle_ros.recording.lab.stand_ins import stand_ins
from tcp_muscle_ros.recording.lab.tables import Table
from tcp_muscle_ros.recording.lab.unit_names import unit_named
from tcp_muscle_ros.recording.recording import Array

_NUMBERED = re.compile(r'([^\W\d_]+)(\d+)')  # CH1, ROI2


@dataclass(frozen=True)
class Column:
    """One column: where it is, what stands above it, its cells, and the decimal mark of its numbers."""

    index: int
    heading: str
    ref: ColumnRef
    meaning: Meaning
    cells: tuple[str, ...]
    decimal: str = '.'

    @cached_property
    def numbers(self) -> Array:
        """Its numbers as float64[rows], NaN where a cell is none."""
        found = [number(cell, self.decimal) for cell in self.cells]
        return np.array([np.nan if each is None else each for each in found], dtype=np.float64)

    @cached_property
    def stand_ins(self) -> frozenset[str]:
        """The texts of the numbers in it that stand for none."""
        return stand_ins(self.cells, self.decimal, self.meaning.kind)


def columns_of(table: Table, layout: Layout) -> list[Column]:
    """The columns of a table. What a scope writes to the left of its samples counts as headings."""
    scope = _scope(table)
    seen: Counter[str] = Counter()
    repeats = Counter(heading for heading in table.headings if heading)
    found = []
    for k, heading in enumerate(table.headings):
        seen[heading] += 1
        by_index = not heading or k in scope
        ref = ColumnRef(k) if by_index else ColumnRef(heading, seen[heading] if repeats[heading] > 1 else None)
        shown = scope.get(k, heading)
        cells = tuple(table.column(k))
        unit = table.units[k] or _unit_row(table, k) or _unit_column(table, k) or _unit_of(cells)
        means = meaning(shown, _more(table, shown), unit)
        found.append(Column(k, shown, ref, means, cells, decimal_of(cells, layout.decimal)))
    return found


def _more(table: Table, heading: str) -> str:
    """What stands above of a column: 'CH1,糸温度,TEMP' in a table of channels, or 'ROI 1 (coil)' in words."""
    rows = [row for row in table.preamble if heading and row.cells and row.cells[0] == heading]
    if rows:
        return ' '.join(rows[-1].cells[1:3])
    numbered = _NUMBERED.match(heading)
    if numbered is None:
        return ''
    named = re.compile(rf'\b{numbered[1]}[ _#]?{numbered[2]}\s*[(:=]\s*(\w[\w ]*)')
    found = [match[1] for row in table.preamble if (match := named.search(' '.join(row.cells)))]
    return found[-1] if found else ''


def _unit_row(table: Table, k: int) -> str:
    """The unit that a row above states for the column: LabVIEW's Y_Unit_Label."""
    for row in reversed(table.preamble):
        if row.cells and 'unit' in row.cells[0].lower() and k < len(row.cells) and k > 0 and unit_named(row.cells[k]):
            return row.cells[k]
    return ''


def _unit_column(table: Table, k: int) -> str:
    """The unit that stands in each row, in the column after."""
    if k + 1 >= table.width or meaning(table.headings[k + 1]).kind != 'unit':
        return ''
    texts = set(table.column(k + 1)) - {''}
    only = texts.pop() if len(texts) == 1 else ''
    return only if unit_named(only) else ''


def _unit_of(cells: Sequence[str]) -> str:
    """The unit that follows each of the numbers straight away, as in 23.03C."""
    units = {unit_in(cell) for cell in cells if number(cell) is not None or number(cell, ',') is not None}
    return (units.pop() or '') if len(units) == 1 else ''


def _scope(table: Table) -> dict[int, str]:
    """A Tektronix scope's file: settings stand left of the samples in the same rows; time and signal come last."""
    settings = {row.cells[0]: row.cells[1] for row in table.rows if len(row.cells) > 3 and row.cells[0]}
    if 'Vertical Units' not in settings or 'Horizontal Units' not in settings:
        return {}
    filled = [k for k in range(table.width) if all(_cell(row, k) for row in table.rows)]
    if len(filled) < 2:
        return {}
    at, signal = filled[-2:]
    return {
        at: f'Time [{settings["Horizontal Units"]}]',
        signal: f'{settings.get("Source", "CH")} [{settings["Vertical Units"]}]',
    }


def _cell(row: Row, k: int) -> str:
    return row.cells[k] if k < len(row.cells) else ''
