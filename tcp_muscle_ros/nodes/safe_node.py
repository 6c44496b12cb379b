"""What both nodes are made of: parameters, the safety machine, a tick at a fixed rate, services and diagnostics."""

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.time import Time
from std_srvs.srv import SetBool, Trigger

from tcp_muscle_ros.control.safety import Limits, Report, Safety, State, celsius
from tcp_muscle_ros.nodes.parameters import KNOWN, Settings, declare
from tcp_muscle_ros.nodes.ticks import BACKLOG, RosTime, SteadyTime, TickLoop, TimeBase

STATE_QOS = QoSProfile(depth=BACKLOG)  # reliable, keep last
COMMAND_QOS = QoSProfile(depth=1)  # reliable, keep last: only the newest command counts
_QUIET = (State.ENABLED, State.DISABLED)


class SafeNode(Node):
    """A node that decides a current once a tick and may never leave one on.

    A subclass says what it needs (``check``, ``limits_of``, ``apply``), does its work in ``work`` once a tick, forgets
    what it knows in ``forget`` and turns the current off in ``publish_zero``. Callbacks of the executor's thread and
    ``work`` exclude each other by ``lock``.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.lock = threading.RLock()
        self.settings: Settings = declare(self, name, self.check, self._set)
        self.rate = float(self.settings['rate_hz'])
        self.period = 1.0 / self.rate
        self.safety = Safety(self.limits_of(self.settings), enabled=self.settings['start_enabled'])
        self.refused_inputs: Counter[str] = Counter()
        self.time_base = self.make_time_base()
        self.loop: TickLoop | None = None

        self._told = self.safety.state
        self._changes: deque[Report] = deque(maxlen=20)
        self._counted = self.safety.report()
        self._missed, self._jumps = 0, 0
        self._clock_then = -1
        self._started = time.monotonic()
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', STATE_QOS)
        self._change = self.create_guard_condition(self._tell_changes)
        # On the steady clock: it must also speak while /clock is silent.
        self.create_timer(1.0, self._look_after, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.create_service(SetBool, '~/enable', self._enable)
        self.create_service(Trigger, '~/reset', self._reset)
        self.create_service(Trigger, '~/clear_fault', self._clear_fault)

    # What a subclass brings

    def check(self, settings: Settings) -> None:
        """Raise BadInput against values that do not go together."""
        self.limits_of(settings)
        settings.muscle()

    def limits_of(self, settings: Settings) -> Limits:
        """The safety limits that the values describe."""
        raise NotImplementedError

    def apply(self, settings: Settings) -> None:
        """Take over values that were set while running."""
        raise NotImplementedError

    def work(self, stamp: int, dt: float, now: float, publish: bool) -> None:
        """One tick: stamp in ns, dt in s since the last, ``now`` in s of steady time."""
        raise NotImplementedError

    def forget(self) -> str:
        """~/reset: begin anew; returns what was done."""
        raise NotImplementedError

    def publish_zero(self) -> Sequence[Publisher]:
        """Publish 0 A; returns the publishers."""
        raise NotImplementedError

    def worries(self) -> Iterable[str]:
        """What an operator should look at, beside safety."""
        return ()

    def facts(self) -> Mapping[str, str]:
        """More values for the diagnostics."""
        return {}

    def make_time_base(self) -> TimeBase:
        """The clock that the ticks keep to."""
        if self.get_parameter('use_sim_time').value:
            return RosTime(self.get_clock())
        return SteadyTime(self.get_clock())

    # Life (see lifetime.py)

    def start(self, on_failure: Callable[[], None]) -> None:
        """Begin to tick."""
        self.loop = TickLoop(
            self.time_base, self.rate, self._tick, longest_step=self.settings.longest_step, on_failure=on_failure
        )
        self.loop.start()

    def stop(self) -> Sequence[Publisher]:
        """Stop ticking and publish 0 A."""
        if self.loop is not None:
            self.loop.stop()
        with self.lock:
            self.safety.disable()
            return self.publish_zero()

    @property
    def failure(self) -> BaseException | None:
        """What ended the ticks, if anything did."""
        return None if self.loop is None else self.loop.failure

    # Help for a subclass

    def accept(self, name: str, value: float, like: str) -> bool:
        """Whether an input is within the bounds of the parameter ``like``; if not, it is counted and logged."""
        row = KNOWN[like]
        return self.within(name, value, row.low, row.high, row.unit)

    def within(self, name: str, value: float, low: float, high: float, unit: str) -> bool:
        """Whether an input is a number within the bounds; if not, it is counted and logged."""
        if low <= value <= high:  # False for NaN
            return True
        self.refused_inputs[name] += 1
        self.get_logger().warning(
            f'{name} of {value:g} refused; expected {low:g} to {high:g} {unit}', throttle_duration_sec=5.0
        )
        return False

    def _tick(self, stamp: int, dt: float, publish: bool) -> None:
        with self.lock:
            self.work(stamp, dt, time.monotonic(), publish)
            self._notice_change()

    def _notice_change(self) -> None:
        if self.safety.state is not self._told:
            self._told = self.safety.state
            self._changes.append(self.safety.report())
            self._change.trigger()

    def _watch_clock(self) -> None:
        """Where /clock has stood still since the last look, no tick will turn the current off: do it here."""
        now = self.time_base.now()
        if isinstance(self.time_base, RosTime) and now == self._clock_then and self.safety.state.lets_flow:
            self.safety.pause('/clock stands still')
            self.publish_zero()
            self._notice_change()
        self._clock_then = now

    def _set(self, settings: Settings) -> None:
        with self.lock:
            self.settings = settings
            self.safety.limits = self.limits_of(settings)
            self.apply(settings)

    # Services

    def _enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        with self.lock:
            if request.data:
                refused = self.safety.enable()
                response.success, response.message = not refused, refused or 'enabled'
            else:
                self.safety.disable()
                self.publish_zero()
                response.success, response.message = True, 'disabled, 0 A'
        return response

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self.lock:
            response.success, response.message = True, self.forget()
        self.get_logger().info(response.message)
        return response

    def _clear_fault(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        with self.lock:
            refused = self.safety.clear_fault()
        response.success, response.message = not refused, refused or 'no fault'
        return response

    # Diagnostics

    def _tell_changes(self) -> None:
        while self._changes:
            report = self._changes.popleft()
            self._log(report)
            self._publish_diagnostics(report)

    def _log(self, report: Report) -> None:
        log = self.get_logger()
        if report.state is State.FAULT:
            log.error(f'fault latched, 0 A: {report.why}; when its cause is gone, command 0 and call ~/clear_fault')
        elif report.state is State.TIMED_OUT:
            log.warning(f'0 A: {report.why}')
        elif report.state is State.DERATING:
            assert report.temperature is not None
            log.warning(
                f'derating at {celsius(report.temperature)}: limit {report.limit:.3f} A', throttle_duration_sec=10.0
            )
        else:
            log.info(f'{report.state.value}')

    def _look_after(self) -> None:
        """Once a second: diagnostics, and a line of log for what was counted meanwhile."""
        log = self.get_logger()
        with self.lock:
            self._watch_clock()
            report = self.safety.report()
        if report.rejected > self._counted.rejected:
            log.warning(f'{report.rejected - self._counted.rejected} refused: {report.last_rejected}')
        jumps = 0 if self.loop is None else self.loop.jumps
        if jumps > self._jumps:
            log.warning('the clock jumped: the step was skipped')
        if self.loop is not None and self.loop.waiting_for_clock and time.monotonic() - self._started > 5.0:
            log.warning('use_sim_time is true, but no /clock has come', throttle_duration_sec=10.0)
        self._publish_diagnostics(report)
        self._counted, self._jumps = report, jumps
        self._missed = 0 if self.loop is None else self.loop.missed

    def _publish_diagnostics(self, report: Report) -> None:
        worries = list(self.worries())
        missed = 0 if self.loop is None else self.loop.missed
        if missed - self._missed > 0.01 * self.rate:
            worries.append('more than 1 % of the ticks missed')
        message = ', '.join(filter(None, (report.state.value, report.why, *worries)))
        if report.state is State.FAULT:
            level = DiagnosticStatus.ERROR
        elif worries or report.state not in _QUIET:
            level = DiagnosticStatus.WARN
        else:
            level = DiagnosticStatus.OK
        facts = {
            'state': report.state.value,
            'current_a': f'{report.current:.6g}',
            'current_limit_a': f'{report.limit:.6g}',
            'limited_by': ', '.join(report.limited_by) or 'nothing',
            'hottest_c': 'unknown' if report.temperature is None else celsius(report.temperature),
            'command_age_s': 'none yet' if report.command_age is None else f'{report.command_age:.3f}',
            'rejected_commands': str(report.rejected),
            'refused_inputs': ', '.join(f'{name} {count}' for name, count in self.refused_inputs.items()) or 'none',
            'command_timeouts': str(report.timeouts),
            'skipped_steps': str(report.skipped),
            'ticks': str(0 if self.loop is None else self.loop.ticks),
            'missed_ticks': str(missed),
            'unpublished_ticks': str(0 if self.loop is None else self.loop.unpublished),
            'clock_jumps': str(0 if self.loop is None else self.loop.jumps),
            **self.facts(),
        }
        status = DiagnosticStatus(
            level=level,
            name=self.get_fully_qualified_name(),
            message=message,
            hardware_id=self.settings['joint_name'],
            values=[KeyValue(key=key, value=value) for key, value in facts.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = Time(nanoseconds=max(self.time_base.now(), 0)).to_msg()
        self._diagnostics.publish(array)
