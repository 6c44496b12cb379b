"""A muscle, its controller and a recorder as processes, and setpoints for them: what the demo and its tests run."""

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.topics import COMMAND_QOS, STATE_QOS

Value = float | int | bool | str
_PATIENCE = 180.0  # s; the first start of a new version compiles the model
_FAREWELL = 10.0  # s, in which a process ends when asked to


class Session:
    """``with Session(bag, sim={...}, controller={...}) as session: session.follow(profile, 20.0)``.

    Args:
        bag: where to record to; a folder that does not exist yet.
        sim: parameters of sim_node.
        controller: parameters of controller_node.
        rate_hz: of the setpoints.

    Raises:
        RuntimeError: a process that ends early, or that nobody hears from.
    """

    def __init__(
        self, bag: Path, *, sim: Mapping[str, Value], controller: Mapping[str, Value], rate_hz: float = 100.0
    ) -> None:
        self._commands = {
            'sim_node': _node('sim_node', sim),
            'controller_node': _node('controller_node', controller),
            'recorder': [sys.executable, '-m', 'tcp_muscle_ros.tool', 'record', '--output', str(bag)],
        }
        self._period = 1.0 / rate_hz
        self.processes: dict[str, subprocess.Popen[str]] = {}
        self.diagnostics: dict[str, dict[str, str]] = {}  # the latest, by node
        self.displacement: float | None = None  # m, the latest
        self.said: dict[str, list[str]] = {}  # the lines of each process
        self._listeners: list[threading.Thread] = []

    def __enter__(self) -> 'Session':
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node('session', enable_rosout=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._setpoint = self.node.create_publisher(Float64, 'displacement_setpoint', COMMAND_QOS)
        self._load = self.node.create_publisher(Float64, 'load', COMMAND_QOS)
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, STATE_QOS)
        self.node.create_subscription(Float64, 'displacement', self._take_displacement, STATE_QOS)
        try:
            for name, command in self._commands.items():
                self._start(name, command)
            self._wait('the controller and the recorder', lambda: self._setpoint.get_subscription_count() >= 2)
            self._wait('the muscle', self._is_recorded)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def follow(
        self, profile: Callable[[float], float], duration: float, say: Callable[[float], None] = lambda _: None
    ) -> None:
        """Publish ``profile(t)`` (m, t in s from 0 to ``duration``) at the rate; ``say(t)`` once a second."""
        begun, ticks, said = time.monotonic(), 0, -1
        while (elapsed := ticks * self._period) < duration:
            self._setpoint.publish(Float64(data=float(profile(elapsed))))
            if int(elapsed) > said:
                said = int(elapsed)
                say(elapsed)
                self._all_alive()
            ticks += 1
            self._spin_until(begun + ticks * self._period)

    def load(self, newton: float) -> None:
        """Publish a pulling force, N."""
        self._load.publish(Float64(data=float(newton)))

    def _start(self, name: str, command: list[str]) -> None:
        process = subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        lines: list[str] = []
        # Somebody must read on, or a process that has much to say would wait for us.
        listener = threading.Thread(target=_listen, args=(process, lines), daemon=True)
        listener.start()
        self.processes[name], self.said[name] = process, lines
        self._listeners.append(listener)

    def _is_recorded(self) -> bool:
        recording = {line.split()[-1] for line in self.said['recorder'] if line.startswith('recording ')}
        return {'/displacement', '/current', '/temperature', '/current_command'} <= recording

    def _spin_until(self, due: float) -> None:
        while (left := due - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def _wait(self, what: str, done: Callable[[], bool]) -> None:
        begun = time.monotonic()
        while not done():
            self._all_alive()
            if time.monotonic() - begun > _PATIENCE:
                raise RuntimeError(f'nothing heard from {what} in {_PATIENCE:.0f} s')
            self._executor.spin_once(timeout_sec=0.05)

    def _all_alive(self) -> None:
        for name, process in self.processes.items():
            if process.poll() is not None:
                said = ''.join(self.said[name][-3:]).strip()
                raise RuntimeError(f'{name} ended with exit code {process.returncode}: {said}')

    def _end(self) -> None:
        """First who writes it down: the end is no part of the session. Then who commands, then who obeys."""
        for name in ('recorder', 'controller_node', 'sim_node'):
            process = self.processes.get(name)
            if process is None:
                continue
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            try:
                process.wait(_FAREWELL)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        for listener in self._listeners:
            listener.join(1.0)
        self._executor.shutdown(timeout_sec=1.0)
        self.node.destroy_node()
        rclpy.try_shutdown()

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.diagnostics[status.name.strip('/')] = {value.key: value.value for value in status.values}

    def _take_displacement(self, message: Float64) -> None:
        self.displacement = message.data


def _listen(process: 'subprocess.Popen[str]', lines: list[str]) -> None:
    assert process.stdout is not None
    with process.stdout as output:
        for line in output:
            lines.append(line)  # noqa: PERF402 - as they come, not when the process ends


def _node(name: str, parameters: Mapping[str, Value]) -> list[str]:
    given = [argument for key, value in parameters.items() for argument in ('-p', f'{key}:={_yaml(value)}')]
    return [sys.executable, '-m', f'tcp_muscle_ros.nodes.{name}', '--ros-args', *given]


def _yaml(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(float(value)) if isinstance(value, float) else str(value)
