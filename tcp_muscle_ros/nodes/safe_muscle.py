"""One muscle of a node: its values, its safety machine, its topics, and what diagnostics say of it."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from tcp_muscle_ros.control.safety import Kind, Limits, Report, Safety, State, celsius
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.nodes.home import Home
from tcp_muscle_ros.nodes.parameters import KNOWN, Settings
from tcp_muscle_ros.nodes.serialized import NumberPublisher
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, COMMANDED_BY, NOBODY, REMEMBERED, STATE_QOS, Commanders

_QUIET = (State.ENABLED, State.DISABLED)
_SILENT = 5.0  # s, for which the log says no more of an input that is refused over and over


def number(value: float | None) -> str:
    """A value of /diagnostics as plotting programs read it, the unit being in its key: nan where there is none."""
    return 'nan' if value is None else f'{value:.6g}'


class SafeMuscle:
    """What a node knows of one muscle. A subclass says what it needs and does with it.

    ``name`` is '' where the node has one muscle; else its topics stand below its name.
    """

    def __init__(self, node: Home, name: str, settings: Settings) -> None:
        self.node, self.name, self.settings = node, name, settings
        self.safety = Safety(self.limits_of(settings), enabled=settings['start_enabled'])
        self.frame = f'{settings["joint_name"]}_moving_end'  # the link of urdf/tcp_muscle_macros.xacro that moves
        self.refused_inputs: Counter[str] = Counter()
        self._refused_at: dict[str, float] = {}  # s, steady: when the log last said so of each
        self.said = f'{name}: ' if name else ''  # before what the log says of it
        self._told = self.safety.state
        self._counted = 0
        self._graph, self._commanders = Commanders(), tuple[str, ...]()

    # What a subclass brings

    def limits_of(self, settings: Settings) -> Limits:
        """The safety limits that the values describe."""
        raise NotImplementedError

    def apply(self, settings: Settings) -> None:
        """Take over values that were set while running; they are in ``settings`` already."""
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

    # Topics

    def topic(self, name: str) -> str:
        """A topic of this muscle, relative to the node's namespace."""
        return f'{self.name}/{name}' if self.name else name

    def publisher(self, name: str, qos: QoSProfile = STATE_QOS) -> NumberPublisher:
        """A publisher of one number."""
        return NumberPublisher(self.node.topics.publisher(Float64, self.topic(name), qos))

    def listen(self, kind: type, name: str, take: Callable[[Any], None], qos: QoSProfile = COMMAND_QOS) -> None:
        """Have the messages of a topic taken."""
        self.node.listen(kind, self.topic(name), take, qos)

    def accept(self, name: str, value: float, like: str) -> bool:
        """Whether an input is within the bounds of the parameter ``like``; if not, it is counted and logged."""
        row = KNOWN[like]
        return self.within(name, value, row.low, row.high, row.unit)

    def within(self, name: str, value: float, low: float, high: float, unit: str) -> bool:
        """Whether an input is a number within the bounds; if not, it is counted and logged."""
        if low <= value <= high:  # False for NaN
            return True
        self.refused_inputs[name] += 1
        # Of each input by itself: one that is wrong all the time would hide another, of any muscle of the node.
        now = time.monotonic()
        if now - self._refused_at.get(name, -inf) >= _SILENT:
            self._refused_at[name] = now
            self.node.get_logger().warning(
                f'{self.said}{name} of {value:g} refused; expected {low:g} to {high:g} {unit}'
            )
        return False

    def look_for_others(self, node: Node) -> None:
        """Ask the graph who else commands this muscle; what is found is a worry, and logged once."""
        topics = {node.resolve_topic_name(self.topic(f'{kind.name.lower()}_command')) for kind in Kind}
        commanders = tuple(sorted(self._graph.look(node, topics, REMEMBERED)))
        if len(commanders) > 1 and commanders != self._commanders:
            node.get_logger().warning(f'{self.said}{_several(commanders)}; stop all but one')
        self._commanders = commanders

    # State

    def change(self, settings: Settings) -> None:
        """Take over values that were set while running."""
        self.settings = settings
        self.safety.limits = self.limits_of(settings)
        self.apply(settings)

    def changed_state(self) -> Report | None:
        """A report if the safety machine is in another state than when last asked."""
        if self.safety.state is self._told:
            return None
        self._told = self.safety.state
        return self.safety.report()

    def enable(self, on: bool) -> str:
        """Let current flow or not; returns '' or why it was refused."""
        if on:
            return self.safety.enable()
        self.safety.disable()
        self.publish_zero()
        return ''

    def tell(self, report: Report) -> None:
        """Log a state that it has come into."""
        log = self.node.get_logger()
        if report.state is State.FAULT:
            log.error(
                f'{self.said}fault latched, 0 A: {report.why}; when its cause is gone, command 0 and call ~/clear_fault'
            )
        elif report.state is State.TIMED_OUT:
            log.warning(f'{self.said}0 A: {report.why}')
        elif report.state is State.DERATING:
            assert report.temperature is not None
            log.warning(
                f'{self.said}derating at {celsius(report.temperature)}: limit {report.limit:.3f} A',
                throttle_duration_sec=10.0,
            )
        else:
            log.info(f'{self.said}{report.state.value}')

    def tell_refused(self, report: Report) -> None:
        """Log how many commands were refused since last asked."""
        if report.rejected > self._counted:
            self.node.get_logger().warning(
                f'{self.said}{report.rejected - self._counted} refused: {report.last_rejected}'
            )
        self._counted = report.rejected

    def status(self, report: Report, node_worries: Iterable[str], node_facts: Mapping[str, str]) -> DiagnosticStatus:
        """What /diagnostics says of it."""
        worries = [*self.worries(), *node_worries]
        if len(self._commanders) > 1:
            worries.append(_several(self._commanders))
        if report.state is State.FAULT:
            level = DiagnosticStatus.ERROR
        elif worries or report.state not in _QUIET:
            level = DiagnosticStatus.WARN
        else:
            level = DiagnosticStatus.OK
        with self.node.lock:  # a tick of several muscles takes inputs, and may refuse one of a new name meanwhile
            refused = dict(self.refused_inputs)
        facts = {
            'state': report.state.value,
            'current_a': number(report.current),
            'current_limit_a': number(report.limit),
            'configured_current_limit_a': f'{self.settings["current_limit_a"]:.6g}',
            'derate_temperature_c': f'{self.settings["derate_temperature_c"]:.6g}',
            'limited_by': ', '.join(report.limited_by) or 'nothing',
            'hottest_c': number(None if report.temperature is None else report.temperature - ZERO_CELSIUS),
            'command_age_s': number(report.command_age),
            COMMANDED_BY: ', '.join(self._commanders) or NOBODY,
            'rejected_commands': str(report.rejected),
            'refused_inputs': ', '.join(f'{name} {count}' for name, count in refused.items()) or 'none',
            'command_timeouts': str(report.timeouts),
            'skipped_steps': str(report.skipped),
            **node_facts,
            **self.facts(),
        }
        node = self.node.get_fully_qualified_name()
        return DiagnosticStatus(
            level=level,
            name=f'{node}/{self.name}' if self.name else node,
            message=', '.join(dict.fromkeys(filter(None, (report.state.value, report.why, *worries)))),
            hardware_id=self.settings['joint_name'],
            values=[KeyValue(key=key, value=value) for key, value in facts.items()],
        )


def _several(commanders: Sequence[str]) -> str:
    return f'several nodes command it: {", ".join(commanders)}'
