"""Topics that send one message over and over, with other numbers in it."""

from __future__ import annotations

import math
import struct
from typing import Any

from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64

_CONTENT = 4  # the first byte after those that say how a message is encoded
_MARK = math.pi  # in no message by itself, so that its bytes are found where it was put


class SerializedPublisher:
    """Sends a message that is kept serialised: numbers are written where they are, nothing else is touched.

    rclpy converts a message field by field at each publication, which is most of what publishing takes. Here the
    middleware serialises it once; where a number is in that is learnt by putting a mark there.
    """

    def __init__(self, publisher: Publisher, message: Any) -> None:
        self.publisher, self._message = publisher, message
        self._bytes = bytearray(serialize_message(message))

    def numbers(self, field: str) -> memoryview[float]:
        """Where the float64[n] of a field are, to be written to: one number, or a sequence as long as the message's."""
        value = getattr(self._message, field)
        marks = _MARK if isinstance(value, float) else [_MARK] * len(value)
        setattr(self._message, field, marks)
        count = 1 if isinstance(value, float) else len(value)
        start = bytes(serialize_message(self._message)).index(struct.pack(f'{count}d', *[_MARK] * count))
        setattr(self._message, field, value)
        return memoryview(self._bytes)[start : start + 8 * count].cast('d')

    def stamp(self) -> memoryview[int]:
        """Where sec and nanosec are, of a message that begins with a stamp or a header."""
        return memoryview(self._bytes)[_CONTENT : _CONTENT + 8].cast('i')

    def publish(self) -> None:
        """Send it as it is."""
        self.publisher.publish(bytes(self._bytes))


class NumberPublisher(SerializedPublisher):
    """Sends one number: a Float64."""

    def __init__(self, publisher: Publisher) -> None:
        super().__init__(publisher, Float64())
        self._number = self.numbers('data')

    def send(self, value: float) -> None:
        """Send a number."""
        self._number[0] = value
        self.publish()


class StampPublisher(SerializedPublisher):
    """Sends one time: a message that begins with a stamp or a header, and says nothing else that changes."""

    def __init__(self, publisher: Publisher, message: Any) -> None:
        super().__init__(publisher, message)
        self._stamp = self.stamp()

    def send(self, time: int) -> None:
        """Send a time, ns."""
        self._stamp[0], self._stamp[1] = divmod(time, 1_000_000_000)
        self.publish()
