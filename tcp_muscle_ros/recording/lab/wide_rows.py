"""Rows of a text file that have more cells than headings stand above them."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from tcp_muscle_ros.recording.lab.cells import is_time, is_value, number
from tcp_muscle_ros.recording.lab.grid import Row

_MANY = 0.2  # of the rows of a table
_MOST = 0.9
_SIZES = 10.0  # times as large or as small as any number of its column, from which on one does not go with it
_SECONDS = re.compile(r'(?:.*[T ])?\d{1,2}:\d{2}:\d{2}')
_FRACTION = re.compile(r'\d{3}|\d{6}')
_THOUSANDS = re.compile(r'[+-]?[1-9]\d{0,2}')
_GROUP = re.compile(r'\d{3}(\.\d*)?')


@dataclass(frozen=True)
class _Usual:
    """The smallest and the largest size of a column's numbers (any, where it has none but zeros), and how many digits
    these have behind the decimal point."""

    low: float
    high: float
    places: frozenset[int]

    def odd(self, cell: str) -> int:
        """In how many ways a cell's number is unlike them."""
        value = number(cell)
        if value is None or not self.places:
            return 0
        of_size = self.low <= _SIZES * abs(value) <= _SIZES**2 * self.high
        return (not of_size) + (_places(cell) not in self.places)


def whole_rows(rows: Sequence[Row], named: int, delimiter: str) -> tuple[tuple[Row, ...], tuple[int, ...]]:
    """The rows with each cell below its heading, of which there are ``named``, and the numbers of those left out.

    A comma within a number makes two cells of it where commas separate the cells: these are joined again where the row
    then goes with the others. Single rows with another number too many are left out. A table most of whose rows have
    one stays as it is.
    """
    found = tuple(rows)
    if delimiter == ',':
        found = _with_fractions(found, named)
    wide: dict[int, Row | None] = {row.number: None for row in found if _is_wide(row, named)}
    if wide and delimiter == ',':
        usual = _usual([row for row in found if row.number not in wide], named)
        wide = {row.number: _with_groups(row, named, usual) for row in found if row.number in wide}
    left_out = tuple(number for number, row in wide.items() if row is None)
    if len(found) - len(wide) < _MANY * len(found) or len(left_out) >= _MANY * len(found):
        return found, ()
    mended = [wide.get(row.number, row) for row in found]
    return tuple(row for row in mended if row is not None), left_out


def too_many(rows: Sequence[Row], named: int) -> int:
    """How many cells with numbers many rows have, where these are more than the headings; 0 else."""
    widths = [_width(row) for row in rows if _is_wide(row, named)]
    return max(widths, key=widths.count) if len(widths) >= max(_MANY * len(rows), 1) else 0


def with_thousands(rows: Sequence[Row], named: int) -> str:
    """A number, as 1,250.5, of whose like a comma may have made two cells in most rows that have too many; else ''."""
    wide = [row for row in rows if _is_wide(row, named)]
    usual = _usual([row for row in rows if not _is_wide(row, named)], named)
    parted = [row for row in wide if _with_groups(row, named, usual) is not None]
    if 2 * len(parted) <= len(wide):
        return ''
    first = _groups(parted[0], named)[0]
    return ','.join(parted[0].cells[first : first + 2])


def _is_wide(row: Row, named: int) -> bool:
    return 0 < named < len(row.cells) and _width(row) > named


def _width(row: Row) -> int:
    """How many cells there are up to the last with a number. Words beyond the headings are a remark."""
    return next((k + 1 for k in range(len(row.cells) - 1, -1, -1) if is_value(row.cells[k])), 0)


def _with_fractions(rows: tuple[Row, ...], named: int) -> tuple[Row, ...]:
    """The rows with times as 14:00:03,250 (as Python logs them) in one cell, where a heading is missing for two."""
    if 2 * sum(_is_wide(row, named) for row in rows) <= len(rows):
        return rows
    for k in range(named):
        parted = {row.number for row in rows if k + 1 < len(row.cells) and _is_fraction(*row.cells[k : k + 2])}
        if len(parted) > _MOST * len(rows):
            return tuple(_joined(row, [k], ',') if row.number in parted else row for row in rows)
    return rows


def _is_fraction(time: str, cell: str) -> bool:
    return bool(_FRACTION.fullmatch(cell) and _SECONDS.fullmatch(time)) and is_time(time)


def _with_groups(row: Row, named: int, usual: Sequence[_Usual]) -> Row | None:
    """The row with numbers as 1,250.5 in one cell; None where as many as are too many may not be joined in one way, or
    where it goes better with the others as it is: 60,250 may be two numbers, and the one too many stand at its end."""
    at = _groups(row, named)
    joined = _joined(row, at, '')
    return joined if at and _odd(joined, usual) <= _odd(row, usual) else None


def _groups(row: Row, named: int) -> list[int]:
    """Which cells may be thousands with the next one; none where those are not as many as are too many."""
    cells = row.cells[: _width(row)]
    at = [k for k in range(len(cells) - 1) if _THOUSANDS.fullmatch(cells[k]) and _GROUP.fullmatch(cells[k + 1])]
    return at if len(at) == len(cells) - named and not any(k + 1 in at for k in at) else []


def _usual(rows: Sequence[Row], named: int) -> list[_Usual]:
    """What the numbers of each column are like in some rows."""
    found = []
    for k in range(named):
        cells = [row.cells[k] for row in rows if k < len(row.cells) and number(row.cells[k]) is not None]
        sizes = [abs(number(cell) or 0.0) for cell in cells]
        low, high = (min(sizes), max(sizes)) if any(sizes) else (0.0, math.inf)
        found.append(_Usual(low, high, frozenset(map(_places, cells))))
    return found


def _places(cell: str) -> int:
    """The digits behind the decimal point."""
    return len(cell.partition('.')[2])


def _odd(row: Row, usual: Sequence[_Usual]) -> int:
    """In how many ways its numbers do not go with their columns."""
    return sum(each.odd(cell) for each, cell in zip(usual, row.cells, strict=False))


def _joined(row: Row, at: Sequence[int], between: str) -> Row:
    """The row with each cell ``at`` and the one after it in one."""
    cells = list(row.cells)
    for k in reversed(at):
        cells[k : k + 2] = [f'{cells[k]}{between}{cells[k + 1]}']
    return Row(row.number, tuple(cells))
