"""rosbag2 bags (MCAP storage), written so that a killed writer loses at most its last second."""

import json
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
import yaml
from rosbags.typesys import Stores, get_typestore

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.outputs import OUTPUT
from tcp_muscle_ros.recording.cdr import Bytes, Index
from tcp_muscle_ros.recording.mcap_writer import Batch, McapWriter
from tcp_muscle_ros.recording.recording import CHANNELS, Array, Recording
from tcp_muscle_ros.recording.units import UNITS

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

VERSION = 9  # of rosbag2's metadata.yaml; the one of ROS 2 Jazzy
KNOWN = 'tcp_muscle_known'  # the key of custom_data that holds what is known of the run, as JSON
_FLUSH_S = 0.5
_LAST_S = 2**31  # since the epoch: the seconds of a stamp are an int32
_UNFINISHED = '.metadata.yaml'

# Topics are offered as the nodes offer them: reliable, keep last 10. rosbag2's own `play` takes its QoS from here.
_UNLIMITED = {'sec': 9223372036, 'nsec': 854775807}
_QOS = [
    {
        'history': 'keep_last',
        'depth': 10,
        'reliability': 'reliable',
        'durability': 'volatile',
        'deadline': _UNLIMITED,
        'lifespan': _UNLIMITED,
        'liveliness': 'automatic',
        'liveliness_lease_duration': _UNLIMITED,
        'avoid_ros_namespace_conventions': False,
    }
]


def refuse_existing(path: str | Path) -> Path:
    """The path of a new output. BadInput if something is there already: nothing is overwritten."""
    path = Path(path)
    if path.exists():
        raise BadInput(f'{path}: exists already and is not overwritten; give another ', OUTPUT, ' or remove it')
    return path


