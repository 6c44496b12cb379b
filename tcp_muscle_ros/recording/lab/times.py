"""How a column of times is written, and what it counts."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.recording.lab.cells import clock, day, number, stamp, unit_in
from tcp_muscle_ros.recording.recording import Array
from tcp_muscle_ros.recording.units import UNITS

CLOCK, STAMP, DATE = 'clock', 'stamp', 'date'
_EPOCHS = ((1e8, 's'), (1e11, 'ms'), (1e14, 'us'), (1e17, 'ns'))  # a number of 1973 or later, in each unit
_NO_EPOCH = 45.0  # times as much: beyond 2110, of which no clock tells
_MOST = 200  # cells that are looked at
_DATENUM = (7.0e5, 8.0e5)  # MATLAB's days since the year 0: 1916 to 2190
SERIAL = (2.5e4, 8.0e4)  # a spreadsheet's days since 1900: 1968 to 2119
_DAYS = ((_DATENUM, 1e-2), (SERIAL, 2e-4))  # with a step from row to row that, as seconds, no logger has
# 140000.5, 20240503140000.5
_ONE_NUMBER = re.compile(r'(?:(\d{4}|\d{2})(\d{2})(\d{2})(?=\d{6}))?(\d{1,2})(\d{2})(\d{2}(?:[.,]\d*)?)')
_ENOUGH = 20  # numbers, that are times of day by no chance
_SLOW_MS, _DAY_MS = 5e3, 8.64e7  # a row every 5 s for more than a day is a counter of microseconds


@dataclass(frozen=True)
class Kind:
    """What the cells of a column of times are: a unit, or ``clock``, ``stamp``, ``date``; the order of a date."""

    unit: str
    order: str = 'dmy'
    note: str = ''


def kind_of(cells: Sequence[str], unit: str | None, decimal: str) -> Kind | None:
    """How a column of times is written; None where it is no time."""
    some = [cell for cell in cells if cell]
    if not some:
        return None
    last = some[-1]
    some = some[:: max(len(some) // _MOST, 1)]
    order = order_of([*some, last])
    for name, read in ((CLOCK, clock), (STAMP, lambda cell: stamp(cell, order)), (DATE, lambda cell: day(cell, order))):
        if sum(read(cell) is not None for cell in some) > 0.9 * len(some):
            return Kind(name, order)
    values = [number(cell, decimal) for cell in some]
    numbers = np.array([value for value in values if value is not None])
    if len(numbers) < 0.9 * len(some):
        return None
    written = unit or unit_in(some[0])
    if written:
        return Kind(written) if UNITS[written].quantity == 'time' else None
    if one := _one_number(cells, decimal):
        return Kind(one)
    first = [value for cell in cells[:_MOST] if (value := number(cell, decimal)) is not None]
    return _without_unit(numbers, float(np.median(np.abs(np.diff(first)))) if len(first) > 1 else 0.0)


def time_in(cell: str, unit: str, order: str) -> float | None:
    """The time in a cell of a column in ``clock`` or ``stamp``, which may be written as one number; s."""
    return clock(_parted(cell)) if unit == CLOCK else stamp(_parted(cell), order)


def _parted(cell: str) -> str:
    """A time of day, or a date with it, that is written as one number, with the signs that part it; else as it is."""
    if not (found := _ONE_NUMBER.fullmatch(cell)):
        return cell
    year, month, of_month, *of_day = found.groups()
    if year is None:
        return ':'.join(of_day)
    return f'{year if len(year) > 2 else f"20{year}"}-{month}-{of_month} {":".join(of_day)}'


def _one_number(cells: Sequence[str], decimal: str) -> str:
    """Whether the numbers are times of day, or dates with them: ``clock``, ``stamp`` or ''.

    Each of them is one then, and so they go on more evenly over each minute: 140059 is followed by 140100.
    """
    some = [cell for cell in cells if cell]
    if not all(map(_ONE_NUMBER.fullmatch, some)):
        return ''
    dated = all(len(re.split('[.,]', cell)[0]) in (12, 14) for cell in some)
    read = (lambda cell: stamp(cell, 'ymd')) if dated else clock
    found = [_sound(_parted(cell), read) for cell in some]
    at = np.array([value for value in found if value is not None])
    if len(at) < len(some):
        return ''
    if dated:
        return STAMP
    written = np.array([number(cell, decimal) for cell in some], dtype=np.float64)
    return CLOCK if len(at) >= _ENOUGH and _unevenness(at) < 0.5 * _unevenness(written) else ''


def _sound(cell: str, read: Callable[[str], float | None]) -> float | None:
    """The time that a cell is, None where its hours, minutes or seconds are beyond what there is of them."""
    within = re.search(r'(\d+):(\d+):(\d+)', cell)
    return read(cell) if within and int(within[1]) < 24 and max(int(within[2]), int(within[3])) < 60 else None


def _unevenness(values: Array) -> float:
    step = np.diff(values)
    return float(np.sum(np.abs(step - np.median(step))))


def _without_unit(numbers: Array, step: float) -> Kind | None:
    """What a column counts, by its numbers and their ``step`` from row to row; with a note where it may be another.

    None where it would be dates beyond 2110.
    """
    least = float(np.min(np.abs(numbers)))
    epoch = [(first, unit) for first, unit in _EPOCHS if least >= first]
    if epoch:
        first, unit = epoch[-1]
        return Kind(unit) if least <= _NO_EPOCH * first else None
    for (low, high), quickest in _DAYS:
        if low <= float(np.min(numbers)) and float(np.max(numbers)) <= high and 0.0 < step < quickest:
            return Kind('d')
    whole = bool(np.all(numbers == np.round(numbers)))
    if whole and step >= _SLOW_MS and float(np.ptp(numbers)) > _DAY_MS:
        unit = 'us'
    else:
        unit = 'ms' if whole and step >= 5.0 else 's'
    return Kind(unit, note=f'has no unit; taken as {unit}, with a row every {UNITS[unit].to_si(step):.3g} s')


def order_of(cells: Sequence[str]) -> str:
    """The order of day, month and year in dates that do not begin with the year."""
    first = cells[0]
    parts = [re.findall(r'\d+', cell)[:2] for cell in cells]
    if any(len(pair) == 2 and int(pair[0]) > 12 for pair in parts):
        return 'dmy'
    if any(len(pair) == 2 and int(pair[1]) > 12 for pair in parts) or re.search(r'[AaPp]\.?[Mm]', first):
        return 'mdy'
    if '.' in first.split()[0]:
        return 'dmy'
    return 'dmy' if _largest_step(cells, 'dmy') < _largest_step(cells, 'mdy') else 'mdy'


def _largest_step(cells: Sequence[str], order: str) -> float:
    """The longest time (s) from one date to the next: a run that passes midnight goes on by a day, and by no month."""
    days = [found for cell in cells if (found := day(re.split(r'[T ,]', cell.strip())[0], order)) is not None]
    return max((abs(after - before) for before, after in pairwise(days)), default=0.0)
