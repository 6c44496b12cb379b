"""Lockstep: a simulation that waits, at each of its ticks, until the nodes beside it have done theirs.

``sim_node`` leads where it runs at another pace than real time. When all of a tick is published it says so on
``/lockstep/tick``; a node with ``use_sim_time`` that hears it does its own work up to that time, publishes what comes
of it, and then the same stamp on ``/lockstep/done``, with its name as ``frame_id``. A node that has said so once is
waited for from then on: what it commands by the tick at t_k is there when the simulation goes on to t_{k+1}, however
fast or slow either is. A node of somebody else's takes part in the same way: one subscription, one publisher.

What a peer says during a tick counts from the next one on, whoever hears it: all do their ticks at once, and by the
times of sending it is the same in every run. Within one participant messages arrive in the order in which they were
sent, whatever their topics; beside that, what is published in every tick is waited for (``polled.Inputs``).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Header

from tcp_muscle_ros.nodes.polled import Polled
from tcp_muscle_ros.nodes.serialized import StampPublisher
from tcp_muscle_ros.nodes.ticks import NO_CLOCK, SECOND, STANDS_STILL, RosTime, ScaledTime, TimeBase
from tcp_muscle_ros.nodes.topics import REMEMBERED, Topics, name_of, published_by, publishers_of

TICK, DONE, CLOCK = '/lockstep/tick', '/lockstep/done', '/clock'
LOCKSTEP_QOS = QoSProfile(depth=100)  # reliable
_CLOCK_QOS = QoSProfile(depth=1)
_SLICE = 0.1  # s, in which a wait looks whether it is still wanted
_STALLED = 10.0  # s of silence, after which a leader is no more believed to compile or to wait for somebody else
_EXPECTED = 1.0  # s, that a tick may take
_ROUNDING = 2  # ns, by which two nodes' multiples of one period may differ


class _Inbox:
    """The messages of one topic, waited for in the thread that wants them: an executor would take three times as long.

    rclpy waits so itself in ``wait_for_message``.
    """

    def __init__(self, node: Node, topics: Topics, topic: str) -> None:
        self.subscription: Subscription = topics.subscription(Header, topic, _unused, LOCKSTEP_QOS, Polled())
        self._wait_set = _rclpy.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    def next(self, timeout: float) -> tuple[Header, int] | None:
        """The next message and when it was sent (ns), waited for up to ``timeout`` s; None where none came."""
        handle = self.subscription.handle
        taken = handle.take_message(Header, False)
        if taken is None and timeout > 0.0:
            self._wait_set.clear_entities()
            self._wait_set.add_subscription(handle)
            self._wait_set.wait(round(timeout * SECOND))
            taken = handle.take_message(Header, False)
        return None if taken is None else (taken[0], taken[1]['source_timestamp'])


class _Leaders:
    """Who publishes ``/clock``: one node may. One that was killed is still believed to be there for a while."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._alone = time.monotonic()  # s: when there was no second one
        self._told = ''

    def look(self) -> str:
        """What to say of several; '' where there is one. Asks the graph."""
        names = publishers_of(self._node, CLOCK) if self._node.count_publishers(CLOCK) > 1 else set[str]()
        if len(names) < 2:
            self._alone, self._told = time.monotonic(), ''
            return ''
        return f'{published_by(CLOCK, names)}: stop all but one, or give each its domain'

    def standing(self) -> str:
        """The same of those that live, as far as anybody knows; logged once."""
        told = self.look()
        if time.monotonic() - self._alone <= REMEMBERED:
            return ''
        if told != self._told:
            self._told = told
            self._node.get_logger().warning(told)
        return told


