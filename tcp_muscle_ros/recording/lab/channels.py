"""Which columns are channels of a muscle, and in which units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.lab.cells import NO_NUMBER, number
from tcp_muscle_ros.recording.lab.columns import Column
from tcp_muscle_ros.recording.lab.draft import ColumnRef, DraftColumn, DraftTime
from tcp_muscle_ros.recording.lab.grid import Row
from tcp_muscle_ros.recording.lab.preamble import rest_length
from tcp_muscle_ros.recording.lab.times import CLOCK, Kind
from tcp_muscle_ros.recording.lab.timing import time_kind, wraps_of
from tcp_muscle_ros.recording.lab.timing import times as times_of
from tcp_muscle_ros.recording.lab.vocabulary import RATIOS, SHARES, UNSCALED
from tcp_muscle_ros.recording.options import A_MAP
from tcp_muscle_ros.recording.plausibility import ROOM, USUAL, not_across
from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES, Array
from tcp_muscle_ros.recording.units import UNITS

_CHANNEL_OF = dict.fromkeys(('length', 'elongation', 'distance', 'strain'), 'displacement')
_COMMANDED = {**{name: f'{name}_command' for name in DRIVES}, 'displacement': 'displacement_setpoint'}
_STEADY = 0.02  # of its size, by which a load that hangs may vary
_WEIGHTS, _HUNG, _MANY = 5, 0.95, 200  # weights that are changed, the share of samples with one of them, of so many
_STAYS, _FAR = 20, 4.0  # samples for which a weight stays at least, and steps of its scale from one to the next
_FEWEST = 0.2  # share of the cells that are numbers
_SURE = 0.9  # of a correlation
_LAGS = (3.0, 8.0, 20.0, 40.0)  # s
_AWAY = 2.0  # times its span, from which on a position does not begin at its zero
_APART = 2.0  # rows, by which two clocks come apart


@dataclass(frozen=True)
class Candidate:
    """A column that may be a channel."""

    channel: str
    column: Column
    rows: Array  # as written, NaN where a cell is no number

    @property
    def value(self) -> Array:
        """The numbers."""
        return self.rows[np.isfinite(self.rows)]


class Warmth:
    """How warm the muscle is in each row: as measured, or the heat with which it is driven behind lags."""

    def __init__(
        self,
        thermometer: Candidate | None,
        drives: Sequence[Candidate],
        columns: Sequence[Column],
        time: DraftTime | float,
    ) -> None:
        self._warm = [] if thermometer is None else [thermometer.rows]
        if not self._warm and drives:
            rows = drives[0].rows
            at = time * np.arange(len(rows)) if isinstance(time, float) else times_of(columns, time)
            step = float(np.nanmedian(np.diff(at))) if len(at) > 1 else 0.0
            with np.errstate(all='ignore'):
                heat = np.nan_to_num(rows) ** (1 if drives[0].channel == 'power' else 2)
            shares = [min(step / lag, 1.0) for lag in _LAGS] if step > 0.0 else []
            self._warm = [lfilter([share], [1.0, share - 1.0], heat) for share in shares]

    def falls(self, each: Candidate) -> bool | None:
        """Does a column fall as the muscle warms? None where that cannot be told."""
        found = [_correlation(each.rows, warm) for warm in self._warm]
        best = max(found, key=abs, default=0.0)
        return best < 0.0 if abs(best) > _SURE else None


def _correlation(a: Array, b: Array) -> float:
    both = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(both) < 10 or np.ptp(a[both]) == 0.0 or np.ptp(b[both]) == 0.0:
        return 0.0
    with np.errstate(all='ignore'):  # the squares of what is huge
        return float(np.nan_to_num(np.corrcoef(a[both], b[both])[0, 1]))


def channels_of(
    columns: Sequence[Column], time: DraftTime | float, preamble: Sequence[Row], path: Path
) -> tuple[list[DraftColumn], list[str], list[str]]:
    """The channels of a table, the headings that are left out, and what was assumed.

    BadInput: several columns could be one channel, or the unit or the sign of one cannot be told.
    """
    clocks = _clocks(columns, time)
    ends = {column.ref: _end(column) for column in columns}
    of_run = ends[time.ref] if isinstance(time, DraftTime) else len(columns[0].cells)
    last = {index: ends[clock.ref] for index, clock in clocks.items()}
    rows = {c.index: read for c in columns if (read := _numbers(c, last.get(c.index, of_run))) is not None}
    found = [each for column in columns if (each := _candidate(column, columns, rows)) is not None]
    length = rest_length(preamble)
    notes = [_unread(column) for column in columns if _channel_of(column) and column.index not in rows]
    notes += [_unscaled(each.column) for each in found if _without_scale(each, length)]
    found = [each for each in found if not _without_scale(each, length)]
    elsewhere = _elsewhere(found)
    notes += [f'{ref} is left out: {why}' for ref, why in elsewhere.items()]
    found = [each for each in found if each.column.ref not in elsewhere]
    chosen = {
        channel: _chosen(channel, [each for each in found if each.channel == channel], path)
        for channel in dict.fromkeys(each.channel for each in found)
    }
    way = Warmth(chosen.get('temperature'), [chosen[name] for name in DRIVES if name in chosen], columns, time)
    drafts = []
    for channel, each in chosen.items():
        draft, more = _drafted(each, length, way, path)
        drafts.append(replace(draft, channel=channel, time=clocks.get(each.column.index)))
        notes += more
    used = {draft.ref for draft in drafts}
    times = {time.ref, time.date, time.fraction} if isinstance(time, DraftTime) else set()
    left = [c.heading for c in columns if c.heading and c.ref not in used | times and c.meaning.kind != 'time']
    if drafts and not {draft.channel for draft in drafts} & set(DRIVES):
        notes.append('no current, power or voltage is in it, without which nothing can be replayed or diagnosed')
    return drafts, left, notes


def _without_scale(each: Candidate, length: float | None) -> bool:
    """Is it a signal that nobody has scaled? A strain is scaled by the muscle's length."""
    raw, shares = each.column.meaning.raw, (*SHARES, *RATIOS)
    return bool(raw) and not (each.column.meaning.kind == 'strain' and raw in shares and length is not None)


