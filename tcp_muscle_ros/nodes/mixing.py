"""Two nodes that publish one measurement, as a simulation that was left running does: a recording would mix both."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.topic_endpoint_info import TopicEndpointInfo

from tcp_muscle_ros.recording.recording import CHANNELS

_MEASURED = {channel.topic for channel in CHANNELS.values() if channel.role == 'output'}


def mixed(topic: str, publishers: Sequence[TopicEndpointInfo]) -> str:
    """What is told of the publishers of a topic; '' where there is one, or where it is no measurement."""
    if len(publishers) < 2 or topic.rpartition('/')[2] not in _MEASURED:
        return ''
    names = sorted(f'{each.node_namespace.rstrip("/")}/{each.node_name}' for each in publishers)
    told = f'{topic} is published by {" and by ".join(names)}'
    return f'{told}: what is recorded mixes them, unless one was killed just now'
