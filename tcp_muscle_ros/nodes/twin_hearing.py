"""What a twin hears of its muscle: messages of one tick put together, with the time at which they came."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.polled import Polled, awaited, take_all
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, MEASUREMENT_QOS, Topics
from tcp_muscle_ros.recording.recording import CHANNELS, OUTPUTS
from tcp_muscle_ros.recording.units import UNITS

HEARD = (*OUTPUTS, 'current', 'load', 'ambient')
_APART = 0.5  # of a period: messages that are further apart belong to two ticks


@dataclass
class Heard:
    """One tick of the muscle: ``time`` (s, of reception), and by channel what was measured or imposed, SI."""

    time: float
    values: dict[str, float] = field(default_factory=dict)


class Hearing:
    """Subscriptions to a muscle's topics. ``period`` s, of whoever takes them."""

    def __init__(self, node: Node, topics: Topics, period: float) -> None:
        self._period = period
        self._early: dict[str, float] = {}  # what belongs to the next tick of a simulation in lockstep
        self._silent: set[str] = set()  # what did not come with such a tick, until it comes again
        group, self._subscriptions = Polled(), []
        for name in HEARD:
            kind = CHANNELS[name]
            message = Temperature if kind.stamped else Float64
            qos = COMMAND_QOS if name == 'load' else MEASUREMENT_QOS
            made = topics.subscription(message, kind.topic, _unused, qos, group)
            self._subscriptions.append((name, message, made, _reader(name)))

    @property
    def topics(self) -> frozenset[str]:
        """What is heard."""
        return frozenset(subscription.topic_name for _, _, subscription, _ in self._subscriptions)

    def ticks(self) -> Iterator[Heard]:
        """What has come since last asked, oldest first. A channel that comes again begins the next tick."""
        events: list[tuple[float, str, float]] = []
        for name, message, subscription, read in self._subscriptions:
            while (got := subscription.handle.take_message(message, False)) is not None:
                value = read(got[0])
                if math.isfinite(value):
                    events.append((got[1]['received_timestamp'] * 1e-9, name, value))
        events.sort()
        heard: Heard | None = None
        for time, name, value in events:
            if heard is not None and (name in heard.values or time - heard.time > _APART * self._period):
                yield heard
                heard = None
            if heard is None:
                heard = Heard(time)
            heard.values[name] = value
        if heard is not None:
            yield heard

    def tick(self, time: float, sent: int) -> Heard:
        """All of one tick of a simulation in lockstep, whose time (s) it is; it was sent then (ns)."""
        heard = Heard(time, self._early)
        self._early = {}

        def take() -> set[str]:
            spoke = set()
            for name, message, subscription, read in self._subscriptions:
                while (got := subscription.handle.take_message(message, False)) is not None:
                    spoke.add(subscription.topic_name)
                    value = read(got[0])
                    if math.isfinite(value):
                        (self._early if got[1]['source_timestamp'] > sent else heard.values)[name] = value
            self._silent -= spoke
            return spoke

        wanted = {one.topic_name for _, _, one, _ in self._subscriptions if awaited(one)}
        self._silent |= take_all(take, wanted - self._silent)
        return heard


def _reader(name: str) -> Callable[[Any], float]:
    unit = UNITS[CHANNELS[name].unit]
    if CHANNELS[name].stamped:
        return lambda message: unit.to_si(float(message.temperature))
    return lambda message: float(message.data)


def _unused(_: object) -> None:
    """Messages are taken from the subscription, no callback runs."""
