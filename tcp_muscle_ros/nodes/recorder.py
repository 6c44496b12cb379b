"""The node behind ``tcp_muscle record``: a muscle's topics, in and out, byte by byte into a bag.

It subscribes to every topic of the contract before any of them exists, so that the first seconds are not lost. Messages
are taken in turns every few milliseconds instead of through an executor, whose wait set would cost more than all the
rest (at 1 kHz and six topics), and keep the time at which the middleware received them.
"""

import importlib
import os
import shutil
import signal
import time
from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.exceptions import InvalidNamespaceException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import writable_folder, writing
from tcp_muscle_ros.nodes.elsewhere import elsewhere
from tcp_muscle_ros.nodes.log_times import LogTimes
from tcp_muscle_ros.nodes.mixing import mixed
from tcp_muscle_ros.recording.bag_writer import BagWriter
from tcp_muscle_ros.recording.recording import CHANNELS

DIAGNOSTICS = '/diagnostics'
TOPICS: dict[str, type] = {kind.topic: Temperature if kind.stamped else Float64 for kind in CHANNELS.values()}
TOPICS |= {'joint_states': JointState, 'shaped_setpoint': Float64, DIAGNOSTICS: DiagnosticArray}

_TURN_S = 0.004
_QUEUE = 5000  # messages a topic: more than two seconds at 2 kHz, should the disk stall
_FLUSH_S = 0.2  # of the second that a kill may cost, what is left is for a machine that lets a process wait
_LOOK_S = 1.0  # how often the graph is looked at
_SAY_S = 10.0
_AT_FIRST = ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE  # until a publisher offers something else
_PATIENCE_S = 10.0  # at least so long a recording of fixed duration waits for its first message


def record(
    output: str | Path,
    *,
    namespace: str = '',
    duration: float | None = None,
    use_sim_time: bool = False,
    force: bool = False,
    topics: Sequence[str] = (),
    say: Callable[[str], None] = print,
) -> int:
    """Record until SIGINT, SIGTERM, or `duration` s after the first message; returns the exit code 0.

    use_sim_time  log times are those of /clock instead of the system's
    force         a bag that is there already goes, once the new one is whole
    topics        more topics, relative to the namespace or absolute; their types are those that are published there

    BadInput: `output` exists or cannot be written, no such namespace, or no message of a muscle came.
    """
    output = writable_folder(output, force=force)
    asked: list[int] = []
    handlers = {number: signal.signal(number, lambda *_: asked.append(1)) for number in (signal.SIGINT, signal.SIGTERM)}
    with ExitStack() as ending:  # each step is taken although one before it fails, as closing does on a full disk
        for number, handler in handlers.items():
            ending.callback(signal.signal, number, handler)
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        ending.callback(rclpy.try_shutdown)
        recorder = Recorder(output, namespace, use_sim_time, say, wanted=topics)
        ending.callback(recorder.close)
        recorder.run(duration, lambda: bool(asked))
        if recorder.lacking:
            raise BadInput(f'no message came {recorder.lacking}; {output} was not written')
    return 0


