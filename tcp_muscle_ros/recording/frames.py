"""Recordings as pandas DataFrames, and the reverse. pandas (extra `labs`) is loaded when it is asked for."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tcp_muscle_ros.errors import BadInput, install, nearest
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.inputs import stated_ambient
from tcp_muscle_ros.recording.lab.channels import hangs, taken_as_force
from tcp_muscle_ros.recording.lab.headings import Meaning, meaning
from tcp_muscle_ros.recording.recording import CHANNELS, UNDATED_NS, Array, Channel, Recording, channel_kind
from tcp_muscle_ros.recording.units import UNITS
from tcp_muscle_ros.recording.yaml_input import number_or_none

if TYPE_CHECKING:
    import pandas as pd

TIME = 'time_s'


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

    ``frame.attrs`` has what is known of the run. BadInput: pandas is not installed.
    """
    pandas = _pandas()
    time, columns = aligned(recording)
    frame = pandas.DataFrame(columns, index=pandas.Index(time, name=TIME))
    frame.attrs = {str(key): value for key, value in recording.known.items()}
    return frame


def of_frame(frame: 'pd.DataFrame', name: str = 'frame', *, channels: Mapping[str, str] | None = None) -> Recording:
    """A DataFrame as a recording.

    Columns are named as headings of a lab file are: ``temperature_degC``, ``I (mA)``, ``Weg [mm]``; without a unit that
    of the channel's topic holds, and what is in no unit of its channel (a power in %) is left out. The time is a column
    of that name, or else the index: in the unit that its name has, else in s, or stamps.

    A load varies only where its column is named as ours is, or said to be it; else it is a force that was measured.

    channels  NAME -> column, where a column's name does not say it

    BadInput: no column is a channel, two are the same, one is missing or not of numbers, or the time does not rise.
    """
    chosen = _chosen(frame, name, channels or {})
    meanings = {str(column): meaning(str(column)) for column in frame.columns}
    named = next((column for column, found in meanings.items() if found.kind == 'time'), None)
    if named is not None:
        time = _seconds(_the_one(frame, named, name), meanings[named].unit, name)
    else:
        heading = meaning(str(frame.index.name))
        time = _seconds(frame.index, heading.unit if heading.kind == 'time' else None, name)
    taken: dict[str, Channel] = {}
    units: dict[str, str] = {}
    for column, found in meanings.items():
        channel = chosen.get(column) or _channel_of(column, found)
        if channel is None or (found.raw and column not in chosen):
            continue
        if channel in chosen.values() and column not in chosen:
            continue
        if channel in taken:
            raise BadInput(f"{name}: two columns are {channel}, the second is '{column}'; expected one")
        units[channel] = _unit(channel, found)
        value = UNITS[units[channel]].to_si(_numbers(frame, column, found, name))
        finite = np.isfinite(value)
        taken[channel] = Channel(channel, time[finite], value[finite], column)
    notes = _loads_as_forces(taken, units, chosen)
    if not taken:
        raise BadInput(f"{name}: no column is a channel of a muscle; expected such as '{column_name('temperature')}'")
    known = {str(key): value for key, value in frame.attrs.items()}
    return Recording(name, taken, UNDATED_NS, known, notes, units)


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


def _numbers(frame: 'pd.DataFrame', column: str, found: Meaning, name: str) -> Array:
    cells = _the_one(frame, column, name)
    try:
        value: Array = np.asarray(cells, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise BadInput(f"{name}: column '{column}' is not all numbers ({error})") from None
    known = np.flatnonzero(np.isfinite(value))
    if not known.size:
        raise BadInput(f"{name}: no number in column '{column}'; expected some, or the frame without it")
    if found.kind in ('length', 'elongation'):
        value = (value[known[0]] if found.kind == 'length' else 0.0) - value
    return value


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


def _seconds(times: 'pd.Series | pd.Index', unit: str | None, name: str) -> Array:
    """The times since the first. Stamps and spans have a unit of their own, whatever the heading says."""
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
    since_first: Array = time - time[0]
    return since_first


def _pandas() -> Any:
    try:
        import pandas
    except ModuleNotFoundError:
        raise BadInput(f'DataFrames need pandas: {install("labs")}') from None
    return pandas
