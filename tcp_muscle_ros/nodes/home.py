"""What muscles and joints ask of the node that they live in."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol

from rclpy.qos import QoSProfile

from tcp_muscle_ros.nodes.serialized import SerializedPublisher
from tcp_muscle_ros.nodes.topics import Topics


class Home(Protocol):
    """Of any node of this package."""

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """What callbacks and ticks exclude each other by."""

    @property
    def period(self) -> float:
        """From tick to tick, s."""

    def seconds(self) -> float:
        """The time that watchdogs go by, s."""

    def listen(self, kind: type, topic: str, take: Any, qos: QoSProfile) -> None:
        """Have the messages of a topic taken."""

    @property
    def topics(self) -> Topics:
        """What makes its publishers and subscriptions."""

    @property
    def unmatched(self) -> Mapping[str, str]:
        """By topic, who there cannot be reached and why."""

    def resolve_topic_name(self, topic: str) -> str:
        """rclpy's own."""

    def get_logger(self) -> Any:
        """rclpy's own."""

    def get_fully_qualified_name(self) -> str:
        """rclpy's own."""


class SimHome(Home, Protocol):
    """Of the node that steps its muscles together."""

    def stamped(self, topic: str, message: Any, *fields: str) -> tuple[SerializedPublisher, list[memoryview[float]]]:
        """A topic whose message has the stamp of the tick, and where its fields are."""

    def gather(self) -> None:
        """Step the muscles together as they now are."""


class ControlHome(Home, Protocol):
    """Of the node that has a controller for each muscle."""

    @property
    def out_of_step(self) -> Mapping[str, str]:
        """By topic, why nothing may be built on what is said there."""

    def renew(self, muscle: Any) -> None:
        """A muscle has other values: so has the joint that it turns."""
