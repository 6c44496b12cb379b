"""Recordings as pandas DataFrames, and the reverse. pandas (extra `labs`) is loaded when it is asked for."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tcp_muscle_ros.errors import BadInput, install, nearest
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.inputs import stated_ambient
from tcp_muscle_ros.recording.lab.channels import Candidate, Warmth, hangs, taken_as_force
from tcp_muscle_ros.recording.lab.columns import Column
from tcp_muscle_ros.recording.lab.draft import ColumnRef
from tcp_muscle_ros.recording.lab.headings import Meaning, meaning
from tcp_muscle_ros.recording.lab.stand_ins import stand_ins
from tcp_muscle_ros.recording.leaps import dated
from tcp_muscle_ros.recording.recording import (
    CHANNELS,
    DRIVES,
    LARGEST,
    UNDATED_NS,
    Array,
    Channel,
    Mask,
    Recording,
    channel_kind,
)
from tcp_muscle_ros.recording.units import UNITS
from tcp_muscle_ros.recording.yaml_input import number_or_none

if TYPE_CHECKING:
    import pandas as pd

TIME = 'time_s'
START, NOTES = 'start_ns', 'notes'  # of a recording, in the attrs of its frame
_ENDS = 50  # different numbers at either end of a column: more than there are texts of nines in any


def column_name(channel: str) -> str:
    """The column of a channel, with its unit: ``temperature_degC``."""
    return f'{channel}_{CHANNELS[channel].unit}'


def aligned(recording: Recording) -> tuple[Array, dict[str, Array]]:
    """All times of a recording, s, and by column name each channel's values at them, NaN where it has no sample."""
    channels = list(recording.channels.values())
    time: Array = np.unique(np.concatenate([channel.time for channel in channels])) if channels else np.empty(0)
    columns = {}
    for channel in channels:
        values = np.full(len(time), np.nan)
        values[np.searchsorted(time, channel.time)] = UNITS[CHANNELS[channel.name].unit].from_si(channel.value)
        columns[column_name(channel.name)] = values
    return time, columns


def stated(recording: Recording, rows: int) -> dict[str, Array]:
    """By column name, the load and the room that a recording states in words and no channel has, in each row."""
    known = {'load': number_or_none(recording.known.get('load_n')), 'ambient': stated_ambient(recording, None)}
    return {
        column_name(name): np.full(rows, UNITS[CHANNELS[name].unit].from_si(value))
        for name, value in known.items()
        if value is not None and name not in recording and not (name == 'load' and 'force' in recording)
    }


def to_frame(recording: Recording) -> 'pd.DataFrame':
    """A recording as a DataFrame: the index ``time_s``, a column a channel with its unit, NaN where it has no sample.

    ``frame.attrs`` has what is known of the run, the reader's ``notes``, and where it is dated its ``start_ns``.

    BadInput: pandas is not installed.
    """
    pandas = _pandas()
    time, columns = aligned(recording)
    frame = pandas.DataFrame(columns, index=pandas.Index(time, name=TIME))
    frame.attrs = {str(key): value for key, value in recording.known.items()}
    if recording.notes:
        frame.attrs[NOTES] = recording.notes
    if dated(recording):
        frame.attrs[START] = recording.start_ns
    return frame


def of_frame(frame: 'pd.DataFrame', name: str = 'frame', *, channels: Mapping[str, str] | None = None) -> Recording:
    """A DataFrame as a recording.

    Columns are named as headings of a lab file are: ``temperature_degC``, ``I (mA)``, ``Weg [mm]``; without a unit that
    of the channel's topic holds, and what is in no unit of its channel (a power in %) is left out. So is a number that
    stands for none (-999.9), or that is none of its channel (below 0 K), with a note. The time is a column
    of that name, or else the index: in the unit that its name has, else in s, or stamps.

    A load varies only where its column is named as ours is, or said to be it; else it is a force that was measured.
    A distance is the displacement where no other column is; its sign is told by how warm the muscle is.

    channels  NAME -> column, where a column's name does not say it

    BadInput: no column is a channel, two are the same, one is missing or not of numbers, or the time does not rise.
    """
    if frame.columns.nlevels > 1:
        levels = frame.columns.nlevels
        raise BadInput(
            f'{name}: the names of its columns have {levels} levels; expected one (frame.droplevel(0, axis=1))'
        )
    chosen = _chosen(frame, name, channels or {})
    meanings = {str(column): meaning(str(column)) for column in frame.columns}
    named = next((column for column, found in meanings.items() if found.kind == 'time'), None)
    if named is not None:
        time, first = _seconds(_the_one(frame, named, name), meanings[named].unit, name)
    else:
        heading = meaning(str(frame.index.name))
        time, first = _seconds(frame.index, heading.unit if heading.kind == 'time' else None, name)
    taken: dict[str, Channel] = {}
    units: dict[str, str] = {}
    notes: list[str] = []
    for column, found in meanings.items():
        channel = chosen.get(column) or _channel_of(column, found)
        if channel is None or (found.raw and column not in chosen):
            continue
        if channel in chosen.values() and column not in chosen:
            continue
        if channel in taken:
            raise BadInput(f"{name}: two columns are {channel}, the second is '{column}'; expected one")
        units[channel] = _unit(channel, found)
        read = Channel(channel, time, _numbers(frame, column, name), column)
        taken[channel], left_out = _si(read, units[channel], found.kind, name)
        notes += left_out
    notes += _loads_as_forces(taken, units, chosen)
    notes += _take_distance(frame, meanings, taken, units, time, name)
    if not taken:
        raise BadInput(f"{name}: no column is a channel of a muscle; expected such as '{column_name('temperature')}'")
    start_ns, before, known = _told(frame, first)
    return Recording(name, taken, start_ns, known, (*before, *notes), units)


