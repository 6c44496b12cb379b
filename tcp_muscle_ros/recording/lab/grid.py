"""A lab file as rows of text cells, whatever kind it is, and the layout that says where its table stands."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Row:
    """One row: its number, counted from 1 as an editor or a spreadsheet shows it, and its cells."""

    number: int
    cells: tuple[str, ...]

    @property
    def blank(self) -> bool:
        """Has it no text at all?"""
        return not any(self.cells)


@dataclass(frozen=True)
class Grid:
    """One sheet of a file; a text file has one, without a name. ``notes``: what was left out at its end."""

    rows: tuple[Row, ...]
    sheet: str = ''
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Layout:
    """Where a table stands in a file.

    encoding   of a text file
    delimiter  ',', ';', a tab ...; ``spaces`` for any run of spaces, ``pairs`` for ``name:value``, ``json`` for one
               object a line
    decimal    '.' or ',': of columns whose cells do not show their own, as 1,234
    headings   the numbers of the rows that name the columns; None for the first row that is not empty
    first      the number of the first row of the data; None for the one below the headings
    last       that of the last one; None for the end
    sheet      of a spreadsheet, or the variable of a MATLAB file; '' for the first
    only       rows in which the column of that heading has that text
    missing    texts that stand where there is no number, as OL
    long       of a table with one reading a row: the columns of the time, of what was read, and of its value
    """

    encoding: str = 'utf-8-sig'
    delimiter: str = ','
    decimal: str = '.'
    headings: tuple[int, ...] | None = None
    first: int | None = None
    last: int | None = None
    sheet: str = ''
    only: Mapping[str, str] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    long: tuple[str, str, str] | None = None


def count_named(headings: Iterable[Row]) -> int:
    """How many columns rows of headings keep a place for, be some of them empty."""
    return max((len(row.cells) for row in headings), default=0)


def joined_headings(rows: tuple[Row, ...], width: int) -> list[str]:
    """One heading a column from several rows, from above to below."""
    return [
        ' '.join(' '.join(row.cells[k].split()) for row in rows if k < len(row.cells) and row.cells[k])
        for k in range(width)
    ]
