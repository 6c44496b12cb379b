"""The wanted numbers of one topic, decoded while a bag is read: its messages are not kept."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype

from tcp_muscle_ros.recording.cdr import FieldPath, Index, decode
from tcp_muscle_ros.recording.recording import Array
from tcp_muscle_ros.recording.storage import StoredMessages
from tcp_muscle_ros.recording.tick_times import OTHER_CLOCK_NS, clock_offset

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

_SECOND_NS = 1_000_000_000
_SOME = 10_001  # messages that tell how far two clocks are apart


class _Growing:
    """Numbers that come some at a time and are kept in one place: parts that are joined at the end would, for a moment,
    be there twice."""

    def __init__(self, dtype: type) -> None:
        self._bytes, self._dtype = bytearray(), np.dtype(dtype)

    def add(self, numbers: NDArray[Any]) -> None:
        self._bytes += np.ascontiguousarray(numbers, self._dtype).view(np.uint8).data

    def whole(self) -> NDArray[Any]:
        return np.frombuffer(self._bytes, self._dtype)


def _following(stamp: Index, log: Index, at: Index) -> Index:
    """Of some messages the next stamp in the order of the log that is not 0 (behind the last, the last)."""
    if not np.all(log[1:] >= log[:-1]):
        order = np.argsort(log, kind='stable')
        stamp, at = stamp[order], np.flatnonzero(np.isin(order, at))
        at = at[np.argsort(order[at])]
    good = np.flatnonzero(stamp)
    return np.asarray(stamp[good[np.minimum(np.searchsorted(good, at), len(good) - 1)]])


class Topic:
    """What is wanted of one topic's messages, in the order of the log: log times and header stamps (None without), ns;
    each field's numbers, and where it has any; how many messages do not parse."""

    def __init__(self, kind: str, types: 'Typesdict', paths: Mapping[str, FieldPath]) -> None:
        self._kind, self._types, self.paths = kind, types, paths
        self.stamped = ('header', (Nodetype.NAME, 'std_msgs/msg/Header')) in types[kind][1]
        self._log, self._stamp = _Growing(np.int64), _Growing(np.int64)
        self._fields = {channel: (_Growing(np.float64), _Growing(np.bool_)) for channel in paths}
        self.broken = 0
        self.unset = 0  # messages stamped 0 among others that are not, once `stamp` was asked for

    def add(self, messages: StoredMessages) -> None:
        """Decode some messages more."""
        stamp: list[FieldPath] = [('header', 'stamp', 'sec'), ('header', 'stamp', 'nanosec')]
        own = len(stamp) if self.stamped else 0
        decoded = decode(self._types, self._kind, messages.payloads, [*stamp[:own], *self.paths.values()])
        if self.stamped:
            sec, nanosec = (np.nan_to_num(column).astype(np.int64) for column in decoded.values[:own])
            self._stamp.add(sec * _SECOND_NS + nanosec)
        self._log.add(messages.log_time)
        for k, (values, present) in enumerate(self._fields.values(), own):
            values.add(decoded.values[k])
            present.add(decoded.present[k])
        self.broken += decoded.broken

    @property
    def log(self) -> Index:
        """When each message was logged."""
        return self._log.whole()

    @property
    def stamp(self) -> Index | None:
        """The header stamps, the log time for a single one that is 0; None where there are none, or all are 0."""
        stamp = self._stamp.whole()
        zero = np.flatnonzero(stamp == 0)
        if len(zero) == len(stamp):
            return None
        if not len(zero):
            return stamp
        log = self.log
        some = np.linspace(0, len(stamp) - 1, min(len(stamp), _SOME)).astype(np.int64)
        some = some[stamp[some] != 0] if stamp[some].any() else np.flatnonzero(stamp)
        time = log[zero] + clock_offset(log[some], stamp[some])
        wrong = (np.abs(time) > OTHER_CLOCK_NS) & (np.abs(_following(stamp, log, zero)) > OTHER_CLOCK_NS)
        self.unset = int(np.count_nonzero(wrong))
        if self.unset:
            stamp = stamp.copy()
            stamp[zero[wrong]] = time[wrong]
        return stamp

    def field(self, channel: str) -> tuple[Array, NDArray[np.bool_]]:
        """The numbers of a channel's field, and where it has any. Once: they are not kept any longer."""
        values, present = self._fields.pop(channel)
        return values.whole(), present.whole()