def _told(frame: 'pd.DataFrame', first: float) -> tuple[int, tuple[str, ...], dict[str, object]]:
    """What ``to_frame`` wrote of a recording: when it started, its notes, and what is known of it.

    A part of a frame has the attrs of the whole: it started later by the time (s) of its first row.
    """
    known = {str(key): value for key, value in frame.attrs.items()}
    notes: tuple[str, ...] = ()
    start_ns = UNDATED_NS
    if isinstance(known.get(START), int):
        start_ns = int(known.pop(START)) + round(1e9 * first)
    if isinstance(known.get(NOTES), tuple | list):  # a list once it was in a file
        notes = tuple(map(str, known.pop(NOTES)))
    return start_ns, notes, known


def _loads_as_forces(taken: dict[str, Channel], units: dict[str, str], chosen: Mapping[str, str]) -> tuple[str, ...]:
    """Turn what a heading alone calls a load, and what varies as a load cell's reading, into the force that it is; what
    was assumed."""
    load = taken.get('load')
    if load is None or 'force' in taken or load.topic in chosen or _exactly(load.topic) or hangs(load.value):
        return ()
    taken['force'], units['force'] = replace(taken.pop('load'), name='force'), units.pop('load')
    return (taken_as_force(f"'{load.topic}'"),)


def _chosen(frame: 'pd.DataFrame', name: str, channels: Mapping[str, str]) -> dict[str, str]:
    """Which column was said to be which channel."""
    columns = [str(column) for column in frame.columns]
    chosen = {}
    for channel, column in channels.items():
        kind = channel_kind(channel, options.CHANNEL)
        if column not in columns:
            raise BadInput(options.channel(channel), f": {name} has no column '{column}'{nearest(column, columns)}")
        chosen[column] = kind.name
    return chosen


def _unit(channel: str, found: Meaning) -> str:
    """The unit in a heading, where it is one of the channel; else that of the channel."""
    own = CHANNELS[channel].unit
    return found.unit if found.unit and UNITS[found.unit].quantity == UNITS[own].quantity else own


