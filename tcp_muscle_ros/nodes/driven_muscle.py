"""One real muscle behind a board on a serial line: the driver of docs/hardware.md, with the same safety as the rest."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from rclpy.publisher import Publisher
from rclpy.time import Time
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.control.safety import Limits
from tcp_muscle_ros.control.watches import THERMOMETER
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS
from tcp_muscle_ros.nodes.board import Board, Port
from tcp_muscle_ros.nodes.home import Home
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.safe_muscle import SafeMuscle, number
from tcp_muscle_ros.nodes.serial_line import Sample
from tcp_muscle_ros.nodes.topics import STATE_QOS


def open_port(settings: Settings) -> Port:
    """The serial port that the parameters name. Raises OSError where it is not there or somebody else's."""
    import serial

    port: Port = serial.Serial(
        settings['port'], settings['baud_rate'], timeout=0, write_timeout=settings['reply_timeout_s'], exclusive=True
    )
    return port


class DrivenMuscle(SafeMuscle):
    """``current_command`` in, through the safety machine to the board; what the board measures out."""

    def __init__(self, node: Home, name: str, settings: Settings) -> None:
        super().__init__(node, name, settings)
        self.board = Board(lambda: open_port(self.settings), settings['reply_timeout_s'])
        self._current, self._voltage, self._resistance, self._displacement = (
            self.publisher(channel) for channel in ('current', 'voltage', 'resistance', 'displacement')
        )
        self._temperature = node.topics.publisher(Temperature, self.topic('temperature'), STATE_QOS)
        self._joint = node.topics.publisher(JointState, self.topic('joint_states'), STATE_QOS)
        self._before: tuple[float, float] | None = None  # uptime s, displacement m: the velocity's
        self.listen(Float64, 'current_command', self._take_command)

    def begin(self) -> None:
        """Open the port. BadInput where that fails: at the start it is a wrong name, later a cable."""
        try:
            self.board.begin()
        except OSError as problem:
            why = os.strerror(problem.errno) if problem.errno else ' '.join(str(problem).split())
            named = f"parameter 'port' is '{self.settings['port']}', which cannot be opened"
            raise BadInput(f'{self.said}{named}: {why}') from None

    def limits_of(self, settings: Settings) -> Limits:
        """The safety limits, with the watchdog."""
        return settings.limits(command_timeout=settings['command_timeout_s'])

    def apply(self, settings: Settings) -> None:
        """Take over values that were set while running."""
        self.board.timeout = settings['reply_timeout_s']

    def forget(self) -> str:
        """~/reset: no command."""
        self.safety.command(0.0, self.node.seconds())
        return 'reset: waiting for a command'

    def _take_command(self, message: Float64) -> None:
        with self.node.lock:
            self.safety.command(message.data, self.node.seconds())

    def work(self, stamp: int, dt: float, now: float) -> None:
        """Hear the board, decide the current, tell it, and publish what it measured."""
        heard = self.board.hear(now)
        if self.board.fault:
            self.safety.trip(self.board.fault)
            self.board.fault = ''
        temperature = self.board.temperature.fresh(now, max(self.board.timeout, THERMOMETER))
        resistance = self._resistance_of(self.board.latest)
        current = self.safety.update(
            now, dt, resistance=resistance, temperatures=(temperature,), silent=self.board.problem
        )
        self.board.tell(current, now)
        if heard is not None:
            self._publish(heard, stamp)

    def _resistance_of(self, heard: Sample | None) -> float | None:
        if heard is None or heard.current <= max(self.settings['min_sense_current_a'], 0.0) or heard.voltage <= 0.0:
            return None
        return heard.voltage / heard.current

    def _publish(self, heard: Sample, stamp: int) -> None:
        self._current.send(heard.current)
        self._voltage.send(heard.voltage)
        resistance = self._resistance_of(heard)
        if resistance is not None:
            self._resistance.send(resistance)
        header_stamp = Time(nanoseconds=max(stamp, 0)).to_msg()
        if heard.temperature is not None:
            message = Temperature(temperature=heard.temperature - ZERO_CELSIUS)
            message.header.stamp, message.header.frame_id = header_stamp, self.frame
            self._temperature.publish(message)
        if heard.displacement is not None:
            self._displacement.send(heard.displacement)
            joint = JointState(name=[self.settings['joint_name']], position=[heard.displacement])
            joint.velocity = [self._velocity(heard.uptime, heard.displacement)]
            joint.header.stamp, joint.header.frame_id = header_stamp, self.frame
            self._joint.publish(joint)

    def _velocity(self, uptime: float, displacement: float) -> float:
        before, self._before = self._before, (uptime, displacement)
        if before is None or uptime <= before[0]:
            return 0.0
        return (displacement - before[1]) / (uptime - before[0])

    def publish_zero(self) -> Sequence[Publisher]:
        """0 A to the board, and say so."""
        self.board.tell(0.0, self.node.seconds())
        self._current.send(0.0)
        return [self._current.publisher]

    def facts(self) -> Mapping[str, str]:
        """How the line is."""
        latest = self.board.latest
        return {
            'board': self.board.problem or 'answers',
            'board_uptime_s': number(None if latest is None else latest.uptime),
            'broken_lines': str(self.board.garbage),
        }
