"""Subscriptions whose messages are taken where they are wanted, not as they come."""

import time
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.subscription import Subscription

from tcp_muscle_ros.nodes.topics import EVERY_TICK

_LATE = 1.0  # s, within which what belongs to a tick arrives
_TURN = 5e-5  # s between two looks for it


class Polled(CallbackGroup):  # type: ignore[misc]
    """Subscriptions that the executor leaves alone: the ticks look for their messages themselves.

    An executor takes 10 us an entity each time that anything wakes it: with the inputs of 16 muscles, more than all
    the rest of a tick. To look into an empty queue takes less than 1 us.
    """

    def can_execute(self, entity: object) -> bool:
        """Never, by an executor."""
        return False

    def beginning_execution(self, entity: object) -> bool:
        """Never, by an executor."""
        return False

    def ending_execution(self, entity: object) -> None:
        """Nothing was begun."""


def awaited(subscription: Subscription) -> bool:
    """Whether somebody publishes there in every tick."""
    return subscription.topic_name.rpartition('/')[2] in EVERY_TICK and subscription.get_publisher_count() > 0


def take_all(take: Callable[[], Iterable[str]], wanted: Iterable[str]) -> set[str]:
    """Take until something of each wanted topic has come; returns what did not come within a second.

    ``take`` takes what is there, and says of which topics.
    """
    lacking = set(wanted) - set(take())
    begun = time.monotonic()
    while lacking and time.monotonic() - begun < _LATE:
        time.sleep(_TURN)
        lacking -= set(take())
    return lacking


class Inputs:
    """The polled subscriptions of a node, in the order in which they were made."""

    def __init__(self) -> None:
        self.group = Polled()
        self._inputs: list[tuple[Subscription, type, Callable[[Any], None]]] = []
        self._silent: set[str] = set()  # what did not come with its tick, until it comes again
        self._early: list[tuple[str, Callable[[Any], None], Any]] = []  # topic, who takes what of the next tick

    def add(self, subscription: Subscription, kind: type, take: Callable[[Any], None]) -> None:
        """A subscription of the group, and who takes its messages."""
        self._inputs.append((subscription, kind, take))

    def take(self, before: int | None = None) -> set[str]:
        """Hand over what has come, or of it what was sent before (ns); the topics that spoke.

        A topic of which something later has come spoke as well: of what was sent before nothing more is under way.
        """
        spoke = self._take_early() if before is None else set[str]()
        for subscription, kind, take in self._inputs:
            while (got := subscription.handle.take_message(kind, False)) is not None:
                spoke.add(subscription.topic_name)
                if before is not None and got[1]['source_timestamp'] > before:
                    self._early.append((subscription.topic_name, take, got[0]))
                else:
                    take(got[0])
        self._silent -= spoke
        return spoke

    def take_tick(self, sent: int) -> set[str]:
        """Hand over all that belongs to a tick, which was sent then (ns).

        Returns the topics that should have spoken with it and did not, each only once.
        """
        early = self._take_early()
        wanted = {one.topic_name for one, _, _ in self._inputs if awaited(one)}
        lacking = take_all(lambda: self.take(sent), wanted - self._silent - early)
        self._silent |= lacking
        return lacking

    def _take_early(self) -> set[str]:
        early, self._early = self._early, []
        for _, take, message in early:
            take(message)
        return {topic for topic, _, _ in early}
