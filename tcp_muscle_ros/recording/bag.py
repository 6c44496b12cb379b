"""A rosbag2 bag as a Recording: topics found, fields read, every sample on the stamp of its tick, SI units."""

import json
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.inputs import not_readable
from tcp_muscle_ros.files.order import by_number
from tcp_muscle_ros.recording.bag_writer import KNOWN
from tcp_muscle_ros.recording.cdr import DTYPES, Index, field_path
from tcp_muscle_ros.recording.columns import Topic
from tcp_muscle_ros.recording.leaps import main_part, set_back, within
from tcp_muscle_ros.recording.mcap_file import McapFile
from tcp_muscle_ros.recording.recording import CHANNELS, Array, Channel, Recording, channel_kind, shared
from tcp_muscle_ros.recording.sqlite_file import SqliteFile
from tcp_muscle_ros.recording.storage import BagFile, StoredMessages, StoredTopic, custom_data
from tcp_muscle_ros.recording.tick_times import Ticks
from tcp_muscle_ros.recording.units import UNITS, Unit, unit_of

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

JOINT_STATES = 'joint_states'
_SHOWN = 5  # bags of a folder that was taken for one
_LARGEST = 1e30  # of a value, whose cube a float still holds; more is a damaged message
_FROM_JOINT_STATES = {'displacement': 'position', 'force': 'effort'}


@dataclass(frozen=True)
class _Source:
    """Where a channel comes from."""

    channel: str
    topic: str
    field: str  # '' = the message's own number
    unit: Unit
    explicit: bool


@dataclass(frozen=True)
class _Samples:
    """One field of one topic, in the order of the log. ``stamp`` is None where the messages carry none."""

    log: Index
    stamp: Index | None
    value: Array