def _elsewhere(found: Sequence[Candidate]) -> dict[ColumnRef, str]:
    """The voltages that are not across the muscle, and why."""
    current = next((each.rows for each in found if each.channel == 'current'), None)
    if current is None:
        return {}
    voltages = [each for each in found if each.channel == 'voltage']
    return {each.column.ref: why for each in voltages if (why := not_across(each.rows, current))}


def _unscaled(column: Column) -> str:
    meaning = column.meaning
    if meaning.kind == 'strain':
        told = f"{column.ref} is left out: a strain in {meaning.raw}, and the muscle's length is written nowhere"
        return f"{told}; write it above the table, as 'L0 = 120 mm'"
    told = f'{column.ref} is left out: a {meaning.kind} in {meaning.raw}'
    if meaning.raw in UNITS or meaning.raw.lower() in UNSCALED:
        return f'{told}, and how it is scaled is written nowhere'
    return f'{told}, which is none of its units; say its unit and scale in a map'


def _drafted(each: Candidate, length: float | None, way: Warmth, path: Path) -> tuple[DraftColumn, list[str]]:
    """A channel's column with its unit, its sign and its zero, and what was assumed."""
    kind, ref = each.column.meaning.kind, each.column.ref
    if each.channel != 'displacement':
        unit, note = _unit(each, path)
        notes = [note] if note else []
        if each.channel == 'force' and kind == 'load':
            notes.append(taken_as_force(ref))
        return DraftColumn(each.channel, ref, unit), notes
    if kind == 'strain' and length is not None and each.column.meaning.raw:
        raw = each.column.meaning.raw
        unit, note, scale = 'm', f'{ref} is in {raw} of {1e3 * length:g} mm', length / (1.0 if raw in RATIOS else 100.0)
    else:
        (unit, note), scale = _unit(each, path), 1.0
    notes = [note] if note else []
    falls = way.falls(each)
    if kind == 'elongation' and falls is False:  # it only contracts as it warms: a dL that counts the contraction
        notes.append(f'{ref} grows as the muscle warms: taken as its contraction')
        return DraftColumn(each.channel, ref, unit, 1, scale), notes
    if kind in ('length', 'elongation'):
        return DraftColumn(each.channel, ref, unit, -1, scale, from_first=kind == 'length'), notes
    if kind in ('distance', 'strain') and falls is None:
        raise BadInput(
            f'{path}: {ref}: a {kind} that grows or falls as the muscle contracts, and nothing in it tells which; '
            'say sign: 1 or -1 in ',
            *A_MAP,
            ", or name it 'contraction'",
        )
    if falls:
        notes.append(f'{ref} falls as the muscle warms; its sign is turned, so that contraction is positive')
    away = abs(float(each.value[0])) > _AWAY * float(np.ptp(each.value))
    if away and kind != 'distance':
        notes.append(f'{ref} begins at {each.value[0]:g} {unit}, far from zero; taken from there')
    return DraftColumn(each.channel, ref, unit, -1 if falls else 1, scale, away or kind == 'distance'), notes


