"""The node behind ``tcp_muscle run``: plays parts of a protocol on the muscle that answers, and records them.

It has no executor: commands are published at absolute times of the steady clock, and what came meanwhile is taken
between two of them. Where a simulation in lockstep publishes the measurements, its ticks are the time, and it waits for
the commands of each. Whatever happens, the last command is 0 A.
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration
from rclpy.exceptions import InvalidNamespaceException
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.control.playing import Cold, Part, Supervisor, instants
from tcp_muscle_ros.control.safety import celsius
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.nodes.mixing import mixed
from tcp_muscle_ros.nodes.pace import LockstepTime, RealTime, leads
from tcp_muscle_ros.nodes.polled import Inputs
from tcp_muscle_ros.nodes.recorder_beside import RecorderBeside
from tcp_muscle_ros.nodes.rivals import NAMED_WITHIN, Rivals
from tcp_muscle_ros.nodes.serialized import NumberPublisher
from tcp_muscle_ros.nodes.topics import (
    COMMAND_QOS,
    LEASE,
    name_of,
    qos_mismatch,
)
from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES, OUTPUTS
from tcp_muscle_ros.recording.units import GRAVITY

LATENESS = 'command_lateness'  # s, of each command
NAME = 'protocol_runner'
_MEASURED = (*OUTPUTS, 'current')
_HEARD_WITHIN = 10.0  # s, in which a muscle answers
_SPEAKS_WITHIN = 60.0  # s, in which one that takes commands says what it measures: on a busy machine it may be starting
_DIAGNOSED_WITHIN = 2.5  # s: they come once a second
_SAY_AGAIN = 15.0  # s
_COLD_WITHIN = 900.0  # s, in which a muscle cools
_LOOK = 1.0  # s between two looks at who else commands
_TAIL = 0.2  # s of zero at the end of a part
_SWITCH = 1e-4  # s that the recorder's thread may keep a command that is due from going out
_BEST_EFFORT = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)


@dataclass(frozen=True)
class Answer:
    """What the muscle's driver says of itself in /diagnostics; None where it does not."""

    name: str = ''
    current_limit: float | None = None  # A
    derate_temperature: float | None = None  # K


@dataclass(frozen=True)
class Played:
    """How a part went. ``stopped``: why it ended early, '' where it did not. ``lateness`` s, of each command.
    ``overheated``: whether the temperature was why."""

    stopped: str
    lateness: tuple[float, ...]
    overheated: bool = False


