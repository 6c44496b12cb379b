"""What was imposed, read from a recording in the same way by everybody: which input, what holds when, and the room."""

import numpy as np

from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES, Array, Channel, Recording
from tcp_muscle_ros.recording.units import UNITS
from tcp_muscle_ros.recording.yaml_input import number_or_none

SAME_INSTANT = 1e-6  # s: stamps closer than this are one


def drive_of(recording: Recording) -> Channel | None:
    """The recorded input, the applied one before the commanded."""
    for suffix in ('', '_command'):
        for name in DRIVES:
            channel = recording.channels.get(f'{name}{suffix}')
            if channel is not None and len(channel):
                return channel
    return None


def hold(channel: Channel | float, grid: Array) -> Array:
    """The value that holds at each instant: the latest at or before it (the first before the first)."""
    if not isinstance(channel, Channel):
        return np.full(grid.size, channel)
    at = np.searchsorted(channel.time, grid + SAME_INSTANT, side='right')
    at -= 1
    return channel.value[np.maximum(at, 0, out=at)]


def window(channel: Channel, start: float, end: float = np.inf) -> Channel:
    """The channel from start to before end, its time from start; an input goes in with the value that holds there."""
    inside = (channel.time >= start) & ((channel.time < end) if end > start else False)
    time, value = channel.time[inside] - start, channel.value[inside]
    if CHANNELS[channel.name].role != 'output':
        before = np.flatnonzero(channel.time < start)
        if before.size and (not time.size or time[0] > 0.0):
            time, value = np.append(0.0, time), np.append(channel.value[before[-1]], value)
    return Channel(channel.name, time, value, channel.topic)


def changes(channel: Channel | float) -> Array:
    """The stamps at which an input takes a new value."""
    if not isinstance(channel, Channel):
        return np.empty(0)
    return np.asarray(channel.time[1:][np.diff(channel.value) != 0.0])


def distance(time: Array, events: Array) -> Array:
    """How far (s) each instant is from the nearest of the events, which are in order; inf without any."""
    if not events.size:
        return np.full(time.size, np.inf)
    after = np.searchsorted(events, time)
    before = np.abs(time - events[np.maximum(after - 1, 0)])
    return np.minimum(before, np.abs(events[np.minimum(after, events.size - 1)] - time))


def stated_ambient(recording: Recording, otherwise: float | None) -> float | None:
    """The room (K) that the recording states in words, else what the user states; not what a thermometer read."""
    stated = number_or_none(recording.known.get('ambient_c'), UNITS['degC'].offset)
    return otherwise if stated is None else stated
