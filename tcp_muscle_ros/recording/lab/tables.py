"""Where the tables of numbers stand in a sheet: their headings above them, and what is written before."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from tcp_muscle_ros.recording.lab.cells import clock, is_none, is_value, number, stamp
from tcp_muscle_ros.recording.lab.grid import Grid, Row, count_named, joined_headings
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
    named     how many cells the rows of headings have, be some of them empty
    """

    sheet: str
    rows: tuple[Row, ...]
    headings: tuple[str, ...]
    units: tuple[str, ...]
    above: tuple[int, ...]
    titles: tuple[str, ...]
    preamble: tuple[Row, ...]
    named: int

    @property
    def width(self) -> int:
        """How many columns it has."""
        return len(self.headings)

    def column(self, k: int) -> list[str]:
        """The cells of a column, '' where a row is shorter."""
        return [row.cells[k] if k < len(row.cells) else '' for row in self.rows]


def find_tables(grid: Grid) -> list[Table]:
    """The tables of a sheet, from above to below. One without headings of its own has those of the one before.

    Short ones are among them; one with headings of its own counts among what is written above the next.
    """
    blocks = [block for block in _blocks(grid.rows) if block[1] - block[0] >= _LEAST]
    longest = max((last - first for first, last in blocks), default=0)
    found: list[Table] = []
    before: Table | None = None
    end = 0
    for first, last in blocks:
        found.append(_table(grid, first, last, end, before))
        is_rest = before is not None and found[-1].above == before.above
        if is_rest or last - first >= SHARE * longest:
            before, end = found[-1], last
    return found


def _blocks(rows: Sequence[Row]) -> Iterator[tuple[int, int]]:
    """Stretches of rows of numbers, [first, last), with the gaps in them and before them."""
    columns = [_values(row) for row in rows]
    common = _common([found for found in columns if found])
    full = [_is_full(row, found, common) for row, found in zip(rows, columns, strict=True)]
    of_table = [good or _is_gap(rows, k, columns[k], common) for k, good in enumerate(full)]
    for inside, stretch in groupby(range(len(rows)), key=of_table.__getitem__):
        within = list(stretch)
        if inside and any(full[k] for k in within):
            yield within[0], max(k for k in within if full[k] or len(columns[k]) > 1) + 1


def _is_full(row: Row, found: frozenset[int], common: frozenset[int]) -> bool:
    """Are most of its cells numbers, but for those that say that there is none?"""
    filled = sum(1 for cell in row.cells if not is_none(cell))
    return bool(found & common) and 2 * len(found) >= filled and (len(found) > 1 or len(common) == 1)


def _is_gap(rows: Sequence[Row], k: int, found: frozenset[int], common: frozenset[int]) -> bool:
    """Is it a row of a table with its first column, the time, and little else: with nothing, or one word, as ERR, in
    place of numbers?

    A line of a program has several words, or leaves columns empty. A number alone must follow that of the row before.
    """
    cells, lead = rows[k].cells, min(common, default=0)
    beside = [rows[j].cells if 0 <= j < len(rows) else () for j in (k - 1, k + 1)]
    if lead not in found or len(cells) not in map(len, beside):
        return False
    words = [cell for j, cell in enumerate(cells) if j not in found and not is_none(cell)]
    if words:
        named = len(words) == 1 and re.search(r'\d', words[0]) is not None  # Run 2
        return len(set(words)) == 1 and not named and all(cells[j] for j in common if j < len(cells))
    if any(cell for j, cell in enumerate(cells) if j not in found):
        return True
    before, after = (other[lead] if lead < len(other) else '' for other in beside)
    return _is_between(before if is_value(before) else cells[lead], cells[lead], after)


def _is_between(before: str, cell: str, after: str) -> bool:
    """Does a number or a time follow one and precede the other?"""
    for read in (number, lambda text: number(text, ','), clock, lambda text: stamp(text, 'dmy')):
        values = [value for text in (before, cell, after) if (value := read(text)) is not None]
        if len(values) == 3:
            return values == sorted(values)
    return False


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
        kept = (before.headings, before.units, before.above, before.titles, before.preamble, before.named)
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
        count_named(names),
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