class Recorder:
    """Subscriptions to one muscle's topics, and the bag that they end in, which is made with the first message.

    ``known`` of the run is kept in the bag; ``more`` are topics to record beside those of a muscle, with their types,
    and ``wanted`` such topics of whatever type is published there.
    """

    def __init__(
        self,
        output: Path,
        namespace: str,
        use_sim_time: bool,
        say: Callable[[str], None],
        *,
        known: Mapping[str, object] | None = None,
        more: Mapping[str, type] | None = None,
        wanted: Sequence[str] = (),
    ) -> None:
        self._output = output
        self._known = known
        self._namespace = '/' + namespace.strip('/')
        self._say = say
        try:
            self._node = Node('muscle_recorder', namespace=self._namespace, enable_rosout=False)
        except InvalidNamespaceException as error:
            raise BadInput(f'--namespace {namespace}: {" ".join(str(error).split())}') from None
        prefix = self._namespace.rstrip('/')
        topics = {**TOPICS, **(more or {})}
        self._types = {name if name[0] == '/' else f'{prefix}/{name}': kind for name, kind in topics.items()}
        self._listens = dict.fromkeys(self._types, _AT_FIRST)
        self._subscriptions = {topic: self._subscribe(topic) for topic in self._types}
        absolute = {name if name[0] == '/' else f'{prefix}/{name}' for name in wanted}
        self._wanted = sorted(absolute - set(self._types))  # until somebody publishes there
        best_effort = QoSProfile(depth=_QUEUE, reliability=ReliabilityPolicy.BEST_EFFORT)  # takes any publisher's
        self._clock = self._node.create_subscription(Clock, '/clock', _unused, best_effort) if use_sim_time else None
        self._sim_time_ns: int | None = None
        self._before_clock: list[tuple[str, bytes]] = []
        self._log_times = {topic: LogTimes() for topic in self._types}
        self._before_muscle: deque[tuple[str, bytes, int]] = deque(maxlen=_QUEUE)
        self._replaced: Path | None = None
        self._bag: BagWriter | None = None
        # By topic, when the latest messages were sent (ns); and which of them came before it was subscribed to anew.
        self._sent: defaultdict[str, deque[int]] = defaultdict(lambda: deque(maxlen=_QUEUE))
        self._came_already: dict[str, frozenset[int]] = {}
        self._warned: set[str] = set()
        self._mixed: set[str] = set()
        self._count = 0
        self._flushed = self._looked = 0.0  # when; steady time, s

    def _subscribe(self, topic: str) -> Any:
        reliability, durability = self._listens[topic]
        qos = QoSProfile(depth=_QUEUE, reliability=reliability, durability=durability)
        return self._node.create_subscription(self._types[topic], topic, _unused, qos, raw=True)

    @property
    def topics(self) -> frozenset[str]:
        """Those of which a message is in the bag."""
        return frozenset() if self._bag is None else frozenset(t for t, n in self._bag.counts.copy().items() if n)

    @property
    def lacking(self) -> str:
        """What did not come, where nothing is in the bag; else nothing."""
        if self._bag is not None:
            return ''
        return f'{"on /clock" if self._before_clock else f"of a muscle under {self._namespace}"}{self._elsewhere()}'

    def run(self, duration: float | None, stop: Callable[[], bool]) -> None:
        """Take and write until `stop()`, or `duration` s after the first message."""
        self._say(f'waiting for messages on the topics of a muscle under {self._namespace}')
        begun = said = time.monotonic()
        first: float | None = None
        while not stop():
            self.turn()
            now = time.monotonic()
            if first is None and self._bag is not None:
                first = now
            if first is not None and duration is not None and now - first >= duration:
                break
            if first is None and duration is not None and now - begun > max(duration, _PATIENCE_S):
                lacking = 'on /clock' if self._before_clock else f'under {self._namespace}'
                raise BadInput(f'no message {lacking} within {now - begun:.0f} s{self._domain()}{self._elsewhere()}')
            if now - said >= _SAY_S:
                lacking = ' on /clock' if self._before_clock else f' under {self._namespace}{self._elsewhere()}'
                waited = f'no message yet{lacking}'
                self._say(waited if first is None else f'{now - first:.0f} s, {self._count} messages{self.absent()}')
                said = now
            time.sleep(_TURN_S)
        self.take()

    def turn(self, at: int | None = None) -> None:
        """``take``, and once in a while look after the disk and the graph."""
        self.take(at)
        now = time.monotonic()
        if self._bag is not None and now - self._flushed >= _FLUSH_S:
            with self._writing():
                self._bag.flush()
            self._flushed = now
        if now - self._looked >= _LOOK_S:
            self._look_at_publishers()
            self._looked = now

    def take(self, at: int | None = None) -> None:
        """Write all messages that have come, in the order in which they came; ``at`` ns is their log time, if given."""
        arrived = [message for topic in self._subscriptions for message in self._taken(topic)]
        if self._clock is not None:
            with self._clock.handle:
                while (taken := self._clock.handle.take_message(Clock, False)) is not None:
                    stamp = taken[0].clock.sec * 1_000_000_000 + taken[0].clock.nanosec
                    arrived.append((taken[1]['received_timestamp'], '', stamp.to_bytes(8, 'little')))
        arrived.sort(key=lambda message: message[0])
        with self._writing():
            for received_ns, topic, payload in arrived:
                if self._clock is None:
                    self._write(topic, payload, received_ns if at is None else at)
                elif not topic:
                    self._sim_time_ns = int.from_bytes(payload, 'little')
                    for earlier in self._before_clock:
                        self._write(*earlier, self._sim_time_ns)
                    self._before_clock.clear()
                elif self._sim_time_ns is not None:
                    self._write(topic, payload, self._sim_time_ns)
                elif len(self._before_clock) < _QUEUE:  # there is no time yet: logged with the first /clock
                    self._before_clock.append((topic, payload))

    def _taken(self, topic: str) -> list[tuple[int, str, bytes]]:
        """The messages of a topic that have come, each with its log time (ns)."""
        subscription, messages, twice = self._subscriptions[topic], [], self._came_already.get(topic, frozenset())
        with subscription.handle:
            while (taken := subscription.handle.take_message(subscription.msg_type, True)) is not None:
                if taken[1]['source_timestamp'] not in twice:
                    messages.append(taken)
        received, sent = ([info[f'{when}_timestamp'] for _, info in messages] for when in ('received', 'source'))
        self._sent[topic].extend(sent)
        times = self._log_times[topic].of(received, sent)
        return [(time_ns, topic, message) for time_ns, (message, _) in zip(times, messages, strict=True)]

    def _write(self, topic: str, payload: bytes, log_time_ns: int) -> None:
        if self._bag is None:
            if topic == DIAGNOSTICS:  # of whichever node: no muscle was heard yet
                self._before_muscle.append((topic, payload, log_time_ns))
                return
            self._make_room()
            self._bag = BagWriter(self._output, known=self._known)
            for earlier in self._before_muscle:
                self._write(*earlier)
        if topic not in self._bag.counts:
            kind = self._types[topic]
            self._bag.add_topic(topic, f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}')
            self._say(f'recording {topic}')
        self._bag.write_serialized(topic, payload, log_time_ns)
        self._count += 1

    def _make_room(self) -> None:
        """What is there already, where it may be replaced, is kept beside the new bag until that is whole."""
        if self._output.exists():
            self._replaced = self._output.with_name(f'.{self._output.name}.replaced-{os.getpid()}')
            self._output.rename(self._replaced)

    def _writing(self) -> AbstractContextManager[None]:
        return writing(self._output, '; what was written until then is kept')

    def _look_at_publishers(self) -> None:
        """Each topic is taken as it is offered; a publisher of another type is said to be left out."""
        self._look_for_wanted()
        for topic, kind in self._types.items():
            wanted = f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'
            publishers = self._node.get_publishers_info_by_topic(topic)
            for publisher in publishers:
                if publisher.topic_type != wanted and topic not in self._warned:
                    self._warned.add(topic)
                    self._say(f'{topic} is published as {publisher.topic_type}, expected {wanted}: not recorded')
            if topic not in self._mixed and (told := mixed(topic, publishers)):
                self._mixed.add(topic)
                self._say(told)
            self._take_as_offered(topic, [publisher.qos_profile for publisher in publishers])

    def _take_as_offered(self, topic: str, offers: Sequence[QoSProfile]) -> None:
        """As best effort once a publisher offers no more; and where each keeps what it said for those who come late, as
        a rig may say its load once, with that. A publisher that does not would not be heard so: then without."""
        reliability, durability = self._listens[topic]
        if any(offer.reliability == ReliabilityPolicy.BEST_EFFORT for offer in offers):
            reliability = ReliabilityPolicy.BEST_EFFORT
        if offers:
            lasting = all(offer.durability == DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
            durability = DurabilityPolicy.TRANSIENT_LOCAL if lasting else DurabilityPolicy.VOLATILE
        if (reliability, durability) == self._listens[topic]:
            return
        if durability == DurabilityPolicy.TRANSIENT_LOCAL:
            self._came_already[topic] = frozenset(self._sent[topic]) - {0}  # 0: not known
            self._log_times[topic] = LogTimes(time.time_ns())
        self._listens[topic] = reliability, durability
        self._node.destroy_subscription(self._subscriptions[topic])
        self._subscriptions[topic] = self._subscribe(topic)

    def _look_for_wanted(self) -> None:
        """Subscribe to the wanted topics of which the type is known by now."""
        for topic in list(self._wanted):
            publishers = self._node.get_publishers_info_by_topic(topic)
            if not publishers:
                continue
            self._wanted.remove(topic)
            found = publishers[0].topic_type
            kind = _message_type(found)
            if kind is None:
                self._say(f'{topic} is {found}, a type that is not known here: not recorded')
                continue
            self._types[topic], self._log_times[topic], self._listens[topic] = kind, LogTimes(), _AT_FIRST
            self._subscriptions[topic] = self._subscribe(topic)

    def absent(self) -> str:
        """Which of the wanted topics nobody has published so far, as the end of a sentence; '' where all are."""
        meant = []
        for topic in self._wanted:
            folder, _, name = topic.rpartition('/')
            beside = [one.rpartition('/') for one, _ in self._node.get_topic_names_and_types() if one != topic]
            near = get_close_matches(name, [last for first, _, last in beside if first == folder], n=1)
            meant.append(f'{topic} (did you mean {folder}/{near[0]}?)' if near else topic)
        return f'; nobody publishes {", ".join(meant)}' if meant else ''

    def _domain(self) -> str:
        """Which domain it listens in, where the muscle may not be."""
        return f' (ROS_DOMAIN_ID {self._node.context.get_domain_id()})'

    def _elsewhere(self) -> str:
        return elsewhere(self._node, self._namespace)

    def close(self) -> None:
        """Finish the bag."""
        bag, self._bag = self._bag, None
        try:
            if bag is not None:
                with self._writing():
                    bag.close()
                self._say(f'{self._count} messages on {len(bag.counts)} topics in {self._output}{self.absent()}')
                if self._replaced is not None:
                    shutil.rmtree(self._replaced, ignore_errors=True)
        finally:
            self._node.destroy_node()


def _message_type(name: str) -> type | None:
    """The class of a message type such as ``geometry_msgs/msg/Wrench``; None where it is not known."""
    if name not in get_typestore(Stores.ROS2_JAZZY).fielddefs:
        return None  # the bag needs its definition
    package, _, message = name.split('/')
    try:
        found: type = getattr(importlib.import_module(f'{package}.msg'), message)
    except (ImportError, AttributeError):
        return None
    return found


def _unused(_: object) -> None:
    """Messages are taken from the subscription, no callback runs."""
