"""Where muscles are that nobody asked for: what a command that hears none can say."""

import time

import rclpy
from rclpy.context import Context
from rclpy.node import Node

from tcp_muscle_ros.recording.recording import CHANNELS, OUTPUTS

_MEASURED = {CHANNELS[name].topic for name in OUTPUTS}
_DISCOVERED_S, _OTHERS_S = 6.0, 1.0  # until the first is discovered, at most, and then the others


def elsewhere(node: Node, namespace: str) -> str:
    """Under which other namespaces muscles publish, as the end of a sentence; '' where none does."""
    found = sorted(_namespaces(node) - {_plain(namespace)})
    return f'; there are muscles under {", ".join(name or "/" for name in found)} (--namespace)' if found else ''


def look_elsewhere(namespace: str) -> str:
    """The same, looked up by a node of its own; '' also where a muscle publishes under ``namespace``."""
    context = Context()
    rclpy.init(args=[], context=context)
    try:
        node = Node('tcp_muscle_look', context=context, enable_rosout=False, start_parameter_services=False)
        until = time.monotonic() + _DISCOVERED_S
        while not _namespaces(node) and time.monotonic() < until:
            time.sleep(0.1)
        time.sleep(_OTHERS_S)  # they are discovered one by one
        found = _namespaces(node)
        told = '' if _plain(namespace) in found else elsewhere(node, namespace)
        node.destroy_node()
        return told
    finally:
        rclpy.shutdown(context=context)


def _plain(namespace: str) -> str:
    return f'/{namespace.strip("/")}'.rstrip('/')


def _namespaces(node: Node) -> set[str]:
    """Those under which something publishes what is measured of a muscle."""
    split = [(topic, *topic.rpartition('/')[::2]) for topic, _ in node.get_topic_names_and_types()]
    return {namespace for topic, namespace, name in split if name in _MEASURED and node.count_publishers(topic) > 0}
