"""What a twin hears of its muscle: messages of one tick put together, with the time at which they came."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.polled import Inputs
from tcp_muscle_ros.nodes.topics import EVERY_TICK, MEASUREMENT_QOS, Topics
from tcp_muscle_ros.recording.recording import CHANNELS, OUTPUTS
from tcp_muscle_ros.recording.units import UNITS

HEARD = (*OUTPUTS, 'current', 'load', 'ambient')
_APART = 0.5  # of a period: messages that are further apart belong to two ticks

_LOOKS = 100  # at a clock, that are kept: what came before them is long handed out
_SPEAKS = 2.0  # s, within which what is published in every tick comes


@dataclass
class Heard:
    """One tick of the muscle: ``time`` (s, of reception), and by channel what was measured or imposed, SI."""

    time: float
    values: dict[str, float] = field(default_factory=dict)


class _Looks:
    """Looks at a clock that goes at another pace than the system's, which is the one that says when something came."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._looks: deque[tuple[float, float]] = deque(maxlen=_LOOKS)  # s, of the system and of the clock

    def look(self) -> None:
        """Note what time it is by both."""
        look = time.time(), self._clock()
        if self._looks and any(now < before for now, before in zip(look, self._looks[-1], strict=True)):
            self._looks.clear()  # one of them was set back
        self._looks.append(look)

    def time(self, came: float) -> float:
        """The clock's time at one of the system's."""
        system, clock = np.array(self._looks).T
        return float(np.interp(came, system, clock))


class Hearing:
    """Subscriptions to a muscle's topics.

    Args:
        node: who listens.
        topics: what makes the subscriptions.
        period: s, of whoever takes what came.
        clock: the time (s) that ticks are to have; none: the system's.
    """

    def __init__(self, node: Node, topics: Topics, period: float, clock: Callable[[], float] | None = None) -> None:
        self._apart = _APART * period
        self._looks = _Looks(clock) if clock else None
        self._node, self._topics = node, topics
        self._inputs, self._subscriptions = Inputs(), []
        self._spoke: dict[str, float] = {}  # s, steady: when each topic last did, or was first listened to
        self._of_tick: dict[str, float] = {}
        self._young: list[tuple[float, str, float]] = []  # of ticks of which more may be under way
        self._newest = -math.inf  # s, time of the last tick that was handed out
        for name in HEARD:
            kind = CHANNELS[name]
            message = Temperature if kind.stamped else Float64
            made = topics.subscription(message, kind.topic, _unused, MEASUREMENT_QOS, self._inputs.group)
            read = _reader(name)
            self._subscriptions.append((name, message, made, read))
            self._inputs.add(made, message, self._taker(name, made.topic_name, read))
            self._spoke[made.topic_name] = time.monotonic()

    @property
    def topics(self) -> frozenset[str]:
        """What is heard."""
        return frozenset(subscription.topic_name for _, _, subscription, _ in self._subscriptions)

    def silent(self) -> dict[str, float]:
        """By topic that somebody publishes in every tick, for how long (s) nothing of it has come. Asks the graph."""
        now = time.monotonic()
        return {
            topic: now - spoke
            for topic, spoke in self._spoke.items()
            if topic.rpartition('/')[2] in EVERY_TICK and now - spoke > _SPEAKS and self._node.count_publishers(topic)
        }

    def end(self) -> None:
        """Listen no more."""
        for _, _, subscription, _ in self._subscriptions:
            self._topics.forget(subscription)

    def ticks(self) -> list[Heard]:
        """What has come since last asked, oldest first. A channel that comes again begins the next tick.

        A tick that may still be coming in is kept for the next time. Topics are looked at one after another, and on a
        busy machine long after one another: what came on one of them after the look at it would be a tick of its own,
        older than that of the topics looked at later. So what came since the first look is kept. Times run back only
        where the clock was set back.
        """
        if self._looks is not None:
            self._looks.look()
        begun, steady, events = time.time(), time.monotonic(), [*self._young]
        for name, message, subscription, read in self._subscriptions:
            while (got := subscription.handle.take_message(message, False)) is not None:
                value = read(got[0])
                self._spoke[subscription.topic_name] = steady
                if math.isfinite(value):
                    events.append((got[1]['received_timestamp'] * 1e-9, name, value))
        ended = time.time()
        if self._newest > ended:  # the clock was set back
            self._newest = -math.inf
        events.sort(key=lambda event: (event[0] <= ended, event))  # first what seems to be still to come: it was before
        self._young, over = [], []
        for tick in _parted(events, self._apart):
            first = tick[0][0]
            if begun - self._apart < first <= ended:
                self._young += tick
            elif first > self._newest:  # else under way for longer than anybody waited for it: its tick is over
                self._newest = first
                over.append(Heard(self._time(first), {name: value for _, name, value in tick}))
        return over

    def _time(self, came: float) -> float:
        return came if self._looks is None else self._looks.time(came)

    def tick(self, time: float, sent: int) -> Heard:
        """All of one tick of a simulation in lockstep, whose time (s) it is; it was sent then (ns)."""
        self._of_tick = {}
        self._inputs.take_tick(sent)
        return Heard(time, self._of_tick)

    def _taker(self, name: str, topic: str, read: Callable[[Any], float]) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            self._spoke[topic] = time.monotonic()
            value = read(message)
            if math.isfinite(value):
                self._of_tick[name] = value

        return take


def _parted(events: list[tuple[float, str, float]], apart: float) -> list[list[tuple[float, str, float]]]:
    """What came, parted into ticks; ``apart`` s."""
    ticks: list[list[tuple[float, str, float]]] = []
    for event in events:
        came, name, _ = event
        if not ticks or name in (one for _, one, _ in ticks[-1]) or abs(came - ticks[-1][0][0]) > apart:
            ticks.append([])
        ticks[-1].append(event)
    return ticks


def _reader(name: str) -> Callable[[Any], float]:
    unit = UNITS[CHANNELS[name].unit]
    if CHANNELS[name].stamped:
        return lambda message: unit.to_si(float(message.temperature))
    return lambda message: float(message.data)


def _unused(_: object) -> None:
    """Messages are taken from the subscription, no callback runs."""