def _channel_of(column: Column) -> str:
    """The channel that the heading names, '' where it names none."""
    kind = column.meaning.kind
    channel = _CHANNEL_OF.get(kind, kind)
    return channel if channel in CHANNELS else ''


def _end(column: Column) -> int:
    """The row after the last in which something stands."""
    return max((k for k, cell in enumerate(column.cells, 1) if cell), default=0)


def _numbers(column: Column, end: int) -> Array | None:
    """The numbers of a column without those that stand for none; None where there are too few.

    ``end``: the rows that its clock has. Many numbers at a lower rate may end with it before the table does; what ends
    before its clock is of another table, a calibration for example.
    """
    rows = np.where([cell in column.stand_ins for cell in column.cells], np.nan, column.numbers)
    count = np.count_nonzero(np.isfinite(rows))
    return rows if count >= max(_FEWEST * (end if count >= _MANY else len(rows)), 2) else None


def _unread(column: Column) -> str:
    """Why a column is no channel although its heading names one."""
    odd = [c for c in column.cells if c.lower() not in NO_NUMBER and number(c, column.decimal) is None]
    example = f", for example '{odd[0]}' is none" if odd else ''
    count = np.count_nonzero(np.isfinite(column.numbers))
    return f'{column.ref} is left out: {count} of its {len(column.cells)} cells are numbers{example}'


def _candidate(column: Column, columns: Sequence[Column], rows: Mapping[int, Array]) -> Candidate | None:
    """The channel that a column may be. ``rows``: the numbers of those that have enough, by their index."""
    channel, own = _channel_of(column), rows.get(column.index)
    if not channel or own is None:
        return None
    value = own[np.isfinite(own)]
    if column.meaning.commanded:
        if channel not in _COMMANDED:
            return None  # what was asked for; only what was measured counts
        channel = _COMMANDED[channel]
    measured = any(_is_a_force(each) for each in columns if each.index in rows)
    if channel == 'load' and not measured and not hangs(value):
        channel = 'force'  # what varies while the muscle works is measured, not hung on it
    return Candidate(channel, column, own)


def _is_a_force(column: Column) -> bool:
    """Whether a column is a force that was measured and may be scaled."""
    means = column.meaning
    return means.kind == 'force' and not means.commanded and not means.raw


def taken_as_force(column: object) -> str:
    """What is said of a load that does not hang."""
    return f'{column} varies: taken as a force that was measured; where an end hangs free, that is its load'


def hangs(value: Array) -> bool:
    """Whether a load stays as it is, or changes from one weight to another, as a load cell never does."""
    if is_steady(value):
        return True
    counts = np.sort(np.unique(value, return_counts=True)[1])
    few = bool(np.sum(counts[-_WEIGHTS:]) >= _HUNG * value.size)
    return value.size >= _MANY and (few or _is_put_on(value))


def _is_put_on(value: Array) -> bool:
    """Whether one number after the other stays for long, each far from the last: a coarse cell goes step by step."""
    begins = np.flatnonzero(np.diff(value, prepend=np.nan, append=np.nan))
    lasts = np.diff(begins)
    kept = lasts >= _STAYS
    if np.count_nonzero(kept) < 2 or np.sum(lasts[kept]) < _HUNG * value.size:
        return False
    jumps = np.abs(np.diff(value[begins[:-1][kept]]))
    return bool(np.median(jumps) >= _FAR * np.min(np.diff(np.unique(value))))


def is_steady(value: Array) -> bool:
    """Whether a load or a force stays as it is."""
    return bool(np.ptp(value) <= _STEADY * float(np.max(np.abs(value))))


