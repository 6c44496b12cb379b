"""A simulated muscle on a clock of ours. Imported by whole_loop.py.

Whoever commands it publishes the next tick's /clock when sim_node has spoken of the last: so two runs are commanded at
the same ticks, and as fast as the machine can.
"""

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tcp_muscle_ros.recording.units import GRAVITY

PATIENCE = 120.0  # s, for a node to speak; the first start compiles the model
HEARD = 0.02  # s of the wall: a command has reached sim_node


@dataclass(frozen=True)
class Step:
    """Seconds at a current (A) under a weight (kg)."""

    seconds: float
    current: float
    mass: float


class Bench:
    """sim_node with a parameter file, on a clock of ours; ``perform`` does an experiment and records it.

    ``rate`` Hz: of the ticks, as in the file; ``load`` N: at the start, as in the file.
    """

    def __init__(self, parameters: Path, rate: float, load: float) -> None:
        import rclpy
        from rclpy.node import Node
        from rclpy.qos import QoSProfile
        from rclpy.signals import SignalHandlerOptions
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import Temperature
        from std_msgs.msg import Float64

        self._rate, self._load_at_start = rate, load
        self._number, self._time, self._rclpy = Float64, Clock, rclpy
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node('commander', enable_rosout=False)
        self._current = self._node.create_publisher(Float64, 'current_command', QoSProfile(depth=1))
        self._load = self._node.create_publisher(Float64, 'load', QoSProfile(depth=1))
        self._clock = self._node.create_publisher(Clock, '/clock', QoSProfile(depth=1))
        self._node.create_subscription(Temperature, 'temperature', self._heard, QoSProfile(depth=100))
        self._ticks = self._spoken = 0  # of /clock, and the last of which sim_node has spoken
        ros = ['--ros-args', '--params-file', str(parameters), '-p', 'use_sim_time:=true']
        self._sim = Process(['-m', 'tcp_muscle_ros.nodes.sim_node', *ros])
        self._wait('sim_node', lambda: self._clock.get_subscription_count() > 0)
        self._wait('its first tick', self._first)

    def perform(self, steps: Sequence[Step], bag: Path) -> None:
        """Put the muscle back to rest, do the steps, and record them to a bag."""
        self._unload()
        self._reset()
        recorder = Process(['-m', 'tcp_muscle_ros.tool', 'record', '--output', str(bag)])
        try:
            self._wait('the recorder', lambda: self._idled() and self._met(recorder), recorder)
            self._wait('who listens', lambda: self._listeners() >= 2, recorder)
            for step in steps:
                self._load.publish(self._number(data=step.mass * GRAVITY))
                self._command(step.current)
                time.sleep(HEARD)
                for _ in range(round(step.seconds * self._rate)):
                    self._tick()
                    self._command(step.current)
        finally:
            recorder.end()

    def close(self) -> None:
        """End the node."""
        self._sim.end()
        self._node.destroy_node()
        self._rclpy.try_shutdown()

    def _heard(self, message: object) -> None:
        stamp = message.header.stamp  # type: ignore[attr-defined]
        self._spoken = round((stamp.sec + 1e-9 * stamp.nanosec) * self._rate)

    def _met(self, recorder: 'Process') -> bool:
        """Whether the recorder has met the muscle."""
        return any('/temperature' in line for line in recorder.said)

    def _idled(self) -> bool:
        """Let time pass, for nobody speaks while it stands still; True."""
        if self._spoken >= self._ticks:
            time.sleep(HEARD)  # who is still being met must not miss any
            self._say(self._ticks + 1)
        return True

    def _first(self) -> bool:
        """Whether sim_node speaks: the first times may have been missed."""
        self._say(self._ticks + 1)
        return self._spoken > 0

    def _tick(self) -> None:
        """The next tick, until sim_node has spoken of it."""
        self._say(self._ticks + 1)
        self._wait('a tick', lambda: self._spoken >= self._ticks)

    def _say(self, tick: int) -> None:
        self._ticks = tick
        message = self._time()
        message.clock.sec, tenths = divmod(tick, round(self._rate))
        message.clock.nanosec = round(tenths / self._rate * 1e9)
        self._clock.publish(message)

    def _command(self, current: float) -> None:
        self._current.publish(self._number(data=current))

    def _listeners(self) -> int:
        """Who hears both commands: the node, and the recorder."""
        return int(min(self._current.get_subscription_count(), self._load.get_subscription_count()))

    def _unload(self) -> None:
        """Back to the load at the start: rest is rest under the present one, which may be that of an attempt before."""
        self._wait('who hears the load', lambda: self._load.get_subscription_count() > 0)
        self._load.publish(self._number(data=self._load_at_start))
        time.sleep(HEARD)
        self._tick()

    def _reset(self) -> None:
        from std_srvs.srv import Trigger

        client = self._node.create_client(Trigger, 'sim_node/reset')
        self._wait('the reset service', client.service_is_ready)
        asked = client.call_async(Trigger.Request())
        self._wait('the reset', asked.done)
        self._node.destroy_client(client)

    def _wait(self, what: str, done: Callable[[], bool], *others: 'Process') -> None:
        begun = time.monotonic()
        while not done():
            self._rclpy.spin_once(self._node, timeout_sec=0.05)
            for process in (self._sim, *others):
                if not process.alive:
                    raise RuntimeError(f'a process ended: {"".join(process.said[-3:]).strip()}')
            if time.monotonic() - begun > PATIENCE:
                raise RuntimeError(f'waited {PATIENCE:.0f} s for {what}')


class Process:
    """A Python process whose lines are kept in ``said``."""

    def __init__(self, command: Sequence[str]) -> None:
        self.said: list[str] = []
        self._process = subprocess.Popen(
            [sys.executable, *command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
        threading.Thread(target=lambda: self.said.extend(self._process.stdout or ()), daemon=True).start()

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None

    def end(self) -> None:
        """Interrupt it, and wait."""
        if self.alive:
            self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(15.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
