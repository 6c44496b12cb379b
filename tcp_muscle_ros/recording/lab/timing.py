"""The time of a table's rows: which columns make it up."""

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tcp_muscle_ros.recording.lab.cells import DAY_S, day, number
from tcp_muscle_ros.recording.lab.columns import Column
from tcp_muscle_ros.recording.lab.draft import ColumnRef, DraftTime
from tcp_muscle_ros.recording.lab.grid import Row
from tcp_muscle_ros.recording.lab.preamble import sampled_every
from tcp_muscle_ros.recording.lab.times import CLOCK, DATE, SERIAL, STAMP, Kind, kind_of, time_in
from tcp_muscle_ros.recording.recording import Array
from tcp_muscle_ros.recording.units import UNITS

_COUNTERS = (2.0**32, 2.0**16)  # at which micros() and millis() of a microcontroller begin anew, or two bytes of them
_HOUR_S = 3600.0
_NEAR = 20.0  # rows, to which where a counter begins anew must fit
_DATED = re.compile(r'dat[eu]|fecha|日付|日期', re.I)
_MOST_DAYS = 60.0  # that a run lasts


def time_of(columns: Sequence[Column], preamble: Sequence[Row]) -> DraftTime | float | None:
    """The column of times, or the period in s that is written above; None where there is neither.

    A count of seconds comes before a stamp, for it is finer; a clock goes with its date and its fraction of a second.
    """
    kinds = {column.ref: time_kind(column) for column in columns}
    dated = any(kind is not None and kind.unit in (STAMP, CLOCK) for kind in kinds.values())
    counting = [column for column in columns if (kind := kinds[column.ref]) and kind.unit in UNITS]
    rising = [column for column in counting if _rises(column) and not (dated and _begins_anew(column))]
    if rising:
        best = rising[0]
        kind = kinds[best.ref]
        assert kind is not None
        return DraftTime(best.ref, kind.unit, wraps=wraps_of(best), note=f'{best.ref} {kind.note}' if kind.note else '')
    for wanted in (STAMP, CLOCK):
        for column in columns:
            kind = kinds[column.ref]
            if kind is not None and kind.unit == wanted:
                return _with_companions(column, kind, columns, kinds)
    return _increment(columns, preamble) or sampled_every(preamble)


def time_kind(column: Column) -> Kind | None:
    """How the cells tell the time. A column without a heading may only be a clock or a stamp."""
    if column.meaning.kind not in ('time', '', 'index'):
        return None
    kind = kind_of(column.cells, column.meaning.unit, column.decimal)
    numbers = 2 * len(_finite(column)) > len(column.cells)
    if kind is not None and column.meaning.kind != 'time' and (kind.unit in UNITS or numbers):
        return None
    return Kind('d') if kind is not None and kind.unit == 's' and _counts_days(column) else kind


def _counts_days(column: Column) -> bool:
    """Are dates written as a spreadsheet keeps them, in days since 1900 (45365.375)?"""
    if column.meaning.unit is not None or not _DATED.search(column.heading):
        return False
    values = _finite(column)
    dates = all(SERIAL[0] <= value <= SERIAL[1] for value in values)
    return dates and len(values) > 0 and abs(values[-1] - values[0]) < _MOST_DAYS


def _begins_anew(column: Column) -> bool:
    """Is it a part of a second, that begins anew with each?"""
    values = _finite(column)
    anew = sum(after < before for before, after in pairwise(values))
    return anew > 1 and all(0.0 <= value < 1000.0 for value in values)


def _rises(column: Column) -> bool:
    """Does it mostly grow, as a time does and a fraction of a second does not?"""
    value = _finite(column)
    return len(value) > 1 and float(np.mean(np.diff(value) > 0.0)) > 0.6


def wraps_of(column: Column) -> float:
    """The count at which a column begins anew; 0 where it never does."""
    value = _finite(column)
    return next((wraps for wraps in _COUNTERS if _goes_on(value, wraps)), 0.0)


def _goes_on(value: Array, period: float) -> bool:
    """Does what falls begin anew at the period, each time within some steps?"""
    change = np.diff(value)
    falls = change[change < 0.0]
    return len(falls) > 0 and bool(np.all(np.abs(falls + period) < _NEAR * np.nanmedian(np.abs(change))))


def _with_companions(
    column: Column, kind: Kind, columns: Sequence[Column], kinds: dict[ColumnRef, Kind | None]
) -> DraftTime:
    """A clock or stamp with the column of its date, and that of its milliseconds."""
    date: ColumnRef | None = None
    order = kind.order
    for other in columns:
        found = kinds[other.ref]
        if kind.unit == CLOCK and found is not None and found.unit == DATE:
            date, order = other.ref, found.order
            break
    for other in columns:
        if other is column or other.meaning.kind in ('index', 'run'):
            continue
        values = _finite(other)
        named = other.meaning.kind == 'fraction' or (other.meaning.kind == 'time' and other.meaning.unit == 'ms')
        if named and len(values) == len(other.cells) and all(0.0 <= value < 1000.0 for value in values):
            unit = other.meaning.unit if other.meaning.unit == 'ms' else 's'
            return DraftTime(column.ref, kind.unit, order, date, other.ref, unit)
    return DraftTime(column.ref, kind.unit, order, date)


def _increment(columns: Sequence[Column], preamble: Sequence[Row]) -> float | None:
    """Rigol: the period stands once, below the heading 'Increment'."""
    for column in columns:
        head, _, value = column.heading.partition(' ')
        if head == 'Increment' and (found := number(value)):
            return found
    return None


def times(columns: Sequence[Column], time: DraftTime) -> Array:
    """The time of each row as it is written, in s; NaN where there is none. A clock that passes midnight goes on."""
    by_ref = {column.ref: column for column in columns}
    own = by_ref[time.ref]
    if time.unit in UNITS:
        return UNITS[time.unit].to_si(unwrapped(own.numbers, time.wraps))
    value = _array([time_in(cell, time.unit, time.order) for cell in own.cells])
    if time.date is not None:
        value = value + _array([day(cell, time.order) for cell in by_ref[time.date].cells])
    elif time.unit == CLOCK:
        value = past_midnight(value)
    if time.fraction is not None:
        value = value + UNITS[time.fraction_unit].to_si(by_ref[time.fraction].numbers)
    return value


def falls_throughout(time: Array) -> bool:
    """Do times fall from row to row, as where the newest row stands first?"""
    known = time[np.isfinite(time)]
    return len(known) > 2 and bool(np.all(np.diff(known) < 0.0))


def unwrapped(value: Array, wraps: float) -> Array:
    """A counter that begins anew at `wraps` as one that does not; 0: it never does."""
    if not wraps:
        return value
    return value + wraps * np.concatenate([[0.0], np.cumsum(np.diff(value) < -0.5 * wraps)])


def past_midnight(value: Array) -> Array:
    """Times of day that pass midnight, in s, as times that go on; so are minutes and seconds that pass the hour."""
    hours = bool(np.nanmax(value, initial=0.0) < _HOUR_S) and _goes_on(value, _HOUR_S)
    return unwrapped(value, _HOUR_S if hours else DAY_S)


def _finite(column: Column) -> Array:
    """The numbers of a column, without the cells that are none."""
    value = column.numbers
    return value[np.isfinite(value)]


def _array(values: Sequence[float | None]) -> Array:
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