def _chosen(channel: str, found: list[Candidate], path: Path) -> Candidate:
    """The one column for a channel: the muscle's own comes first, a stroke before a length, a unit before none."""
    for better in (
        [each for each in found if each.column.meaning.of_muscle],
        [each for each in found if each.column.meaning.kind == channel],
        [each for each in found if each.column.meaning.unit],
        found,
    ):
        if len(better) == 1:
            return better[0]
    names = ', '.join(f'{each.column.ref} in {each.column.meaning.unit or "?"}' for each in found)
    raise BadInput(
        f"{path}: {channel}: {len(found)} columns could be it ({names}); write 'muscle' into the heading of the right "
        'one, or say it in ',
        *A_MAP,
    )


def _unit(chosen: Candidate, path: Path) -> tuple[str, str]:
    """The unit of a column, and a note where it is not written: then the only one in which the values are usual."""
    unit = chosen.column.meaning.unit
    if unit is not None:
        return unit, ''
    kind = CHANNELS[chosen.channel]
    fitting = [
        each.name
        for each in UNITS.values()
        if each.quantity == UNITS[kind.unit].quantity and _would_do(chosen.channel, each.to_si(chosen.value))
    ]
    if len(fitting) == 1:
        told = f'{chosen.column.ref} has no unit; taken as {fitting[0]}, the only unit in which its values are usual'
        return fitting[0], told
    low, high = float(np.min(chosen.value)), float(np.max(chosen.value))
    would = f'are usual in {", ".join(fitting)}' if fitting else 'are usual in none of its units'
    raise BadInput(
        f'{path}: {chosen.column.ref} has no unit, and {low:.4g} to {high:.4g} {would}; write it into the heading, as '
        f"'{chosen.column.heading} ({(fitting or [kind.unit])[0]})', or into ",
        *A_MAP,
    )


def _would_do(channel: str, value: Array) -> bool:
    low, high = USUAL[channel.removesuffix('_command')]
    if not low <= float(np.max(np.abs(value))) <= high:
        return False
    return channel not in ('temperature', 'ambient') or ROOM[0] <= float(np.min(value)) <= ROOM[1]


def _clocks(columns: Sequence[Column], time: DraftTime | float) -> dict[int, DraftTime]:
    """Which columns have a clock of their own: a second column of times stands before them."""
    if not isinstance(time, DraftTime):
        return {}
    found: dict[int, DraftTime] = {}
    own: DraftTime | None = None
    first = next(column.heading for column in columns if column.ref == time.ref)
    at = times_of(columns, time)
    for column in columns:
        if column.ref in (time.ref, time.date, time.fraction):
            continue
        kind = time_kind(column) if column.meaning.kind == 'time' else None
        if column.heading == first:
            own = _own_clock(column, kind, columns, time) if kind is not None else None
        elif kind is not None and kind.unit in UNITS and _is_another_clock(column, kind.unit, at):
            own = _own_clock(column, kind, columns, time)
        elif own is not None:
            found[column.index] = own
    return found


def _own_clock(column: Column, kind: Kind, columns: Sequence[Column], time: DraftTime) -> DraftTime:
    """A second column of times, with a date and a fraction of its own where the first has such."""
    if kind.unit in UNITS:
        return DraftTime(column.ref, kind.unit, wraps=wraps_of(column))
    date = _repeated(time.date, column, columns) if kind.unit == CLOCK else None
    fraction = _repeated(time.fraction, column, columns)
    order = time.order if date else kind.order
    return DraftTime(column.ref, kind.unit, order, date, fraction, time.fraction_unit)


def _repeated(ref: ColumnRef | None, beside: Column, columns: Sequence[Column]) -> ColumnRef | None:
    """The column nearest to another that has the heading of ``ref`` and is not it; None where there is none."""
    heading = next((column.heading for column in columns if column.ref == ref), '')
    again = [column for column in columns if heading and column.heading == heading and column.ref != ref]
    return min(again, key=lambda column: abs(column.index - beside.index)).ref if again else None


def _is_another_clock(column: Column, unit: str, at: Array) -> bool:
    """Does it run on from row to row, but not with the time of the table (as a camera's beside a logger's)?"""
    own = UNITS[unit].to_si(column.numbers)
    both = np.isfinite(own) & np.isfinite(at)
    if np.count_nonzero(both) < 3 or np.any(np.diff(own[both]) <= 0.0):
        return False
    return float(np.ptp(own[both] - at[both])) > _APART * float(np.median(np.diff(at[both])))