class Runner:
    """A commander of one muscle. Use as a context manager. ``topics`` are recorded beside those of the muscle.

    Raises:
        BadInput: no such namespace, no muscle that answers, or another commander.
    """

    def __init__(
        self, namespace: str, kind: str, hottest: float, say: Callable[[str], None], topics: Sequence[str] = ()
    ) -> None:
        self._namespace = '/' + namespace.strip('/')
        self._kind = kind
        self._wanted = topics
        self._say = say
        self._supervisor = Supervisor(hottest)
        self._hottest = hottest
        self._answers: dict[str, DiagnosticStatus] = {}
        self._cold: Cold | None = None
        self._inputs = Inputs()
        self._time: RealTime | LockstepTime = RealTime(self._inputs.take)
        self._recording: RecorderBeside | None = None
        self.asked = False  # to stop, by a signal
        self._prompting = False

    def __enter__(self) -> Runner:
        with ExitStack() as ending:
            for number in (signal.SIGINT, signal.SIGTERM):
                ending.callback(signal.signal, number, signal.signal(number, self._on_signal))
            rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
            ending.callback(rclpy.try_shutdown)
            try:
                self._node = Node(NAME, namespace=self._namespace, enable_rosout=False)
            except InvalidNamespaceException as error:
                raise BadInput(f'--namespace {self._namespace}: {" ".join(str(error).split())}') from None
            ending.callback(self._node.destroy_node)
            self._topics = {kind: self._resolved(f'{kind}_command') for kind in DRIVES}
            self._rivals = Rivals(self._node, self._topics, self._kind, self._answers)
            self._command = self._publisher(f'{self._kind}_command')
            self._load, self._late = self._publisher('load'), self._publisher(LATENESS)
            ending.callback(self._zero)
            for name in _MEASURED:
                kind = Temperature if CHANNELS[name].stamped else Float64
                self._listen(CHANNELS[name].topic, kind, partial(self._hear, name))
            self._listen('/diagnostics', DiagnosticArray, self._diagnose_all)
            self._wait_for_muscle()
            self._ending = ending.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.close()

    def _on_signal(self, *_: object) -> None:
        self.asked = True
        if self._prompting:
            raise KeyboardInterrupt

    def _resolved(self, topic: str) -> str:
        name: str = self._node.resolve_topic_name(topic)
        return name

    def _publisher(self, topic: str) -> NumberPublisher:
        return NumberPublisher(self._node.create_publisher(Float64, topic, COMMAND_QOS))

    def _listen(self, topic: str, kind: type, take: Callable[[Any], None]) -> None:
        subscription = self._node.create_subscription(
            kind, topic, take, _BEST_EFFORT, callback_group=self._inputs.group
        )
        self._inputs.add(subscription, kind, take)

    def _wait_for_muscle(self) -> None:
        self._say(f'waiting for a muscle under {self._namespace}')
        begun = time.monotonic()
        while not self._supervisor.heard or not self._command.publisher.get_subscription_count():
            self._pause()
            self._join()
            patience = _SPEAKS_WITHIN if self._command.publisher.get_subscription_count() else _HEARD_WITHIN
            if time.monotonic() - begun > patience:
                raise BadInput(f'under {self._namespace} {self._lacking()} within {patience:.0f} s')
        answered = time.monotonic()
        while not self._rivals.told_of_me() and time.monotonic() - answered < _DIAGNOSED_WITHIN:
            self._pause()
        self._rivals.refuse(NAMED_WITHIN, self._pause, self._say)
        for topic in (self._resolved(CHANNELS[name].topic) for name in _MEASURED):
            if told := mixed(topic, self._node.get_publishers_info_by_topic(topic)):
                self._say(told)

    def _lacking(self) -> str:
        """What has not come, and how to mend that."""
        mend = 'start a muscle, or give its --namespace'
        if self._command.publisher.get_subscription_count():
            return f'a node takes commands, but publishes no measurement ({mend})'
        if not self._supervisor.heard:
            return f'no muscle answers ({mend})'
        topic = self._topics[self._kind]
        for end in self._node.get_subscriptions_info_by_topic(topic):
            if why := qos_mismatch(self._command.publisher.qos_profile, end.qos_profile):
                return f'a muscle is measured, but {name_of(end)} takes {topic} with an incompatible QoS: {why};'
        return f'a muscle is measured, but no node takes {topic} (start its driver, or play a current)'

    def _join(self) -> None:
        """Where a simulation in lockstep is the muscle, its ticks are the time from now on."""
        measured = (self._resolved(CHANNELS[name].topic) for name in _MEASURED)
        if isinstance(self._time, RealTime) and leads(self._node, measured):
            self._time, self._supervisor = LockstepTime(self._node, self._take_tick), Supervisor(self._hottest)

    # What is heard

    def _take_tick(self, sent: int) -> None:
        """In lockstep: what belongs to a tick of the simulation, all of it."""
        self._inputs.take_tick(sent)
        self._record()

    def _record(self) -> None:
        """In lockstep: what has come is recorded as of the present tick."""
        if self._recording is not None and isinstance(self._time, LockstepTime):
            self._recording.take(self._time.tick)

    def _hear(self, name: str, message: Any) -> None:
        now = self._time.now()
        self._supervisor.hear(name, now)
        if name == 'temperature':
            temperature = message.temperature + ZERO_CELSIUS
            self._supervisor.temperature(temperature)
            if self._cold is not None:
                self._cold.measure(temperature, now)

    def _diagnose_all(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._diagnose(status)

    def _diagnose(self, status: DiagnosticStatus) -> None:
        facts = {value.key: value.value for value in status.values}
        if 'current_limit_a' not in facts or NAME in status.name:
            return
        if speaks_for(self._namespace, status.name) or status.name in self._takers():
            self._answers[status.name] = status
            # What is heard before a part is a matter for `answer`: a person may disable a muscle to hang a load.
            disabled = facts.get('state') == 'disabled' and self._recording is not None
            if disabled or status.level == DiagnosticStatus.ERROR:
                self._supervisor.end(f'{status.name}: {status.message}')

    def _takers(self) -> set[str]:
        """The nodes that take the commands, in whatever namespace they are."""
        return {name_of(end) for end in self._node.get_subscriptions_info_by_topic(self._topics[self._kind])}

    def answer(self) -> Answer:
        """What the muscle's driver says of its limits. BadInput where it lets no current flow."""
        for name, status in self._answers.items():
            facts = {value.key: value.value for value in status.values}
            if facts.get('state') in ('disabled', 'fault'):
                raise BadInput(f'{name} is {status.message}; enable it, or clear its fault, first')
            derate = facts.get('derate_temperature_c')
            return Answer(
                name,
                float(facts['configured_current_limit_a']) if 'configured_current_limit_a' in facts else None,
                float(derate) + ZERO_CELSIUS if derate else None,
            )
        return Answer()

    def _pause(self) -> None:
        """Take what comes in a turn, unless asked to stop."""
        self._time.turn()
        if self.asked:
            raise KeyboardInterrupt
        if why := self._time.lost:
            raise BadInput(why)

    # What is done

    def hang(self, load: float, ask: Callable[[str], str] | None) -> None:
        """Change the load (N): the rig does it, or ``ask`` a person to. BadInput where nobody is there."""
        self._zero()
        if ask is not None:
            self._prompting = True
            try:
                ask(f'hang {1e3 * load / GRAVITY:.0f} g ({load:.3g} N), press Enter ')
            except EOFError:
                raise BadInput('nobody is there to change the load; --yes where the rig does it by itself') from None
            finally:
                self._prompting = False
        self._load.send(load)

    def wait_until_cold(self, ambient: float, time_constant: float) -> None:
        """Without current until the muscle is cold; without a thermometer for five of its time constants (s).

        BadInput where another node commands it: what that heats never is.
        """
        self._cold = cold = Cold(ambient)
        begun = look_next = self._time.now()
        say_next = begun + 3.0
        self._supervisor.listen_anew(begun)  # while a person hung the load nobody listened
        while not cold.reached(now := self._time.now()):
            self._pause()
            if 'temperature' not in self._supervisor.heard and now - begun > 5.0 * time_constant:
                break
            if now > look_next:
                look_next = now + _LOOK
                self._rivals.refuse_latecomers()
            if now > say_next:
                say_next = now + _SAY_AGAIN
                shown = '' if cold.temperature is None else f': {celsius(cold.temperature)}, room {celsius(ambient)}'
                self._say(f'waiting for the muscle to be cold{shown}')
            if now - begun > _COLD_WITHIN:
                raise BadInput(f'the muscle is not cold after {_COLD_WITHIN:.0f} s without a current')
        self._cold = None

    def play(self, part: Part, bag: Path, known: Mapping[str, object]) -> Played:
        """Play a part and record it. Ends with 0 A, whatever happens; the bag is complete up to then."""
        when, drives, loads = (values.tolist() for values in instants(part))
        lateness: list[float] = []
        self._rivals.refuse(LEASE, self._pause, self._say)
        with self._recorded(bag, known) as recorded:
            supervisor = self._supervisor
            supervisor.begin()
            begun, looked = self._time.soon(), 0.0
            load_now: float | None = None
            try:
                for due, drive, load in zip(when, drives, loads, strict=True):
                    self._wait(begun + due)
                    if self._over():
                        break
                    if load != load_now:
                        self._load.send(load)
                        load_now = load
                    self._command.send(drive)
                    late = self._time.now() - begun - due
                    lateness.append(late)
                    self._late.send(late)
                    self._inputs.take()
                    self._record()
                    if due - looked > _LOOK:
                        looked = due
                        if other := self._rivals.newcomer():
                            supervisor.end(f'{other} commands this muscle too')
                    if recorded.failure is not None:
                        raise recorded.failure
                else:
                    self._wait(begun + float(part.time[-1]))
            finally:
                self._zero()
            self._tail()
        stopped = 'interrupted' if self.asked else supervisor.problem
        return Played(stopped, tuple(lateness), supervisor.overheated and not self.asked)

    def _over(self) -> bool:
        if why := self._time.lost:
            self._supervisor.end(why)
        return self.asked or bool(self._supervisor.look(self._time.now()))

    def _wait(self, due: float) -> None:
        """Until it is due; what comes meanwhile is looked at."""
        while not self._time.reached(due) and not self._over():
            pass

    def _tail(self) -> None:
        """What follows the last command is recorded too."""
        end = self._time.now() + _TAIL
        while not self._time.reached(end) and not self._time.lost:
            pass

    def _zero(self) -> None:
        self._command.send(0.0)
        self._command.publisher.wait_for_all_acked(Duration(seconds=0.5))

    @contextmanager
    def _recorded(self, bag: Path, known: Mapping[str, object]) -> Iterator[RecorderBeside]:
        """Record to a new bag while in it, from when every measurement has reached it."""
        in_thread = isinstance(self._time, RealTime)
        self._recording = recording = RecorderBeside(
            bag, self._namespace, known, {LATENESS: Float64}, self._wanted, in_thread
        )
        before = sys.getswitchinterval()
        try:
            more = {self._resolved(topic) for topic in self._wanted}
            wanted = more | {self._resolved(CHANNELS[name].topic) for name in self._supervisor.heard}
            begun = time.monotonic()
            while not wanted <= recording.topics and time.monotonic() - begun < _HEARD_WITHIN:
                self._pause()
                if recording.failure is not None:
                    raise recording.failure
            if lacking := sorted(more - recording.topics):
                raise BadInput(f'nothing came on {", ".join(lacking)} within {_HEARD_WITHIN:g} s{recording.absent}')
            sys.setswitchinterval(_SWITCH)
            yield recording
        finally:
            sys.setswitchinterval(before)
            self._recording = None
            recording.end()


def speaks_for(namespace: str, name: str) -> bool:
    """Whether a status of this name in /diagnostics is of the muscle under a namespace (``/``, ``/hand/thumb``).

    The name is that of a node in it, or of one above it that has several muscles, with the muscle's below. A driver of
    another package may give its name without a namespace.
    """
    above, slash, own = name.rpartition('/')
    of_several = f'{above.rpartition("/")[0]}/{own}'
    return not slash or above == namespace.rstrip('/') or (bool(above) and of_several == namespace)