class BagWriter:
    """A new rosbag2 directory. Use as a context manager: a bag that an exception ends is left without its summary, so
    that whoever reads it is told that it is not all there.

    ``typestore`` has the definitions of the messages (default: those of ROS 2 Jazzy). ``known`` is kept in the
    bag's custom_data. metadata.yaml is there from the first moment: a bag whose writer was killed is still found.
    """

    def __init__(
        self, path: str | Path, *, known: Mapping[str, object] | None = None, typestore: 'Typestore | None' = None
    ) -> None:
        self.path = refuse_existing(path)
        self.typestore = typestore or get_typestore(Stores.ROS2_JAZZY)
        self._custom_data = {KNOWN: json.dumps(_text_keys(known), default=str)} if known else None
        self._made = [directory for directory in (self.path, *self.path.parents) if not directory.exists()]
        try:
            self.path.mkdir(parents=True)
            self._file = (self.path / f'{self.path.name}_0.mcap').open('xb')
        except OSError as error:
            raise BadInput(f'{path}: cannot write there ({error.strerror})') from None
        self._mcap = McapWriter(self._file, profile='ros2', library='tcp_muscle_ros')
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._types: dict[str, str] = {}
        self.counts: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0
        self._flushed = time.monotonic()
        self._closed = False
        self._partial = False
        try:
            self._write_metadata()
            self.flush()
        except OSError as error:
            self.remove()
            raise BadInput(f'{path}: cannot write there ({error.strerror})') from None

    def add_topic(self, topic: str, message_type: str) -> None:
        """Declare an absolute topic and its type (``std_msgs/msg/Float64``). A topic declared twice is one topic."""
        if topic in self._channels:
            if self._types[topic] != message_type:
                raise BadInput(f'{self.path}: {topic} is {self._types[topic]} already, cannot also be {message_type}')
            return
        if message_type not in self.typestore.fielddefs:
            raise BadInput(
                f"{self.path}: {topic}: unknown message type '{message_type}'"
                f'{nearest(message_type, self.typestore.fielddefs)}'
            )
        if message_type not in self._schemas:
            definition, _ = self.typestore.generate_msgdef(message_type, ros_version=2)
            self._schemas[message_type] = self._mcap.add_schema(message_type, 'ros2msg', definition.encode())
        self._channels[topic] = self._mcap.add_channel(
            topic,
            'cdr',
            self._schemas[message_type],
            {
                'offered_qos_profiles': yaml.safe_dump(_QOS, sort_keys=False),
                'topic_type_hash': self.typestore.hash_rihs01(message_type),
            },
        )
        self._types[topic] = message_type
        self.counts[topic] = 0
        self._write_metadata()

    def write(self, topic: str, message: object, log_time_ns: int) -> None:
        """Write one message given as an object of ``self.typestore``."""
        self.write_serialized(topic, bytes(self.typestore.serialize_cdr(message, self._types[topic])), log_time_ns)

    def write_serialized(self, topic: str, payload: bytes, log_time_ns: int) -> None:
        """Write one message that is CDR already."""
        self._mcap.write(self._channels[topic], self.counts[topic], log_time_ns, payload)
        self._count(topic, 1, log_time_ns, log_time_ns)
        if time.monotonic() - self._flushed >= _FLUSH_S:
            self.flush()

    def write_many(self, messages: Mapping[str, tuple[Index, Bytes]]) -> None:
        """Write whole topics at once, in the order of their log times.

        ``messages`` has by topic log times (int64[n], ns) and as many messages that are CDR already and equally long
        (uint8[n, size]).
        """
        batches = []
        for topic, (log_time_ns, payload) in messages.items():
            batches.append(Batch(self._channels[topic], self.counts[topic], log_time_ns, payload))
        self._partial = True
        self._mcap.write_batches(batches)
        for topic, (log_time_ns, _) in messages.items():
            if len(log_time_ns):
                self._count(topic, len(log_time_ns), int(log_time_ns.min()), int(log_time_ns.max()))
        self._partial = False

    def _count(self, topic: str, more: int, first_ns: int, last_ns: int) -> None:
        self.counts[topic] += more
        self._first_ns = first_ns if self._first_ns is None else min(self._first_ns, first_ns)
        self._last_ns = max(self._last_ns, last_ns)

    def flush(self) -> None:
        """Hand everything to the operating system: from here on a kill -9 does not lose it.

        Writing does this by itself; call it on a timer where messages may stop coming.
        """
        self._mcap.flush()
        self._flushed = time.monotonic()

    def close(self) -> None:
        """Write the summary and the final metadata.yaml. What was broken off in the middle stays unfinished."""
        if self._closed:
            return
        if self._partial or self._mcap.torn:
            self.leave_unfinished()
            return
        self._closed = True
        self._mcap.add_metadata('rosbag2', {'serialized_metadata': yaml.safe_dump(self._metadata(), sort_keys=False)})
        self._mcap.finish()
        self._file.close()
        self._write_metadata()

    def leave_unfinished(self) -> None:
        """Keep what was written, without the summary: the bag is read as one whose writer was killed."""
        if self._closed:
            return
        self._closed = True
        with suppress(OSError):  # a full disk; what it took before stays
            if not self._mcap.torn:
                self._mcap.flush()
        with suppress(OSError):
            self._file.close()

    def remove(self) -> None:
        """Take back what this writer made: its files, and the directories that were not there before."""
        self._closed = True
        with suppress(OSError):
            self._file.close()
        for made in (Path(self._file.name), self.path / 'metadata.yaml', self.path / _UNFINISHED):
            made.unlink(missing_ok=True)
        with suppress(OSError):  # something else is in it by now
            for directory in self._made:
                directory.rmdir()

    def _metadata(self) -> dict[str, object]:
        start = self._first_ns or 0
        about = {
            'starting_time': {'nanoseconds_since_epoch': start},
            'duration': {'nanoseconds': max(0, self._last_ns - start)},
            'message_count': sum(self.counts.values()),
        }
        name = Path(self._file.name).name
        return {
            'version': VERSION,
            'storage_identifier': 'mcap',
            'relative_file_paths': [name],
            **about,
            'topics_with_message_count': [
                {
                    'topic_metadata': {
                        'name': topic,
                        'type': message_type,
                        'serialization_format': 'cdr',
                        'offered_qos_profiles': _QOS,
                        'type_description_hash': self.typestore.hash_rihs01(message_type),
                    },
                    'message_count': self.counts[topic],
                }
                for topic, message_type in self._types.items()
            ],
            'compression_format': '',
            'compression_mode': '',
            'files': [{'path': name, **about}],
            'custom_data': self._custom_data,
            'ros_distro': 'jazzy',
        }

    def _write_metadata(self) -> None:
        text = _plain_yaml({'rosbag2_bagfile_information': self._metadata()})
        unfinished = self.path / _UNFINISHED
        unfinished.write_text(text, encoding='utf-8')
        unfinished.replace(self.path / 'metadata.yaml')

    def __enter__(self) -> 'BagWriter':
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.leave_unfinished()