class LeadingTime(ScaledTime):
    """Simulated time of a node that publishes ``/clock``, and goes on when its peers have done the present tick.

    Args:
        node: whose time it is.
        factor: simulated seconds a second at most; 0: as fast as it goes.
        expected: peers that must be there before the first tick.
        patience: s, after which a peer that does not answer is waited for no more.
    """

    def __init__(self, node: Node, factor: float, expected: int, patience: float) -> None:
        super().__init__(factor)
        self._node, self._expected, self._patience = node, expected, patience
        self._leaders = _Leaders(node)
        self._done: dict[str, int] = {}  # ns, the last tick that each peer has done
        self._waits: tuple[float, str] | None = None  # since when (s, steady), for whom

    def open(self, topics: Topics) -> None:
        """Make the topics; after all others of the node, so that who has discovered them has discovered all."""
        header = Header(frame_id=self._node.get_fully_qualified_name())
        self._tick = StampPublisher(topics.publisher(Header, TICK, LOCKSTEP_QOS), header)
        self._clock = StampPublisher(topics.publisher(ClockMessage, CLOCK, _CLOCK_QOS), ClockMessage())
        self._inbox = _Inbox(self._node, topics, DONE)

    def begin(self, stop: threading.Event) -> None:
        """Return when the peers that are expected are there, and hear what they wait for."""
        begun = said = time.monotonic()
        while not stop.is_set():
            self._hear(_SLICE if self._expected else 0.0)
            if min(len(self._done), self._tick.publisher.get_subscription_count()) >= self._expected:
                break
            self._waits = begun, f'{self._expected} nodes; there: {", ".join(sorted(self._done)) or "none"}'
            if time.monotonic() - said > self._patience:
                said = time.monotonic()
                self._node.get_logger().warning(f'lockstep: waiting for {self._waits[1]}')
        self._waits = None

    def wait(self, until: int, stop: threading.Event) -> None:
        """Have the present tick done by all peers, then as ScaledTime."""
        if self.now() > 0 and (self._done or self._tick.publisher.get_subscription_count()):
            self._tick.send(self.now())
            self._wait_for_peers(self.now(), stop)
        super().wait(until, stop)
        self._clock.send(until)

    def _hear(self, timeout: float) -> bool:
        """Take one answer; whether there was one."""
        taken = self._inbox.next(timeout)
        if taken is None:
            return False
        message, _ = taken
        if message.frame_id not in self._done:
            self._node.get_logger().info(f'in lockstep with {message.frame_id}')
        self._done[message.frame_id] = message.stamp.sec * SECOND + message.stamp.nanosec
        return True

    def _wait_for_peers(self, tick: int, stop: threading.Event) -> None:
        while self._hear(0.0):
            pass
        begun = time.monotonic()
        while not stop.is_set() and (late := [name for name, done in self._done.items() if done != tick]):
            self._waits = begun, ', '.join(late)
            if self._hear(_SLICE):  # also of another's ticks, where two lead
                continue
            self.forget_who_is_gone()
            if time.monotonic() - begun > self._patience:
                for name in late:
                    self._done.pop(name, None)
                self._node.get_logger().warning(
                    f'lockstep: {", ".join(late)} did not answer the tick at {tick / SECOND:g} s within '
                    f'{self._patience:g} s and is no longer waited for'
                )
        self._waits = None

    def held_up(self) -> str:
        """For whom, where it is longer than a tick should take, and who leads beside it; asked by another thread.

        Of two that lead each has its peers answer the other's ticks.
        """
        since, whom = self._waits or (time.monotonic(), '')
        waited, standing = time.monotonic() - since, self._leaders.standing()
        if waited <= _EXPECTED:
            return standing
        waits, others = f'lockstep: waiting for {whom} (for {waited:.0f} s)', standing
        if not others and (told := self._leaders.look()):
            others = f'{told}, unless one was killed just now'
        return f'{waits}; {others}' if others else waits

    def forget_who_is_gone(self) -> None:
        """Wait no more for peers that have ended."""
        if self._tick.publisher.get_subscription_count() < len(self._done):
            there = {name_of(one) for one in self._node.get_subscriptions_info_by_topic(TICK)}
            for name in self._done.keys() - there:
                del self._done[name]
                self._node.get_logger().info(f'lockstep: {name} is gone')


