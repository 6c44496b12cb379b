"""What every kind of bag file gives: its topics and, by topic, log times and serialised messages."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from tcp_muscle_ros.files.yaml_text import NotYaml, parse
from tcp_muscle_ros.recording.cdr import Index, Payloads

BATCH = 8_000_000  # bytes: an hour of a fast recording is more than a laptop should hold at once


@dataclass(frozen=True)
class StoredTopic:
    """A topic of a bag: its message type, and the type's definition where the bag carries it ('' where not)."""

    name: str
    message_type: str
    definition_format: str
    definition: str
    encoding: str = 'cdr'


@dataclass(frozen=True)
class StoredMessages:
    """The messages of one topic in file order: log times, int64 ns, and payloads."""

    log_time: Index
    payloads: Payloads


class BagFile(Protocol):
    """One file of a bag, of any storage."""

    notes: list[str]
    topics: dict[str, StoredTopic]

    @property
    def custom_data(self) -> Mapping[str, str]:
        """What rosbag2 keeps as custom_data."""
        ...

    def batches(self, topics: Collection[str]) -> Iterator[dict[str, StoredMessages]]:
        """All messages of `topics` that the file has, in file order, about BATCH bytes at a time."""
        ...


def information(metadata: str) -> Mapping[Any, Any]:
    """What the text of a rosbag2 metadata.yaml says; empty where it is broken."""
    try:
        content = parse(metadata)
    except NotYaml:
        return {}
    if isinstance(content, dict):
        content = content.get('rosbag2_bagfile_information', content)
    return content if isinstance(content, dict) else {}


def custom_data(metadata: str) -> Mapping[str, str]:
    """The custom_data of the text of a rosbag2 metadata.yaml; empty where there is none or the text is broken."""
    data = information(metadata).get('custom_data')
    return {str(key): str(value) for key, value in data.items()} if isinstance(data, dict) else {}
