"""The time in which a protocol is played: the system's, or that of a simulation in lockstep. In s."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rclpy.node import Node

from tcp_muscle_ros.nodes.lockstep import TICK, FollowingTime
from tcp_muscle_ros.nodes.ticks import SECOND
from tcp_muscle_ros.nodes.topics import Topics, publishers_of

_TURN = 0.01  # s between two looks at what came


class RealTime:
    """The steady time. ``take`` takes what has come."""

    def __init__(self, take: Callable[[], object]) -> None:
        self._take = take

    def now(self) -> float:
        """The time."""
        return time.monotonic()

    def soon(self) -> float:
        """When something may begin."""
        return self.now() + _TURN

    def turn(self) -> None:
        """Wait a little, and take what came."""
        time.sleep(_TURN)
        self._take()

    def reached(self, due: float) -> bool:
        """Whether it is due; if not, a turn has passed."""
        remaining = due - time.monotonic()
        if remaining > 2.0 * _TURN:
            self.turn()
            return False
        if remaining > 0.0:
            time.sleep(remaining)
        return True

    @property
    def lost(self) -> str:
        """Why nobody may count on it any more, '' where one may."""
        return ''


class LockstepTime:
    """The time of a simulation that waits for this node. ``take`` takes what belongs to the tick sent then (ns)."""

    def __init__(self, node: Node, take: Callable[[int], None]) -> None:
        self._following = FollowingTime(node, take)
        self._following.open(Topics(node))
        self._anew = False

    @property
    def tick(self) -> int:
        """The present tick, ns."""
        return self._following.now()

    def now(self) -> float:
        """The time."""
        return self.tick / SECOND

    def soon(self) -> float:
        """When something may begin: at this tick, so that it keeps step with all that follow."""
        return self.now()

    def turn(self) -> None:
        """Wait for the next tick, up to 0.1 s."""
        self._follow(self.tick + SECOND)

    def reached(self, due: float) -> bool:
        """Whether it is due; if not, a tick has passed, or 0.1 s."""
        return self._follow(round(due * SECOND))

    def _follow(self, until: int) -> bool:
        before = self.tick if self._following.collects else 0
        there = self._following.follow(until)
        self._anew |= self._following.collects and self.tick < before
        return there

    @property
    def lost(self) -> str:
        """Why nobody may count on it any more, '' where one may."""
        if self._anew:
            return 'the simulation began anew'
        alive = self._following.led and not self._following.stands_still()
        return '' if alive else 'the simulation stands still'


def leads(node: Node, topics: Iterable[str]) -> bool:
    """Whether a simulation in lockstep publishes on these topics."""
    leaders = publishers_of(node, TICK)
    return any(leaders & publishers_of(node, topic) for topic in topics if leaders)
