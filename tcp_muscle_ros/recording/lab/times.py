"""How a column of times is written, and what it counts."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.recording.lab.cells import clock, day, number, stamp, unit_in
from tcp_muscle_ros.recording.recording import Array
from tcp_muscle_ros.recording.units import UNITS

CLOCK, STAMP, DATE = 'clock', 'stamp', 'date'
_EPOCHS = ((1e8, 's'), (1e11, 'ms'), (1e14, 'us'), (1e17, 'ns'))  # a number of 2001 or later, in each unit
_MOST = 200  # cells that are looked at
_DATENUM = (7.0e5, 8.0e5)  # MATLAB's days since the year 0: 1916 to 2190
SERIAL = (2.5e4, 8.0e4)  # a spreadsheet's days since 1900: 1968 to 2119
_DAYS = ((_DATENUM, 1e-2), (SERIAL, 2e-4))  # with a step from row to row that, as seconds, no logger has
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
    first = [value for cell in cells[:_MOST] if (value := number(cell, decimal)) is not None]
    return _without_unit(numbers, float(np.median(np.abs(np.diff(first)))) if len(first) > 1 else 0.0)


def _without_unit(numbers: Array, step: float) -> Kind:
    """What a column counts, by its numbers and their ``step`` from row to row; with a note where it may be another."""
    epoch = [unit for least, unit in _EPOCHS if float(np.min(np.abs(numbers))) >= least]
    if epoch:
        return Kind(epoch[-1])
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
