"""Any lab file as sheets of cells: how it is encoded and separated is told from its content, or given."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path

import numpy as np

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.recording.lab.binary_file import is_binary, read_sheets
from tcp_muscle_ros.recording.lab.cells import decimal_in, number
from tcp_muscle_ros.recording.lab.grid import Grid, Layout
from tcp_muscle_ros.recording.lab.headings import meaning
from tcp_muscle_ros.recording.lab.long_form import LongForm, long_form_of, wide
from tcp_muscle_ros.recording.lab.text_file import encoding_of, read_grid, read_lines, separator_of
from tcp_muscle_ros.recording.lab.unit_names import unit_named
from tcp_muscle_ros.recording.plausibility import USUAL, outside
from tcp_muscle_ros.recording.units import UNITS

_SOME = 0.2  # of the cells of a column, that are more than what stands above its table


@dataclass(frozen=True)
class LabSheet:
    """A sheet, and the layout so far: encoding, delimiter, decimal sign, sheet."""

    grid: Grid
    layout: Layout


def sheets_of(path: Path) -> list[LabSheet]:
    """What is in a file, its encoding, delimiter and decimal sign as its content tells."""
    if is_binary(path):
        return [LabSheet(grid, with_decimal(Layout(sheet=grid.sheet), grid)) for grid in read_sheets(path)]
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise BadInput(f'{path}: cannot be read ({error.strerror})') from None
    encoding = encoding_of(raw, path)
    separator = separator_of(read_lines(path, encoding))
    grid = read_grid(path, encoding, separator)
    layout = Layout(encoding, separator, _decimal(grid, separator))
    form = long_form_of(grid)
    if form is None:
        return [LabSheet(grid, layout)]
    return [LabSheet(wide(grid, form, path), replace(layout, long=(form.time, form.name, form.value)))]


def grid_of(path: Path, layout: Layout) -> Grid:
    """The sheet that a layout means."""
    if not is_binary(path):
        grid = read_grid(path, layout.encoding, layout.delimiter)
        if layout.long is None:
            return grid
        if not any(set(layout.long) <= set(row.cells) for row in grid.rows):
            raise BadInput(f'{path}: no row of headings with {", ".join(layout.long)}, as its map says (table: long)')
        return wide(grid, LongForm(*layout.long), path)
    grids = read_sheets(path)
    if not layout.sheet and grids:
        return grids[0]
    for grid in grids:
        if grid.sheet == layout.sheet:
            return grid
    raise BadInput(f"{path}: no sheet '{layout.sheet}'{nearest(layout.sheet, [grid.sheet for grid in grids])}")


def with_decimal(layout: Layout, grid: Grid) -> Layout:
    """The layout with the decimal sign that the cells of a grid have."""
    return replace(layout, decimal=_decimal(grid, layout.delimiter))


def _decimal(grid: Grid, separator: str) -> str:
    """A comma where that of a column is one; columns with points may stand beside it.

    Where commas separate no cells, 1,234 has a decimal one too, unless what stands beside it tells otherwise: points
    in other columns, or in its own such numbers as have none. That does not count where thousands are beyond every
    muscle: 23,125 degC.
    """
    columns = list(zip_longest(*(row.cells for row in grid.rows), fillvalue=''))
    shown = [Counter(map(decimal_in, column)) for column in columns]
    if any(counts[','] > counts['.'] for counts in shown):
        return ','
    points = any(counts['.'] > _SOME * _filled(column) for column, counts in zip(columns, shown, strict=True))
    if separator != ',' and not points and any(map(_may_have_commas, columns)):
        return ','
    return ',' if any(map(_has_no_thousands, columns)) else '.'


def _may_have_commas(column: Sequence[str]) -> bool:
    """Have its numbers commas that may be decimal ones, and few of them, but for zeros, no mark at all?"""
    numbers = [cell for cell in column if number(cell, ',')]
    bare = sum(',' not in cell and '.' not in cell for cell in numbers)
    return any(',' in cell for cell in numbers) and bare <= _SOME * len(numbers)


def _has_no_thousands(column: Sequence[str]) -> bool:
    """Is it of a channel, in a unit, in which its numbers are no muscle's with thousands, and usual with decimals?"""
    parted = [cell for cell in column if ',' in cell and number(cell) and number(cell, ',')]
    first = column.index(parted[0]) if parted else 0
    if not parted or '.' in map(decimal_in, column[first:]):
        return False
    above = [cell for cell in column[:first] if cell and number(cell) is None]
    heading, unit = above[-2:] if len(above) > 1 and unit_named(above[-1]) else (*above[-1:], '', '')[:2]
    means = meaning(heading, unit_cell=unit)
    if means.unit is None or means.kind not in USUAL:
        return False
    point, comma = (UNITS[means.unit].to_si(np.array([number(cell, mark) for cell in parted])) for mark in '.,')
    low, high = USUAL[means.kind]
    return len(outside(means.kind, point)) > 0 and low <= float(np.max(np.abs(comma))) <= high


def _filled(column: Sequence[str]) -> int:
    return sum(map(bool, column))