def _text_keys(known: object) -> object:
    """The same with every key a text: YAML has dates and numbers as keys, JSON has not."""
    if isinstance(known, Mapping):
        return {str(key): _text_keys(value) for key, value in known.items()}
    return [_text_keys(value) for value in known] if isinstance(known, list | tuple) else known


class _NoAliases(yaml.SafeDumper):
    def ignore_aliases(self, data: object) -> bool:
        return True


def _plain_yaml(content: object) -> str:
    """YAML without anchors: rosbag2's parser reads it, and so do people."""
    return yaml.dump(content, Dumper=_NoAliases, sort_keys=False)


def write_recording(path: str | Path, recording: Recording, *, namespace: str = '') -> None:
    """A Recording as a bag with the contract's topics and types, log time = stamp. BadInput if `path` exists.

    Temperatures go out in degC; a sensor_msgs/Temperature carries its stamp and variance 0 (= unknown).
    """
    write_recordings(path, {namespace: recording})


def write_recordings(path: str | Path, recordings: Mapping[str, Recording]) -> None:
    """Several Recordings in one bag, each under the namespace that is its key; otherwise as `write_recording`.

    All or nothing: interrupted or on a full disk, the begun bag is removed, for it would pass for a shorter recording.
    """
    _write_or_remove(path, iter([recordings]))


def write_pieces(path: str | Path, pieces: Iterable[Recording]) -> None:
    """A Recording that comes piece by piece, one after the other in time; otherwise as `write_recording`."""
    _write_or_remove(path, ({'': piece} for piece in pieces))


def _write_or_remove(path: str | Path, pieces: Iterator[Mapping[str, Recording]]) -> None:
    """Pieces of Recordings by namespace."""
    first = next(pieces)
    writer = BagWriter(path, known=next(iter(first.values())).known)
    try:
        with writer:
            for recordings in chain([first], pieces):
                _write_all(writer, recordings)
    except OSError as error:
        writer.remove()
        raise BadInput(f'{path}: cannot be written ({error.strerror}); nothing is left of it') from None
    except BaseException:
        writer.remove()
        raise


def _write_all(writer: BagWriter, recordings: Mapping[str, Recording]) -> None:
    messages = {}
    for namespace, recording in recordings.items():
        prefix = '/' + namespace.strip('/') + '/' if namespace.strip('/') else '/'
        for channel in recording.channels.values():
            kind = CHANNELS[channel.name]
            topic = prefix + kind.topic
            writer.add_topic(topic, kind.message_type)
            if len(channel) and not 0 <= recording.start_ns * 1e-9 + channel.time[-1] < _LAST_S:
                raise BadInput(
                    f'{recording.path}: {channel.name} lasts until {channel.time[-1]:.4g} s after {recording.start_ns} '
                    'ns of the epoch, but the stamps of ROS messages end in January 2038'
                )
            time_ns = recording.start_ns + np.round(channel.time * 1e9).astype(np.int64)
            value = UNITS[kind.unit].from_si(channel.value)
            messages[topic] = time_ns, _temperature_cdr(time_ns, value) if kind.stamped else _float64_cdr(value)
    writer.write_many(messages)


_LITTLE_ENDIAN = np.void(b'\x00\x01\x00\x00')


def _float64_cdr(value: Array) -> Bytes:
    """uint8[n, 12]: std_msgs/Float64."""
    rows = np.empty(len(value), dtype=[('order', 'V4'), ('data', '<f8')])
    rows['order'] = _LITTLE_ENDIAN
    rows['data'] = value
    return rows.view(np.uint8).reshape(len(value), rows.itemsize)


def _temperature_cdr(time_ns: Index, value: Array) -> Bytes:
    """uint8[n, 36]: header {stamp, frame_id ''}, temperature, variance 0."""
    rows = np.zeros(
        len(value),
        dtype=np.dtype({
            'names': ['order', 'sec', 'nanosec', 'frame_length', 'temperature', 'variance'],
            'formats': ['V4', '<i4', '<u4', '<u4', '<f8', '<f8'],
            'offsets': [0, 4, 8, 12, 20, 28],
            'itemsize': 36,
        }),
    )  # fmt: skip
    rows['order'] = _LITTLE_ENDIAN
    rows['sec'], rows['nanosec'] = np.divmod(time_ns, 1_000_000_000)
    rows['frame_length'] = 1
    rows['temperature'] = value
    return rows.view(np.uint8).reshape(len(value), rows.itemsize)