def read_bag(
    path: str | Path,
    *,
    namespace: str | None = None,
    channels: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> Recording:
    """Read a rosbag2 directory or one of its files (MCAP or sqlite3) as a Recording.

    namespace  where the muscle's topics are; needed only if several namespaces have some
    channels   NAME -> 'TOPIC[.FIELD]' for topics of other names and types; FIELD may index: ``position[0]``
    units      NAME -> unit of the recorded number, where it is not the contract's

    A bag whose writer was killed is read up to its last whole message, with a note. BadInput: no bag, no message, no
    known topic, several namespaces, unknown channel, field or unit.
    """
    channels, units = channels or {}, units or {}
    bag = _Bag(Path(path))
    sources = _sources(bag, namespace, channels, units)
    reader = _Reader(bag, sources)
    ticks = reader.ticks()
    on_time: dict[_Source, tuple[Index, Array]] = {}
    for source in sources:
        sample = reader.samples(source)
        if sample is not None and len(sample.value):
            time = shared(reader.time(source, sample, ticks), (time for time, _ in on_time.values()))
            on_time[source] = (time, sample.value)
    if not on_time:
        raise BadInput(f'{path}: empty bag: no readable message on {", ".join(source.topic for source in sources)}')
    part = main_part([time for time, _ in on_time.values()])
    if part is not None:
        reader.notes.append(part.note)
        for source, (time, value) in on_time.items():
            on_time[source] = within(part, time, value, holds=CHANNELS[source.channel].role != 'output')
        on_time = {source: (time, value) for source, (time, value) in on_time.items() if len(time)}
    start_ns = min(int(time.min()) for time, _ in on_time.values())
    found: dict[str, Channel] = {}
    for source in list(on_time):
        time, value = _in_order(*on_time.pop(source), source, reader.notes)
        seconds = shared((time - start_ns) / 1e9, (channel.time for channel in found.values()))
        found[source.channel] = Channel(source.channel, seconds, source.unit.to_si(value), source.topic)
    units = {source.channel: source.unit.name for source in sources}
    notes = tuple(bag.all_notes() + reader.notes)
    return Recording(str(path), found, start_ns, bag.known(), notes, units, tuple(reader.broken))


class _Bag:
    """The files of one bag as one."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []
        self.files: list[BagFile] = []
        self._metadata = ''
        for file in self._find_files():
            if file.suffix == '.zstd':
                raise BadInput(f'{file}: compressed as a whole file; run `zstd -d {file.name}` first')
            self.files.append(SqliteFile(file) if file.suffix == '.db3' else McapFile(file))
        self.topics: dict[str, StoredTopic] = {}
        for opened in self.files:
            self.topics |= opened.topics
        if not self.topics:
            raise BadInput(f'{path}: empty bag: it has no topic')

    def _find_files(self) -> list[Path]:
        path = self.path
        if path.is_file():
            if path.name == 'metadata.yaml':
                raise BadInput(f'{path}: this is the description of a bag; give its directory {path.parent}')
            return [path]
        if not path.is_dir():
            raise not_readable(path, 'bag')
        files = sorted(
            (p for p in path.iterdir() if re.search(r'\.(mcap|db3)(\.zstd)?$', p.name) and p.is_file()), key=by_number
        )
        if not files:
            below = sorted(str(each.parent) for each in path.glob('*/*') if each.suffix in ('.mcap', '.db3'))
            hint = f'; bags in it: {", ".join(list(dict.fromkeys(below))[:_SHOWN])}' if below else ''
            raise BadInput(f'{path}: no bag: the directory has no .mcap or .db3 file{hint}')
        description = path / 'metadata.yaml'
        self._metadata = description.read_text(encoding='utf-8', errors='replace') if description.is_file() else ''
        if not self._metadata.strip('\0 \n'):
            self.notes.append(f'{description} is missing or empty: the bag was not closed (killed?)')
        if re.search(r'compression_mode:\s*["\']?message', self._metadata, re.IGNORECASE):
            raise BadInput(f'{path}: its messages are compressed one by one; `ros2 bag convert` it without compression')
        present = [file for file in files if file.stat().st_size]
        if not present:
            raise BadInput(f'{path}: empty bag: {files[0].name} has no content')
        return present

    def all_notes(self) -> list[str]:
        """Notes on the bag and on its files; the latter grow while they are read."""
        return self.notes + [note for file in self.files for note in file.notes]

    def known(self) -> dict[str, object]:
        """What the writer knew of the run; other custom_data as it stands."""
        data = dict(custom_data(self._metadata))
        for file in self.files:
            data = {**file.custom_data, **data}
        known: dict[str, object] = {key: value for key, value in data.items() if key != KNOWN}
        try:
            ours = json.loads(data.get(KNOWN, '{}'))
        except json.JSONDecodeError:
            ours = {}
        return known | ours if isinstance(ours, dict) else known

    def batches(self, topics: Collection[str]) -> Iterator[dict[str, StoredMessages]]:
        """All messages of `topics`, file by file, some at a time."""
        for file in self.files:
            yield from file.batches([t for t in topics if t in file.topics])

    def types(self, topic: str) -> 'Typesdict':
        """The definition of a topic's type as stored in the bag; that of ROS 2 Jazzy where the bag has none."""
        stored = self.topics[topic]
        types: Typesdict = {}
        try:
            if stored.definition_format == 'ros2idl':
                types = get_types_from_idl(stored.definition)
            elif stored.definition:
                types = get_types_from_msg(stored.definition, stored.message_type)
        except TypesysError as error:
            self.notes.append(f'{topic}: its stored message definition does not parse ({error}), using that of Jazzy')
        if not _complete(types, stored.message_type):
            types = {**get_typestore(Stores.ROS2_JAZZY).fielddefs, **types}
        if not _complete(types, stored.message_type):
            raise BadInput(f'{self.path}: {topic}: the bag has no definition of its type {stored.message_type}')
        return types


def _complete(types: 'Typesdict', name: str) -> bool:
    """Are the type and all that it is made of defined?"""
    if name not in types:
        return False
    for _, desc in types[name][1]:
        while desc[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            desc = desc[1][0]
        if desc[0] == Nodetype.NAME and not _complete(types, desc[1]):
            return False
    return True


# --- which topic is which channel -------------------------------------------------------------------------------------


def _sources(bag: _Bag, namespace: str | None, channels: Mapping[str, str], units: Mapping[str, str]) -> list[_Source]:
    channels = {channel_kind(name, '--channel').name: text for name, text in channels.items()}
    units = {channel_kind(name, '--unit').name: unit for name, unit in units.items()}
    prefix = _namespace(bag, namespace, bool(channels))
    topics: dict[str, tuple[str, str, bool]] = {}
    for kind in CHANNELS.values():
        if prefix + kind.topic in bag.topics:
            topics[kind.name] = (prefix + kind.topic, '', False)
    if prefix + JOINT_STATES in bag.topics:
        for name, field in _FROM_JOINT_STATES.items():
            topics.setdefault(name, (prefix + JOINT_STATES, f'{field}[0]', False))
    for name, text in channels.items():
        topic, _, field = text.partition('.')
        topics[name] = (_topic(bag, prefix, topic, f'--channel {name}'), field, True)
    for name in units:
        if name not in topics:
            raise BadInput(f'--unit {name}: {bag.path} has no channel of this name{nearest(name, topics)}')
    sources = []
    for name, (topic, field, explicit) in topics.items():
        kind = CHANNELS[name]
        unit = unit_of(units.get(name, kind.unit), UNITS[kind.unit].quantity, f'--unit {name}')
        sources.append(_Source(name, topic, field, unit, explicit))
    return sources


def _namespace(bag: _Bag, wanted: str | None, channels_given: bool) -> str:
    """The prefix ('/' or '/ns/') under which the muscle's topics are."""
    contract = {kind.topic for kind in CHANNELS.values()}
    prefixes = {topic.rpartition('/')[0] + '/' for topic in bag.topics if topic.rpartition('/')[2] in contract}
    if not prefixes:  # a joint_states of some robot is a muscle's only where nothing else is
        prefixes = {topic[: -len(JOINT_STATES)] for topic in bag.topics if topic.rpartition('/')[2] == JOINT_STATES}
    if wanted is not None:
        prefix = f'/{wanted.strip("/")}/' if wanted.strip('/') else '/'
        if prefix not in prefixes and not channels_given:
            raise BadInput(
                f"--namespace {wanted}: {bag.path} has no muscle's topic there{nearest(prefix[:-1], _shown(prefixes))}"
            )
        return prefix
    if len(prefixes) > 1:
        raise BadInput(
            f'{bag.path}: muscles in several namespaces: {", ".join(_shown(prefixes))}; '
            'choose one with --namespace, for example '
            f'--namespace {_shown(prefixes)[0]}'
        )
    if not prefixes and not channels_given:
        raise BadInput(
            f'{bag.path}: no known topic; it has {", ".join(sorted(bag.topics))}; '
            'say which is which with --channel NAME=TOPIC[.FIELD]'
        )
    return prefixes.pop() if prefixes else '/'


def _shown(prefixes: Collection[str]) -> list[str]:
    return sorted(prefix[:-1] or '/' for prefix in prefixes)


def _topic(bag: _Bag, prefix: str, name: str, where: str) -> str:
    for candidate in (name, '/' + name, prefix + name):
        if candidate in bag.topics:
            return candidate
    raise BadInput(f"{where}: {bag.path} has no topic '{name}'{nearest(name, bag.topics)}")


# --- reading ----------------------------------------------------------------------------------------------------------


class _Reader:
    """The samples of the chosen topics. Messages are decoded as they are read, and not kept."""

    def __init__(self, bag: _Bag, sources: list[_Source]) -> None:
        self.bag = bag
        self.notes: list[str] = []
        self.broken: list[str] = []
        self._asked: dict[str, list[_Source]] = {}
        for source in sources:
            self._asked.setdefault(source.topic, []).append(source)
        stamps = [s.topic for s in sources if not s.explicit and CHANNELS[s.channel].role == 'output']
        joint_states = [s.topic.rpartition('/')[0] + '/' + JOINT_STATES for s in sources if not s.explicit]
        self._tick_topics = sorted({*stamps, *joint_states} & bag.topics.keys())
        self._topics: dict[str, Topic] = {}
        for batch in bag.batches({*self._asked, *self._tick_topics}):
            for name, messages in batch.items():
                if name not in self._topics:
                    self._topics[name] = self._topic(name)
                self._topics[name].add(messages)
        for name, topic in self._topics.items():
            self._check_stamps(name, topic)
            back = set_back(topic.log if topic.stamp is None else topic.stamp)
            if back is not None:
                self.broken.append(f'{name}: {back}')

    def _topic(self, name: str) -> Topic:
        types, kind = self.bag.types(name), self.bag.topics[name].message_type
        paths = {}
        for source in self._asked.get(name, ()):
            where = f'--channel {source.channel}' if source.explicit else f'{self.bag.path}: {name}'
            paths[source.channel] = field_path(types, kind, source.field or _own_number(types, kind, where), where)
        return Topic(kind, types, paths)

    def _check_stamps(self, name: str, topic: Topic) -> None:
        """Notes on stamps that are none, or run backwards."""
        stamp = topic.stamp
        if stamp is None:
            if topic.stamped:
                self.notes.append(f'{name}: stamped 0 throughout, its log time is used')
            return
        if topic.unset:
            self.notes.append(f'{name}: {topic.unset} of {len(stamp)} messages are stamped 0, their log time is used')
        back = np.diff(stamp[np.argsort(topic.log, kind='stable')])
        if len(back) and back.min() < 0:
            self.notes.append(
                f'{name}: stamps run backwards {np.count_nonzero(back < 0)} time(s), '
                f'by up to {-back.min() * 1e-9:.3g} s (a clock was set?)'
            )

    def samples(self, source: _Source) -> _Samples | None:
        """The field of a source, finite values only; None where the topic has no message. Once: it is not kept."""
        name = source.topic
        if name not in self._topics:
            return None
        topic = self._topics[name]
        values, present = topic.field(source.channel)
        if topic.broken:
            kind = self.bag.topics[name].message_type
            self.notes.append(f'{name}: {topic.broken} message(s) do not parse as {kind} and were left out')
        if source.explicit and not present.any() and len(values) > topic.broken:
            raise BadInput(f'--channel {source.channel}: {name} has no {source.field}: {self._how_many(source)}')
        if not present.all() and present.any() and topic.broken < np.count_nonzero(~present):
            missing = np.count_nonzero(~present) - topic.broken
            self.notes.append(f"{name}: {missing} message(s) without '{source.field}' were left out")
        finite = np.abs(values) < _LARGEST  # False for NaN
        wrong = values[present & ~finite]
        if len(wrong):
            what = f'not finite or above {_LARGEST:g}' if np.isfinite(wrong).any() else 'not finite'
            self.notes.append(f'{source.channel}: {len(wrong)} of {len(finite)} values are {what} and were left out')
        kept = present & finite
        if source == self._asked[name][-1]:
            del self._topics[name]
        log, stamp = topic.log, topic.stamp
        if kept.all():
            return _Samples(log, stamp, values)
        return _Samples(log[kept], None if stamp is None else stamp[kept], values[kept])

    def _how_many(self, source: _Source) -> str:
        """Of how many elements the sequence is, in the first message, of which the source's field asks for one more."""
        types, kind = self.bag.types(source.topic), self.bag.topics[source.topic].message_type
        store = get_typestore(Stores.EMPTY)
        store.register(types)
        (first, *_) = next(iter(self.bag.batches([source.topic]))).values()
        value: Any = store.deserialize_cdr(first.payloads[0], kind)
        for part in field_path(types, kind, source.field, ''):
            if not isinstance(part, int):
                value, name = getattr(value, part), part
            elif part < len(value):
                value = value[part]
            else:
                return f"'{name}' has {len(value)} element(s), counted from 0"
        return 'not in every message'

    def ticks(self) -> Ticks | None:
        """When the muscle's own stamped messages were logged, and what they are stamped."""
        logs: list[Index] = []
        stamps: list[Index] = []
        for topic in self._tick_topics:
            stamp = self._topics[topic].stamp if topic in self._topics else None
            # Of a stamp that several have, the first's log time counts; most have the same stamps.
            if stamp is not None and not any(np.array_equal(stamp, other) for other in stamps):
                logs.append(self._topics[topic].log)
                stamps.append(stamp)
        if not logs:
            return None
        if len(logs) == 1 and _increase(logs[0]) and _increase(stamps[0]):
            return Ticks(logs[0], stamps[0]) if len(stamps[0]) > 1 else None
        stamp, first = np.unique(np.concatenate(stamps), return_index=True)
        if len(stamp) < 2:
            return None
        log = np.concatenate(logs)[first]
        order = np.argsort(log, kind='stable')
        return Ticks(log[order], stamp[order])

    def time(self, source: _Source, samples: _Samples, ticks: Ticks | None) -> Index:
        """When each sample was: its stamp, else the stamp of its tick, else its log time; ns."""
        if samples.stamp is not None:
            return samples.stamp
        if ticks is None:
            return samples.log
        if source.explicit:
            return samples.log + ticks.clock_offset
        return ticks.of(samples.log)


def _increase(time: Index) -> bool:
    return bool(np.all(time[1:] > time[:-1]))


def _own_number(types: 'Typesdict', kind: str, where: str) -> str:
    """The field that is meant when none is named: ``data``, a quantity named as its type, or the only number."""
    numbers = [name for name, desc in types[kind][1] if desc[0] == Nodetype.BASE and desc[1][0] in DTYPES]
    for name in ('data', kind.rpartition('/')[2].lower(), *(numbers if len(numbers) == 1 else ())):
        if name in numbers:
            return str(name)
    fields = ', '.join(name for name, _ in types[kind][1])
    raise BadInput(f'{where}: {kind} has no single number; say which field, as --channel NAME=TOPIC.FIELD: {fields}')


def _in_order(time: Index, value: Array, source: _Source, notes: list[str]) -> tuple[Index, Array]:
    """Sorted by time, one sample an instant (the last that was logged: an input holds from then on)."""
    if np.any(time[1:] < time[:-1]):
        order = np.argsort(time, kind='stable')
        time, value = time[order], value[order]
    kept = np.append(time[1:] != time[:-1], True)
    if kept.all():
        return time, value
    notes.append(f'{source.channel}: {np.count_nonzero(~kept)} sample(s) share a stamp; the last of each was kept')
    return time[kept], value[kept]
