"""Lines of headings whose cells are not parted as those of the numbers below them."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from tcp_muscle_ros.recording.lab.cells import is_value
from tcp_muscle_ros.recording.lab.grid import Row

_UNIT = r'[(\[][^)\]]*[)\]]'
_WORD = re.compile(rf'"[^"]*"|[^\s(\[]*{_UNIT}\S*|\S+')  # '(DEG C)' is one, '"Heater current"' too
_WORD_AND_UNIT = re.compile(rf'(?:{_WORD.pattern})(?:\s+{_UNIT})?')
_WORDS_AND_UNIT = re.compile(rf'[^(\[]*{_UNIT}')
_WIDE = re.compile(r'\s{2,}|\t')
_LABELLED = re.compile(r'\s*[#%][^:]*:(.*)')  # '% columns: time, current'
_LISTED = re.compile(r'[,;|\t]')
_ENOUGH = 400  # rows, to tell how many columns there are


def words_of(line: str) -> list[str]:
    """The words of a line, without the quotes round them; what stands in quotes or brackets is one."""
    return [word.strip('"') for word in _WORD.findall(line)] if re.search(r'["(\[]', line) else line.split()


def misfit(headings: Sequence[str], width: int) -> str:
    """What is wrong with headings parted by spaces, where they stand over other columns than their own; '' else."""
    count = max((k + 1 for k, heading in enumerate(headings) if heading), default=0)
    if count == width:
        return ''
    return (
        f'{count} headings stand over {width} columns, so that none is surely over its own; expected one over each, '
        "without spaces in it or with two before the next, as 'Time (s)  Current (A)'"
    )


def with_fitting_headings(rows: Sequence[Row], lines: Sequence[str], spaces: bool) -> list[Row]:
    """The rows of a file, those of headings parted anew where that makes them as many as the columns below.

    ``spaces``: these separate the columns, and may stand within a heading too.
    """
    first, width = _first_numbers(rows)
    found = list(rows)
    if spaces:
        found = [row if _is_of_table(row, width) else _fitted(row, _ways(lines[row.number - 1]), width) for row in rows]
    above = next((k for k in range(first - 1, -1, -1) if not rows[k].blank), None)
    if above is None:
        return found
    if listed := _LABELLED.fullmatch(lines[rows[above].number - 1]):
        found[above] = _fitted(found[above], _listed(listed[1]), width)
    elif len(found[above].cells) == width - 1 and _count_rows(rows[first:], width):
        found[above] = Row(found[above].number, ('', *found[above].cells))  # R names no row numbers
    return found


def _first_numbers(rows: Sequence[Row]) -> tuple[int, int]:
    """The index of the first row of the table, and its width; (0, 0) where there is none."""
    numbers = [row for row in rows[-_ENOUGH:] if sum(map(is_value, row.cells)) > max(0.5 * len(row.cells), 1.0)]
    width = max(Counter(len(row.cells) for row in numbers).items(), key=lambda pair: pair[1], default=(0, 0))[0]
    return next((k for k, row in enumerate(rows) if _is_of_table(row, width)), 0), width


def _is_of_table(row: Row, width: int) -> bool:
    return 0 < len(row.cells) == width and 2 * sum(map(is_value, row.cells)) > width


def _count_rows(rows: Sequence[Row], width: int) -> bool:
    """Do the rows of the table begin with 1, 2, 3 and so on?"""
    first = [row.cells[0] for row in rows if len(row.cells) == width]
    return len(first) > 1 and first == [str(k + 1) for k in range(len(first))]


def _ways(line: str) -> Iterator[list[str]]:
    """The ways to part a line of headings among which there are spaces."""
    bare = line.strip('#% ')
    yield [words.strip(' "') for words in _WIDE.split(bare)]
    yield words_of(bare)
    yield [words.strip('"') for words in _WORD_AND_UNIT.findall(bare)]
    if not _WORDS_AND_UNIT.sub('', bare):
        yield [words.strip() for words in _WORDS_AND_UNIT.findall(bare)]


def _listed(text: str) -> Iterator[list[str]]:
    yield [name.strip() for name in _LISTED.split(text)]
    yield text.split()


def _fitted(row: Row, ways: Iterator[list[str]], width: int) -> Row:
    """The row parted in the first way that fits, else as it is."""
    fits = next((cells for cells in ways if len(cells) == width and not any(map(is_value, cells))), None)
    return row if fits is None else Row(row.number, tuple(fits))