class FollowingTime(RosTime):
    """The time on /clock; where a simulation leads in lockstep, that of its ticks.

    A tick counts as done when the work asks for a later time than it has reached.

    Args:
        node: whose time it is.
        collect: takes the inputs that belong to a tick, which are those sent before it; called when it has come, with
            the time (ns, of the system) at which it was sent.
    """

    def __init__(self, node: Node, collect: Callable[[int], None]) -> None:
        super().__init__(node.get_clock())
        self._node, self._collect = node, collect
        self._leaders = _Leaders(node)
        self._now = 0  # ns; 0: no tick was heard
        self._tick = self._answered = 0
        self._came = self._looked = time.monotonic()
        self._elapsed = 0.0

    def open(self, topics: Topics) -> None:
        """Make the topics; see LeadingTime."""
        self._inbox = _Inbox(self._node, topics, TICK)
        header = Header(frame_id=self._node.get_fully_qualified_name())
        self._done = StampPublisher(topics.publisher(Header, DONE, LOCKSTEP_QOS), header)

    @property
    def led(self) -> bool:
        """Whether a simulation leads."""
        led: bool = self._inbox.subscription.get_publisher_count() > 0
        return led

    @property
    def collects(self) -> bool:
        """Whether inputs are taken when a tick comes, and not at the node's own."""
        return self._now > 0 and self.led

    def now(self) -> int:
        """The time."""
        return self._now if self.collects else super().now()

    def seconds(self) -> float:
        """Steady time; in lockstep the simulated, so that no watchdog counts what either waits for."""
        now = time.monotonic()
        if not self.collects:
            self._elapsed += now - self._looked
        self._looked = now
        return self._elapsed

    def stands_still(self) -> bool:
        """Whether nothing was heard of the time for so long that nobody may count on the next tick."""
        return time.monotonic() - self._came > _STALLED if self.collects else super().stands_still()

    def held_up(self) -> str:
        """Whether several give the time, between which it would go back and forth."""
        return self._leaders.standing()

    def wait(self, until: int, stop: threading.Event) -> None:
        """Return when it is ``until``; see TimeBase."""
        while not stop.is_set():
            if self.follow(until) if self.led else self._look_at_clock(until):
                return

    def follow(self, until: int) -> bool:
        """One look at the ticks, of up to 0.1 s: whether it is ``until`` or was set back. A tick before is answered."""
        if self._tick and self._now >= until - _ROUNDING:
            self._now = max(self._now, until)
            return True
        if self._answered != self._tick or not self._tick:
            self._answered = self._tick
            self._done.send(self._tick)
        taken = self._inbox.next(_SLICE)
        while (later := self._inbox.next(0.0)) is not None:  # it joins in the middle
            taken = later
        if taken is None:
            return False
        message, sent = taken
        before, self._tick = self._tick, message.stamp.sec * SECOND + message.stamp.nanosec
        self._now, self._came = self._tick, time.monotonic()
        self._elapsed += max(self._tick - before, 0) / SECOND
        self._collect(sent)
        return self._tick < before


def timeless(base: TimeBase) -> str:
    """Why there is no time to keep to; '' where there is. Asked once a second."""
    if not isinstance(base, RosTime):
        return ''
    if base.now() == 0:
        return NO_CLOCK
    return STANDS_STILL if base.stands_still() else ''


def out_of_step(node: Node, base: TimeBase, heard: Iterable[str]) -> dict[str, str]:
    """By topic that is heard, why nothing may be built on it: a simulation in lockstep says it, and this node is not.

    A controller that keeps the system's time would command a muscle of which it does not know how fast its time goes.
    """
    leaders = set[str]() if isinstance(base, FollowingTime) else publishers_of(node, TICK)
    if not leaders:
        return {}
    return {
        topic: f'{leader} runs in lockstep and not in real time; start this node with --ros-args -p use_sim_time:=true'
        for topic in heard
        for leader in leaders & publishers_of(node, topic)
    }


def _unused(_: Any) -> None:
    """Messages are taken from the subscription, no callback runs."""
