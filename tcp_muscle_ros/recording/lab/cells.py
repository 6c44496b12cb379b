"""What a cell says: a number, a time of day, a date, or nothing."""

import re
from collections import Counter
from collections.abc import Iterable
from datetime import date

from tcp_muscle_ros.recording.lab.unit_names import unit_named

DAY_S = 86400.0
_ORIGIN = 730120  # 1 January 2000, from which seconds are counted: a double keeps them to 0.1 us

# What instruments print where they have no number; nothing to be said of them.
NO_NUMBER = frozenset({'', 'nan', '-nan', 'na', 'n/a', '#n/a', 'null', 'none', '-', '--', '---', '----', '#nv'})

_ERROR = re.compile(r'#\S+[!?]')  # what a spreadsheet shows for a formula that fails: #DIV/0!
_NUMBER = re.compile(r'([+-]?\s*(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?)\s*(\D.*)?')
_POINT = re.compile(r'[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?')
# No group of thousands begins with a zero: 0,100 is a tenth.
_THOUSANDS = {
    '.': re.compile(r'[+-]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?'),
    ',': re.compile(r'[+-]?[1-9]\d{0,2}(\.\d{3})+(,\d*)?'),
}
_GROUPED = re.compile(r"[+-]?\d{1,3}([’'\u00a0\u2009\u202f]\d{3})+(?!\d)")  # Swiss, or with narrow spaces
_HALF = r'(?:\s*([AaPp])\.?(?:\s*[Mm]\.?)?)?'  # AM, a.m., 'p. m.'
_CLOCK = re.compile(rf'(?:(\d+):)?(\d{{1,2}}):(\d{{1,2}}(?:[.,:]\d+)?){_HALF}')
_DATE = re.compile(r'(\d{1,4})([-/.])(\d{1,2})\2(\d{1,4})\.?')
_STAMP = re.compile(
    r'([\d/.-]+?)\s*[T ,]\s*(\d{1,2}:[\d:.,]+(?:\s*[AaPp]\.?\s*[Mm]\.?)?)\s*(Z|[+-]\d{2}:?\d{2})?(?:\[.*\])?'
)


def number(cell: str, decimal: str = '.') -> float | None:
    """The number in a cell, None where it is none. A known unit may follow it; thousands may be separated.

    With a unit in brackets, as `101 (C)`, it is a heading. A point that parts no thousands is a decimal one beside
    decimal commas too.
    """
    cell = cell.replace('\u2212', '-')
    if grouped := _GROUPED.match(cell):
        cell = re.sub(r'[^\d+-]', '', grouped[0]) + cell[grouped.end() :]
    found = _NUMBER.fullmatch(cell)
    if not found or (found[2] and (found[2][0] in '[(<{' or unit_named(found[2]) is None)):
        return None
    digits = found[1].replace(' ', '')
    if _THOUSANDS[decimal].fullmatch(digits):
        digits = digits.replace(',' if decimal == '.' else '.', '')
    if decimal == ',' and ',' in digits:
        digits = digits.replace('.', ' ').replace(',', '.')
    return float(digits) if _POINT.fullmatch(digits) else None


def decimal_in(cell: str) -> str | None:
    """The decimal mark that a cell shows by itself; None where it has none, or could have either, as 1,234."""
    point, comma = number(cell), number(cell, ',')
    if point == comma:
        return '.' if point is not None and '.' in cell else None
    return ',' if point is None else '.' if comma is None else None


def decimal_of(cells: Iterable[str], usual: str) -> str:
    """The decimal mark of a column; ``usual`` is that of its file, which counts where no cell of the column shows one.

    Where 1.234 could have either, points are those of thousands only if smaller numbers stand beside it without.
    """
    written = [cell for cell in cells if cell]
    told = Counter(map(decimal_in, written))
    if told[',']:
        points = [(value, number(cell, ',')) for cell in written if (value := number(cell)) is not None]
        return ',' if told[','] > told['.'] or all(value == same for value, same in points) else '.'
    if told['.']:
        return '.'
    numbers = [cell for cell in written if number(cell, usual) is not None]
    return '.' if numbers and all('.' in cell for cell in numbers) else usual


def unit_in(cell: str) -> str | None:
    """The unit that follows the number in a cell."""
    found = _NUMBER.fullmatch(cell)
    return unit_named(found[2]) if found and found[2] else None


def clock(cell: str) -> float | None:
    """A time of day or a duration, h:m:s, m:s or h:m:s PM, in s; None for anything else."""
    found = _CLOCK.fullmatch(cell)
    if not found:
        return None
    seconds = float(found[3].replace(',', '.').replace(':', '.'))
    hours = int(found[1] or 0)
    if found[4]:
        hours = hours % 12 + (12 if found[4] in 'pP' else 0)
    return 3600.0 * hours + 60.0 * int(found[2]) + seconds


def day(cell: str, order: str) -> float | None:
    """The day of a date as s since 1 January 2000; ``order``: dmy, mdy or ymd. None for anything else."""
    found = _DATE.fullmatch(cell)
    if not found:
        return None
    parts = dict(zip('ymd' if len(found[1]) == 4 else order, (found[1], found[3], found[4]), strict=True))
    year, month, of_month = (int(parts[letter]) for letter in 'ymd')
    try:
        return DAY_S * (date(year + (2000 if year < 100 else 0), month, of_month).toordinal() - _ORIGIN)
    except ValueError:
        return None


def stamp(cell: str, order: str) -> float | None:
    """A date with a time of day, and perhaps a zone, in s since 2000; None for anything else."""
    found = _STAMP.fullmatch(cell)
    if not found:
        return None
    at, of_day = day(found[1], order), clock(found[2].strip())
    if at is None or of_day is None:
        return None
    zone = 0.0
    if found[3] and found[3] != 'Z':
        digits = found[3][1:].replace(':', '')
        zone = (3600.0 * int(digits[:2]) + 60.0 * int(digits[2:])) * (-1.0 if found[3][0] == '-' else 1.0)
    return at + of_day - zone


def is_time(cell: str) -> bool:
    """Is it a time of day, a date or both?"""
    return (
        clock(cell) is not None
        or day(cell, 'dmy') is not None
        or day(cell, 'mdy') is not None
        or any(stamp(cell, order) is not None for order in ('dmy', 'mdy'))
    )


def is_none(cell: str) -> bool:
    """Is it what stands there where there is no number? A word such as ERR or OL, which may be any, is not."""
    return cell.lower() in NO_NUMBER or _ERROR.fullmatch(cell) is not None


def is_value(cell: str) -> bool:
    """Is it what stands in a table of measurements: a number, with a point or a comma, or a time?"""
    return number(cell) is not None or number(cell, ',') is not None or is_time(cell)
