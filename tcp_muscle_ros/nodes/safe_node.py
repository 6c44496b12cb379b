"""What both nodes are made of: muscles with their safety machines, a tick at a fixed rate, services and diagnostics."""

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.time import Time
from std_srvs.srv import SetBool, Trigger

from tcp_muscle_ros.control.safety import Report, State
from tcp_muscle_ros.nodes.declaring import DeclaredNode, declare
from tcp_muscle_ros.nodes.lockstep import FollowingTime, LeadingTime
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.plan import Plan
from tcp_muscle_ros.nodes.polled import Inputs
from tcp_muscle_ros.nodes.safe_muscle import SafeMuscle
from tcp_muscle_ros.nodes.ticks import NO_CLOCK, STANDS_STILL, SteadyTime, TickLoop, TimeBase
from tcp_muscle_ros.nodes.topics import REMEMBERED, STATE_QOS, Topics

M = TypeVar('M', bound=SafeMuscle)


class SafeNode(DeclaredNode, Generic[M]):
    """A node that decides one current a muscle once a tick and may never leave one on.

    A subclass makes its muscles (``make_muscle``), checks values (``check``) and does its work in ``work`` once a tick.
    Callbacks of the executor's thread and ``work`` exclude each other by ``lock``.

    One muscle hears its inputs as they come; several, and all in simulated time, have theirs looked at once a tick,
    before ``work``.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.lock = threading.RLock()
        self._inputs = Inputs()
        self.topics = Topics(self)
        self.unmatched: dict[str, str] = {}  # by topic, who there cannot be reached and why; looked at once a second
        self.plan: Plan = declare(self, name, self.check, self._set)
        self.common = next(iter(self.plan.muscles.values()))  # any muscle's values: for those that are the node's
        self.rate = float(self.common['rate_hz'])
        self.period = 1.0 / self.rate
        self.time_base = self.make_time_base()
        self.loop: TickLoop | None = None
        self.by_name: dict[str, M] = {
            muscle: self.make_muscle(muscle, settings) for muscle, settings in self.plan.muscles.items()
        }
        self.muscles: list[M] = list(self.by_name.values())

        self._changes: deque[tuple[M, Report]] = deque(maxlen=20 * len(self.muscles))
        self._missed, self._jumps = 0, 0
        self._alone, self._namesake = time.monotonic(), False
        self._started = time.monotonic()
        self._diagnostics = self.topics.publisher(DiagnosticArray, '/diagnostics', STATE_QOS)
        self._change = self.create_guard_condition(self._tell_changes)
        # On the steady clock: it must also speak while /clock is silent.
        self.create_timer(1.0, self._look_after, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._serve('~', self.muscles, self.forget)
        if self.plan.many:
            for muscle in self.muscles:
                self._serve(f'~/{muscle.name}', [muscle], partial(self._forget_one, muscle))

    # What a subclass brings

    def check(self, settings: Settings) -> None:
        """Raise BadInput against a muscle's values that do not go together."""
        raise NotImplementedError

    def make_muscle(self, name: str, settings: Settings) -> M:
        """What the node keeps of a muscle."""
        raise NotImplementedError

    def apply_joint(self, name: str, settings: Settings) -> None:
        """Take over values of a joint that were set while running."""

    def work(self, stamp: int, dt: float, now: float, publish: bool) -> None:
        """One tick: stamp in ns, dt in s since the last, ``now`` in s of steady time."""
        raise NotImplementedError

    def more_statuses(self) -> list[DiagnosticStatus]:
        """What diagnostics say once a second beside the muscles'."""
        return []

    def make_time_base(self) -> TimeBase:
        """The clock that the ticks keep to."""
        if self.get_parameter('use_sim_time').value:
            return FollowingTime(self, self._take_tick)
        return SteadyTime(self.get_clock())

    def forget(self) -> str:
        """~/reset: every muscle begins anew; returns what was done."""
        done = [(muscle.said, muscle.forget()) for muscle in self.muscles]
        said = {what for _, what in done}
        return said.pop() if len(said) == 1 else '; '.join(name + what for name, what in done)

    def _forget_one(self, muscle: M) -> str:
        return muscle.said + muscle.forget()

    # Life (see lifetime.py)

    def start(self, on_failure: Callable[[], None]) -> None:
        """Begin to tick."""
        for sentence in self.topics.unused_overrides():
            self.get_logger().warning(sentence)
        if isinstance(self.time_base, FollowingTime | LeadingTime):
            self.time_base.open(self.topics)
        self.loop = TickLoop(
            self.time_base, self.rate, self._tick, longest_step=self.common.longest_step, on_failure=on_failure
        )
        self.loop.start()

    def stop(self) -> Sequence[Publisher]:
        """Stop ticking and publish 0 A."""
        if self.loop is not None:
            self.loop.stop()
        with self.lock:
            for muscle in self.muscles:
                muscle.safety.disable()
            return [publisher for muscle in self.muscles for publisher in muscle.publish_zero()]

    @property
    def failure(self) -> BaseException | None:
        """What ended the ticks, if anything did."""
        return None if self.loop is None else self.loop.failure

    def listen(self, kind: type, topic: str, take: Callable[[Any], None], qos: QoSProfile) -> None:
        """Have the messages of a topic taken: as they come, or with several muscles at the next tick."""
        if self.plan.many or isinstance(self.time_base, FollowingTime | LeadingTime):
            self._inputs.add(self.topics.subscription(kind, topic, take, qos, self._inputs.group), kind, take)
        else:
            self.topics.subscription(kind, topic, take, qos)

    def seconds(self) -> float:
        """The time that watchdogs go by, s."""
        return self.time_base.seconds()

    def _take_tick(self, sent: int) -> None:
        """In lockstep: what belongs to a tick of the simulation, all of it."""
        with self.lock:
            lacking = self._inputs.take_tick(sent)
        if lacking:
            self.get_logger().warning(f'lockstep: nothing on {", ".join(sorted(lacking))} with its tick')

    def _tick(self, stamp: int, dt: float, publish: bool) -> None:
        with self.lock:
            if not self.time_base.collects:
                self._inputs.take()
            self.work(stamp, dt, self.seconds(), publish)
            self._notice_changes()

    def _notice_changes(self) -> None:
        noticed = False
        for muscle in self.muscles:
            report = muscle.changed_state()
            if report is not None:
                self._changes.append((muscle, report))
                noticed = True
        if noticed:
            self._change.trigger()

    def _watch_clock(self) -> None:
        """Where the clock stands still, no tick will turn the current off: do it here."""
        if self.time_base.stands_still():
            for muscle in self.muscles:
                if muscle.safety.state.lets_flow:
                    muscle.safety.pause(STANDS_STILL)
                    muscle.publish_zero()
            self._notice_changes()

    def _set(self, name: str, settings: Settings) -> None:
        with self.lock:
            if name in self.by_name:
                self.by_name[name].change(settings)
            else:
                self.apply_joint(name, settings)

    # Services

    def _serve(self, prefix: str, muscles: Sequence[M], forget: Callable[[], str]) -> None:
        """The three services, for one muscle or for all."""

        def each(work: Callable[[M], str]) -> str:
            with self.lock:
                refused = [muscle.said + why for muscle in muscles if (why := work(muscle))]
            return '; '.join(refused)

        def enable(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
            refused = each(lambda muscle: muscle.enable(request.data))
            response.success = not refused
            response.message = refused or ('enabled' if request.data else 'disabled, 0 A')
            return response

        def reset(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            with self.lock:
                response.success, response.message = True, forget()
            self.get_logger().info(response.message)
            return response

        def clear_fault(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            faulty = any(muscle.safety.state is State.FAULT for muscle in muscles)
            refused = each(lambda muscle: muscle.safety.clear_fault())
            response.success = not refused
            response.message = refused or ('fault cleared' if faulty else 'there was no fault')
            return response

        self.create_service(SetBool, f'{prefix}/enable', enable)
        self.create_service(Trigger, f'{prefix}/reset', reset)
        self.create_service(Trigger, f'{prefix}/clear_fault', clear_fault)

    # Diagnostics

    def _tell_changes(self) -> None:
        changed = []
        while self._changes:
            muscle, report = self._changes.popleft()
            muscle.tell(report)
            changed.append((muscle, report))
            if not self.plan.many:
                self._publish_diagnostics(changed)
                changed = []
        if changed:
            self._publish_diagnostics(changed)

    def _look_after(self) -> None:
        """Once a second: diagnostics, and a line of log for what was counted meanwhile."""
        log = self.get_logger()
        for muscle in self.muscles:
            muscle.look_for_others(self)
        self._look_for_namesake()
        with self.lock:
            self._watch_clock()
            reports = [(muscle, muscle.safety.report()) for muscle in self.muscles]
            more = self.more_statuses()
        for muscle, report in reports:
            muscle.tell_refused(report)
        jumps = 0 if self.loop is None else self.loop.jumps
        if jumps > self._jumps:
            log.warning('the clock jumped: the step was skipped')
        if self.loop is not None and self.loop.waiting_for_clock and time.monotonic() - self._started > 5.0:
            log.warning(NO_CLOCK, throttle_duration_sec=10.0)
        self._publish_diagnostics(reports, more)
        self._jumps = jumps
        self._missed = 0 if self.loop is None else self.loop.missed
        self.look_for_unmatched()  # last: the ticks until the next look take it into what they say

    def _look_for_namesake(self) -> None:
        """Ask the graph whether another node has this one's name: two controllers, or two muscles, would fight."""
        own = self.get_name(), self.get_namespace()
        if sum(each == own for each in self.get_node_names_and_namespaces()) < 2:
            self._alone = time.monotonic()
        was, self._namesake = self._namesake, time.monotonic() - self._alone > REMEMBERED
        if self._namesake and not was:
            self.get_logger().warning(f'{self._namesake_told()}; stop one of them')

    def _namesake_told(self) -> str:
        return f'another node is named {self.get_fully_qualified_name()} too'

    def look_for_unmatched(self) -> None:
        """Ask the graph who there is not heard, or does not hear."""
        self.unmatched = self.topics.mismatches_since(self.unmatched, self.get_logger().warning)

    def _publish_diagnostics(self, reports: Iterable[tuple[M, Report]], more: Iterable[DiagnosticStatus] = ()) -> None:
        loop = self.loop
        missed = 0 if loop is None else loop.missed
        worries = [*self.unmatched.values(), *([self._namesake_told()] if self._namesake else [])]
        if held_up := self.time_base.held_up():
            worries.append(held_up)
        if missed - self._missed > 0.01 * self.rate:
            worries.append('more than 1 % of the ticks missed')
        facts = {
            'ticks': str(0 if loop is None else loop.ticks),
            'missed_ticks': str(missed),
            'unpublished_ticks': str(0 if loop is None else loop.unpublished),
            'clock_jumps': str(0 if loop is None else loop.jumps),
        }
        array = DiagnosticArray(status=[*(muscle.status(report, worries, facts) for muscle, report in reports), *more])
        array.header.stamp = Time(nanoseconds=max(self.time_base.now(), 0)).to_msg()
        self._diagnostics.publish(array)
