"""Two nodes that publish one measurement, as a simulation that was left running does: a recording would mix both, and a
controller goes by now the one and now the other."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

from tcp_muscle_ros.nodes.topics import REMEMBERED, Commanders, name_of, published_by
from tcp_muscle_ros.recording.recording import CHANNELS

_MEASURED = {channel.topic for channel in CHANNELS.values() if channel.role == 'output'}


def mixed(topic: str, publishers: Sequence[TopicEndpointInfo]) -> str:
    """What is told of the publishers of a topic; '' where there is one, or where it is no measurement."""
    if len(publishers) < 2 or topic.rpartition('/')[2] not in _MEASURED:
        return ''
    by = published_by(topic, map(name_of, publishers))
    return f'{by}: what is recorded mixes them, unless one was killed just now'


class Mixing:
    """What is mixed of the measurements that a node goes by, looked at now and then: no node that was killed counts."""

    def __init__(self) -> None:
        self._publishers: defaultdict[str, Commanders] = defaultdict(Commanders)
        self._told: dict[str, str] = {}

    def look(self, node: Node, topics: Iterable[str], tell: Callable[[str], object]) -> Sequence[str]:
        """What is to be said; what was not there at the last look is told."""
        found = {}
        for topic in topics:
            if node.count_publishers(topic) < 2:  # who it is takes a walk through the graph
                self._publishers.pop(topic, None)
                continue
            names = self._publishers[topic].standing(node, [topic], REMEMBERED)
            if len(names) > 1:
                found[topic] = f'{published_by(topic, names)}: what is measured mixes them; stop all but one'
        for topic, sentence in found.items():
            if self._told.get(topic) != sentence:
                tell(sentence)
        self._told = found
        return list(found.values())
