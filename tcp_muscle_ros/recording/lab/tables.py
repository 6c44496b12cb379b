"""Where the tables of numbers stand in a sheet: their headings above them, and what is written before."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tcp_muscle_ros.recording.lab.cells import is_value
from tcp_muscle_ros.recording.lab.grid import Grid, Row, joined_headings
from tcp_muscle_ros.recording.lab.unit_names import unit_named

_LEAST = 3  # rows of numbers that make a table
SHARE = 0.2  # of the longest, that another table of the sheet has
_MOST_HEADINGS = 3  # rows
_RULE = re.compile(r'[-=_–—+*~]{2,}')
_SAMPLE = 300  # rows, to tell what most rows are like


@dataclass(frozen=True)
class Table:
    """Rows of numbers below their headings.

    headings  one a column, '' where there is none; from several rows joined, without the row of units
    units     what stands in the row of units, one a column
    above     the numbers of the rows of headings
    titles    what stands above the headings, over the column where it begins: the names of runs side by side
    preamble  the rows before
    """

    sheet: str
    rows: tuple[Row, ...]
    headings: tuple[str, ...]
    units: tuple[str, ...]
    above: tuple[int, ...]
    titles: tuple[str, ...]
    preamble: tuple[Row, ...]

    @property
    def width(self) -> int:
        """How many columns it has."""
        return len(self.headings)

    def column(self, k: int) -> list[str]:
        """The cells of a column, '' where a row is shorter."""
        return [row.cells[k] if k < len(row.cells) else '' for row in self.rows]


def find_tables(grid: Grid) -> list[Table]:
    """The tables of a sheet, from above to below. One without headings of its own has those of the one before."""
    blocks = [block for block in _blocks(grid.rows) if block[1] - block[0] >= _LEAST]
    longest = max((last - first for first, last in blocks), default=0)
    found: list[Table] = []
    end = 0
    for first, last in blocks:
        if last - first < SHARE * longest:
            continue
        found.append(_table(grid, first, last, end, found[-1] if found else None))
        end = last
    return found


def _blocks(rows: Sequence[Row]) -> Iterator[tuple[int, int]]:
    """Stretches of rows of numbers, [first, last)."""
    columns = [_values(row) for row in rows]
    common = _common([found for found in columns if found])
    first = None
    for k, (row, found) in enumerate(zip(rows, columns, strict=True)):
        filled = sum(1 for cell in row.cells if cell)
        good = bool(found & common) and 2 * len(found) >= filled and (len(found) > 1 or len(common) == 1)
        if good and first is None:
            first = k
        elif not good and first is not None:
            yield first, k
            first = None
    if first is not None:
        yield first, len(rows)


def _values(row: Row) -> frozenset[int]:
    return frozenset(k for k, cell in enumerate(row.cells) if cell and is_value(cell))


def _common(columns: list[frozenset[int]]) -> frozenset[int]:
    """The columns in which most rows have numbers."""
    step = max(len(columns) // _SAMPLE, 1)
    some = columns[::step]
    counts = Counter(k for found in some for k in found)
    return frozenset(k for k, count in counts.items() if 2 * count >= len(some))


def _table(grid: Grid, first: int, last: int, end: int, before: Table | None) -> Table:
    rows = grid.rows[first:last]
    if len(rows) > _LEAST and len(rows[-1].cells) < min(len(row.cells) for row in rows[:-1]):
        rows = rows[:-1]  # torn, as where a logger was reset
    filled = frozenset(k for row in rows for k, cell in enumerate(row.cells) if cell)
    above = _headings(grid.rows[end:first], filled)
    width = max(len(row.cells) for row in (*rows, *above))
    if not above and before is not None and before.width == width:
        kept = (before.headings, before.units, before.above, before.titles, before.preamble)
        return Table(grid.sheet, rows, *kept)
    names = [row for row in above if not _is_units(row)] or list(above)
    units = [row for row in above if _is_units(row)]
    upper = grid.rows.index(above[0], end) if above else first
    titles = grid.rows[upper - 1].cells if above and upper > end else ()
    return Table(
        grid.sheet,
        rows,
        tuple(joined_headings(tuple(names), width)),
        tuple(joined_headings(tuple(units), width)),
        tuple(row.number for row in names),
        tuple((*titles, *[''] * width)[:width]) if len([title for title in titles if title]) > 1 else ('',) * width,
        grid.rows[end:upper],
    )


def _headings(rows: Sequence[Row], filled: frozenset[int]) -> tuple[Row, ...]:
    """The rows straight above a table that name most of its columns, at most three."""
    found: list[Row] = []
    for row in reversed(rows):
        if (row.blank and not found) or _is_ruled(row):
            continue
        named = frozenset(k for k, cell in enumerate(row.cells) if cell) & filled
        if len(found) == _MOST_HEADINGS or 5 * len(named) < 3 * len(filled) or _numbers(row, named) > 0.34 * len(named):
            break
        found.insert(0, row)
        if not _is_units(row) and not _names_more(rows, row, filled):
            break
    return tuple(found)


def _names_more(rows: Sequence[Row], row: Row, filled: frozenset[int]) -> bool:
    """Does the row above name the same columns too, in words (a scope's channel, then what it measures)?"""
    rows = [each for each in rows if not _is_ruled(each)]
    at = rows.index(row)
    above, named = (frozenset(k for k, cell in enumerate(each.cells) if cell) for each in (rows[max(at - 1, 0)], row))
    return at > 0 and filled <= above == named and not any(is_value(rows[at - 1].cells[k]) for k in filled)


def _is_ruled(row: Row) -> bool:
    """Is it a line drawn with signs between headings and numbers?"""
    return not row.blank and all(_RULE.fullmatch(cell) for cell in row.cells if cell)


def _numbers(row: Row, columns: frozenset[int]) -> int:
    return sum(is_value(row.cells[k]) and unit_named(row.cells[k]) is None for k in columns)


def _is_units(row: Row) -> bool:
    """Are most of its cells units, and none a longer word?"""
    filled = [cell for cell in row.cells if cell]
    return 2 * sum(unit_named(cell) is not None for cell in filled) > len(filled)
