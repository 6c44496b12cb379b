"""A rosbag2 bag as a Recording: topics found, fields read, every sample on the stamp of its tick, SI units."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from tcp_muscle_ros.errors import BadInput, Option
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.bag_channels import JOINT_STATES, Source, sources_of
from tcp_muscle_ros.recording.bag_files import Bag
from tcp_muscle_ros.recording.bag_joints import JOINT_STATE, Joints, joint_paths, joints_of
from tcp_muscle_ros.recording.cdr import DTYPES, Index, field_path
from tcp_muscle_ros.recording.columns import Topic
from tcp_muscle_ros.recording.leaps import main_part, set_back, within
from tcp_muscle_ros.recording.recording import CHANNELS, LARGEST, Array, Channel, Recording, shared
from tcp_muscle_ros.recording.tick_times import Ticks

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict


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
    bag = Bag(Path(path))
    sources = sources_of(bag, namespace, channels, units)
    reader = _Reader(bag, sources)
    ticks = reader.ticks()
    on_time: dict[Source, tuple[Index, Array]] = {}
    for source in sources:
        sample = reader.samples(source)
        if sample is not None and len(sample.value) and reader.takes(source, sample):
            time = shared(reader.time(source, sample, ticks), (time for time, _ in on_time.values()))
            on_time[source] = (time, sample.value)
    if not on_time:
        empty = f'empty bag: no readable message on {", ".join(source.topic for source in sources)}'
        raise BadInput(f'{path}: {"; ".join(reader.left_out) or empty}')
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
    notes = tuple(bag.all_notes() + reader.notes + reader.left_out)
    return Recording(str(path), found, start_ns, bag.known(), notes, units, tuple(reader.broken))


class _Reader:
    """The samples of the chosen topics. Messages are decoded as they are read, and not kept."""

    def __init__(self, bag: Bag, sources: list[Source]) -> None:
        self.bag = bag
        self.notes: list[str] = []
        self.left_out: list[str] = []  # notes on topics that are not taken by themselves
        self.broken: list[str] = []
        self._asked: dict[str, list[Source]] = {}
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
        self._joints: dict[str, Joints] = {}
        for name, topic in self._topics.items():
            if bag.topics[name].message_type == JOINT_STATE and name in self._asked:
                self._joints[name] = joints_of(topic)
            self._check_stamps(name, topic)
            back = set_back(topic.log if topic.stamp is None else topic.stamp)
            if back is not None:
                self.broken.append(f'{name}: {back}')

    def _topic(self, name: str) -> Topic:
        types, kind = self.bag.types(name), self.bag.topics[name].message_type
        paths = {}
        for source in self._asked.get(name, ()):
            where = options.channel(source.channel) if source.explicit else f'{self.bag.path}: {name}'
            paths[source.channel] = field_path(types, kind, source.field or _own_number(types, kind, where), where)
        if kind == JOINT_STATE and paths:
            paths |= joint_paths(path[-1] for path in paths.values())
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
                f'by up to {-back.min() * 1e-9:.3g} s (two publishers, or a clock was set?)'
            )

    def samples(self, source: Source) -> _Samples | None:
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
            what = f': {name} has no {source.field}: {self._how_many(source)}'
            raise BadInput(options.channel(source.channel), what)
        if not present.all() and present.any() and topic.broken < np.count_nonzero(~present):
            missing = np.count_nonzero(~present) - topic.broken
            self.notes.append(f"{name}: {missing} message(s) without '{source.field}' were left out")
        finite = np.abs(values) < LARGEST  # False for NaN
        wrong = values[present & ~finite]
        if len(wrong):
            what = f'not finite or above {LARGEST:g}' if np.isfinite(wrong).any() else 'not finite'
            self.notes.append(f'{source.channel}: {len(wrong)} of {len(finite)} values are {what} and were left out')
        kept = present & finite
        if source == self._asked[name][-1]:
            del self._topics[name]
        log, stamp = topic.log, topic.stamp
        if kept.all():
            return _Samples(log, stamp, values)
        return _Samples(log[kept], None if stamp is None else stamp[kept], values[kept])

    def takes(self, source: Source, samples: _Samples) -> bool:
        """Whether it is a channel: joint states that nobody asked for may be of something else, which a note says."""
        doubt = self._joints[source.topic].doubt(source, samples.value) if source.topic in self._joints else ''
        if source.explicit:
            self.notes += [doubt] if doubt else []
        elif doubt and doubt not in self.left_out:
            self.left_out.append(doubt)
        return source.explicit or not doubt

    def _how_many(self, source: Source) -> str:
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

    def time(self, source: Source, samples: _Samples, ticks: Ticks | None) -> Index:
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


def _own_number(types: 'Typesdict', kind: str, where: str | Option) -> str:
    """The field that is meant when none is named: ``data``, a quantity named as its type, or the only number."""
    numbers = [name for name, desc in types[kind][1] if desc[0] == Nodetype.BASE and desc[1][0] in DTYPES]
    for name in ('data', kind.rpartition('/')[2].lower(), *(numbers if len(numbers) == 1 else ())):
        if name in numbers:
            return str(name)
    fields = ', '.join(name for name, _ in types[kind][1])
    example = options.some_channel('NAME', 'TOPIC.FIELD')
    raise BadInput(where, f': {kind} has no single number; say which field, as ', example, f': {fields}')


def _in_order(time: Index, value: Array, source: Source, notes: list[str]) -> tuple[Index, Array]:
    """Sorted by time, one sample an instant (the last that was logged: an input holds from then on)."""
    if np.any(time[1:] < time[:-1]):
        order = np.argsort(time, kind='stable')
        time, value = time[order], value[order]
    kept = np.append(time[1:] != time[:-1], True)
    if kept.all():
        return time, value
    notes.append(f'{source.channel}: {np.count_nonzero(~kept)} sample(s) share a stamp; the last of each was kept')
    return time[kept], value[kept]