def _numbers(frame: 'pd.DataFrame', column: str, name: str) -> Array:
    try:
        return np.array(_the_one(frame, column, name), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise BadInput(f"{name}: column '{column}' is not all numbers ({error})") from None


def _si(read: Channel, unit: str, kind: str, name: str) -> tuple[Channel, list[str]]:
    """The numbers of a column in SI, without those that are none, and what was left out. ``kind`` of its heading."""
    where = f"'{read.topic}'"
    numbers = read.value
    none = _standing_for_none(numbers, read.name)
    value: Array = np.where(none, np.nan, UNITS[unit].to_si(numbers))
    unknown = np.isnan(value)
    huge = ~unknown & ~(np.abs(value) < LARGEST)
    frozen = (value <= 0.0) & ~huge & (read.name in ('temperature', 'ambient'))
    which = ' and '.join(f'{number:g}' for number in np.unique(numbers[none]))
    notes = [
        f'{where}: {np.count_nonzero(some)} of {some.size} values are {what}; left out'
        for some, what in (
            (none, f'{which}, which stands for none'),
            (huge, f'not finite or above {LARGEST:g}'),
            (frozen, 'at or below 0 K'),
        )
        if some.any()
    ]
    known = ~(unknown | huge | frozen)
    value = value[known]
    if not value.size:
        raise BadInput(f'{name}: no number in column {where}; expected some, or the frame without it')
    if kind in ('length', 'distance'):
        value = value - value[0]
    if kind in ('length', 'elongation'):
        value = 0.0 - value
    return replace(read, time=read.time[known], value=value), notes


def _standing_for_none(numbers: Array, channel: str) -> Mask:
    """Which numbers stand for none, as in a lab's file. They lie at the ends of all; what is between is left alone."""
    found, count = np.unique(numbers[np.isfinite(numbers)], return_counts=True)
    ends = np.unique(np.concatenate([np.arange(found.size)[:_ENDS], np.arange(found.size)[-_ENDS:]]))
    cells = {_as_written(found[k]): k for k in ends}
    odd = stand_ins([cell for cell, k in cells.items() for _ in range(min(count[k], 2))], '.', channel)
    return np.isin(numbers, [found[cells[cell]] for cell in odd])


def _as_written(number: float) -> str:
    """A number with no more digits than it had, in single precision too: -999.9, and not -999.9000244140625."""
    with np.errstate(over='ignore'):
        single = np.float32(number)
    return str(single if single == number else number)


def _take_distance(
    frame: 'pd.DataFrame',
    meanings: Mapping[str, Meaning],
    taken: dict[str, Channel],
    units: dict[str, str],
    time: Array,
    name: str,
) -> list[str]:
    """Take a distance for the displacement where no column is one, with the sign that the file reader gives it; what
    was assumed. BadInput: there are two, or nothing tells its sign."""
    said = {channel.topic for channel in taken.values()}
    columns = [c for c, m in meanings.items() if m.kind == 'distance' and not (m.raw or m.commanded or c in said)]
    if 'displacement' in taken or not columns:
        return []
    if len(columns) > 1:
        raise BadInput(f"{name}: two columns are displacement, the second is '{columns[1]}'; expected one")
    (column,) = columns
    unit = _unit('displacement', meanings[column])
    read = Channel('displacement', time, _numbers(frame, column, name), column)
    channel, notes = _si(read, unit, 'distance', name)
    rows = {each: _candidate(taken[each], time) for each in ('temperature', *DRIVES) if each in taken}
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    warmth = Warmth(rows.get('temperature'), [rows[drive] for drive in DRIVES if drive in rows], (), step)
    falls = warmth.falls(_candidate(channel, time))
    if falls is None:
        raise BadInput(
            f"{name}: '{column}' is a distance that grows or falls as the muscle contracts, and nothing in it tells "
            'which; say ',
            options.these_channels({'displacement': column}),
            f" where it grows, with units={{'displacement': '-{unit}'}} too where it falls; or leave the column out",
        )
    if falls:
        channel = replace(channel, value=-channel.value)
        notes.append(f"'{column}' falls as the muscle warms; its sign is turned, so that contraction is positive")
    taken['displacement'], units['displacement'] = channel, unit
    return notes


def _candidate(channel: Channel, time: Array) -> Candidate:
    """A channel as the file reader looks at one: a number a row."""
    rows = np.full(len(time), np.nan)
    rows[np.searchsorted(time, channel.time)] = channel.value
    return Candidate(channel.name, Column(0, channel.topic, ColumnRef(channel.topic), meaning(channel.topic), ()), rows)


def _the_one(frame: 'pd.DataFrame', column: str, name: str) -> 'pd.Series':
    """The column of this name; BadInput where there are two."""
    found = frame[column]
    if found.ndim > 1:
        raise BadInput(f"{name}: {found.shape[1]} columns are named '{column}'; expected one")
    return found


def _channel_of(column: str, found: Meaning) -> str | None:
    """The channel of a column: by its full name (``current_command_A``), else by what its heading means."""
    channel = _exactly(column) or {'length': 'displacement', 'elongation': 'displacement'}.get(found.kind, found.kind)
    return channel if channel in CHANNELS else None


def _exactly(column: str) -> str | None:
    """The channel that a column's name is."""
    return next((each for each in CHANNELS if column in (each, column_name(each))), None)


def _seconds(times: 'pd.Series | pd.Index', unit: str | None, name: str) -> tuple[Array, float]:
    """The times since the first, and the first, 0 of stamps, which have a unit of their own, whatever is said."""
    zoned = getattr(times.dtype, 'tz', None) is not None
    values = times.to_numpy(dtype='datetime64[ns]') if zoned else np.asarray(times)
    if values.dtype.kind in 'mM':
        values, unit = (values - values[:1]).astype('timedelta64[ns]').astype(np.float64) * 1e-9, 's'
    try:
        time: Array = UNITS[unit or 's'].to_si(values.astype(np.float64))
    except (TypeError, ValueError):
        raise BadInput(f'{name}: the time is {values.dtype}, expected seconds or stamps') from None
    if not len(time):
        raise BadInput(f'{name}: it has no rows')
    if not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
        raise BadInput(f'{name}: the time does not increase from row to row')
    return time - time[0], float(time[0])


def _pandas() -> Any:
    try:
        import pandas
    except ModuleNotFoundError:
        raise BadInput(f'DataFrames need pandas: {install("labs")}') from None
    return pandas
