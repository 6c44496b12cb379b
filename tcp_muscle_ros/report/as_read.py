"""How people read each channel: its name on an axis, its unit, and the numbers from SI."""

from typing import NamedTuple

from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import OUTPUTS


class _Read(NamedTuple):
    """``factor`` times the SI value plus ``offset``, in ``unit``; a difference of two values is in ``difference``."""

    name: str
    unit: str
    factor: float = 1.0
    offset: float = 0.0
    difference: str = ''


_CHANNELS = {
    'temperature': _Read('temperature', 'degC', offset=-ZERO_CELSIUS, difference='K'),
    'resistance': _Read('resistance', 'ohm'),
    'displacement': _Read('contraction', 'mm', 1e3),
    'force': _Read('force', 'mN', 1e3),
    'current': _Read('current', 'A'),
    'power': _Read('power', 'W'),
    'voltage': _Read('voltage', 'V'),
    'load': _Read('load', 'N'),
    'ambient': _Read('ambient', 'degC', offset=-ZERO_CELSIUS, difference='K'),
}
CHANNEL_AXIS = {channel: f'{read.name} ({read.unit})' for channel, read in _CHANNELS.items()}
# Errors and other differences of what is observed: unit, and factor from SI.
SHOWN = {name: (read.difference or read.unit, read.factor) for name, read in _CHANNELS.items() if name in OUTPUTS}


def shown(channel: str, value: Array) -> Array:
    """SI values of a channel as people read them; of anything else, SI."""
    read = _CHANNELS.get(channel, _Read(channel, ''))
    return value * read.factor + read.offset
