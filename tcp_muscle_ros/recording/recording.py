"""What was recorded: channels, each on its own time stamps, in SI units."""

import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tcp_muscle_ros.errors import BadInput, Option, nearest

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_Numbers = TypeVar('_Numbers', bound=NDArray[Any])


@dataclass(frozen=True)
class ChannelKind:
    """One channel of a muscle and the topic that carries it.

    ``unit`` is the unit on the topic and in files (see ``units.UNITS``); inside a Recording every value is SI.
    ``stamped``: the topic is a sensor_msgs/Temperature, otherwise a std_msgs/Float64.
    """

    name: str
    topic: str
    unit: str
    role: str
    stamped: bool = False

    @property
    def message_type(self) -> str:
        """The type of the messages on its topic."""
        return 'sensor_msgs/msg/Temperature' if self.stamped else 'std_msgs/msg/Float64'


CHANNELS: Mapping[str, ChannelKind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            ChannelKind('current', 'current', 'A', 'input'),
            ChannelKind('power', 'power', 'W', 'input'),
            ChannelKind('voltage', 'voltage', 'V', 'input'),
            ChannelKind('load', 'load', 'N', 'input'),
            ChannelKind('ambient', 'ambient_temperature', 'degC', 'input', stamped=True),
            ChannelKind('current_command', 'current_command', 'A', 'commanded'),
            ChannelKind('power_command', 'power_command', 'W', 'commanded'),
            ChannelKind('voltage_command', 'voltage_command', 'V', 'commanded'),
            ChannelKind('displacement_setpoint', 'displacement_setpoint', 'm', 'commanded'),
            ChannelKind('temperature', 'temperature', 'degC', 'output', stamped=True),
            ChannelKind('resistance', 'resistance', 'ohm', 'output'),
            ChannelKind('displacement', 'displacement', 'm', 'output'),
            ChannelKind('force', 'force', 'N', 'output'),
        )
    }
)
LARGEST = 1e30  # of a value, whose cube a float still holds; more is damaged, or stands for none
DRIVES = ('current', 'power', 'voltage')
OUTPUTS = tuple(kind.name for kind in CHANNELS.values() if kind.role == 'output')
# A CSV file does not say when it was made. Its bag starts at a round number, 9 September 2001: not 0, which means "no
# stamp" in ROS, and not today, so that the same file always gives the same bag.
UNDATED_NS = 1_000_000_000 * 1_000_000_000


def shared(new: _Numbers, others: Iterable[_Numbers]) -> _Numbers:
    """The one of the others that is equal, if any: most channels have their samples at the same ticks."""
    return next((other for other in others if np.array_equal(new, other)), new)


def channel_kind(name: str, where: str | Option) -> ChannelKind:
    """The kind of a channel by its name or that of its topic. BadInput, begun with `where`, for an unknown one."""
    kind = CHANNELS.get(name) or next((kind for kind in CHANNELS.values() if kind.topic == name), None)
    if kind is None:
        raise BadInput(where, f": unknown channel '{name}'{nearest(name, CHANNELS)}")
    return kind


@dataclass(frozen=True)
class Channel:
    """One measured or applied quantity.

    time   float64[n], s from the recording's start, strictly increasing
    value  float64[n], SI (K, ohm, m, N, A, V, W), finite; an input stamped t_k holds from t_k until t_{k+1}
    topic  where it came from
    """

    name: str
    time: Array
    value: Array
    topic: str

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True)
class Recording:
    """One recording of one muscle.

    start_ns  the time that every channel counts from, ns since the epoch of the clock that stamped the bag
    known     what was written down about the run (load, rest length, end ...), free keys
    notes     what the reader had to mend or leave out, one sentence each
    units     in which a channel's numbers were taken to be, where that may not be the contract's
    broken    what the reader saw that no model can follow, one sentence each
    """

    path: str
    channels: Mapping[str, Channel]
    start_ns: int
    known: Mapping[str, object] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    broken: tuple[str, ...] = ()

    def unit(self, name: str) -> str:
        """In which a channel's numbers were taken to be."""
        return self.units.get(name, CHANNELS[name].unit)

    def __getitem__(self, name: str) -> Channel:
        try:
            return self.channels[name]
        except KeyError:
            raise BadInput(f"{self.path}: no channel '{name}' recorded{nearest(name, self.channels)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    @cached_property
    def fingerprint(self) -> str:
        """What tells it from any other, whatever its file is called and says of a date: its readings, in single
        precision, as a conversion of units and back rounds. Not its inputs alone: those of one protocol are equal."""
        digest = hashlib.sha256()
        for name in sorted(self.channels):
            digest.update(name.encode())
            digest.update((self.channels[name].value + 0.0).astype('<f4').tobytes())  # 0 for -0 too
        return digest.hexdigest()[:16]

    @property
    def duration(self) -> float:
        """From the start to the last sample of any channel, s."""
        return self._last(self.channels)

    @property
    def end(self) -> float:
        """Of what is observed of the muscle, s from the start."""
        return self._last(OUTPUTS)

    def _last(self, names: Collection[str]) -> float:
        found = (self.channels[name] for name in names if name in self.channels)
        return max((float(channel.time[-1]) for channel in found if len(channel)), default=0.0)
