"""A robot in MuJoCo whose muscles and joints are a node's: bodies and contacts move, pictures are taken."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.time import Time
from sensor_msgs.msg import Image
from std_msgs.msg import Float64

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Muscle, Reading
from tcp_muscle_ros.nodes.home import Home
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.plan import pair
from tcp_muscle_ros.nodes.serialized import NumberPublisher
from tcp_muscle_ros.nodes.sim_joint import read_torque
from tcp_muscle_ros.nodes.sim_muscle import SimMuscle
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, STATE_QOS
from tcp_muscle_ros.robots.models import OPTICAL, root
from tcp_muscle_ros.robots.pictures import Camera, camera
from tcp_muscle_ros.robots.robot import Robot

_SAME_RADIUS = 0.01  # share by which a joint's radius_m may differ from the robot's pulley


class SimRobot:
    """Steps the muscles of a node in a robot.

    Raises:
        BadInput: the robot does not have the muscles, or MuJoCo is missing.
    """

    def __init__(self, robot: str, muscles: Mapping[str, SimMuscle]) -> None:
        self._muscles = list(muscles.values())
        self.robot = Robot(robot, {name: muscle.muscle for name, muscle in muscles.items()})
        self._step = float(self.robot.model.opt.timestep)
        self._owed = 0.0  # s, by which the simulator is behind the ticks
        self.frame = str(self.robot.model.body(root(self.robot.model)).name)  # the link that all others hang on

    def take(self, muscles: Sequence[Muscle]) -> None:
        """The same muscles with other properties."""
        self.robot.take(list(muscles))

    def reset(self) -> None:
        """At rest in the pose of the model, muscles cold."""
        self.robot.reset()
        self._owed = 0.0

    def step(self, dt: float, currents: Sequence[float]) -> list[Reading]:
        """Hold the currents (A) for ``dt`` (s), then read all; a ``dt`` of 0 only reads.

        Raises:
            BadInput: the motion has lost all bounds.
        """
        self._owed += dt
        steps = int(self._owed / self._step + 1e-6)
        if steps > 0:
            self._owed -= steps * self._step
            self.robot.step(currents, steps)
        rows = self.robot.tendons.shown.tolist()
        moved = steps * self._step  # s; the simulator's steps, of which a tick may see none, are not the ticks
        return [muscle.muscle.shown(row, moved) for muscle, row in zip(self._muscles, rows, strict=True)]


class RobotJoint:
    """A joint of the robot: publishes ``<name>/angle`` (rad) and hears ``<name>/external_torque`` (N m).

    Raises:
        BadInput: the robot has no such joint, or another pulley on it than the parameters say.
    """

    def __init__(
        self, node: Home, name: str, settings: Settings, muscles: Mapping[str, SimMuscle], it: SimRobot
    ) -> None:
        self.name = name
        self._node, self._settings, self._robot = node, settings, it.robot
        agonist, antagonist = pair(settings)
        self._pair = muscles[agonist], muscles[antagonist]
        self._place, self._speed = it.robot.place(name), it.robot.speed_place(name)
        for muscle, sign in ((agonist, 1.0), (antagonist, -1.0)):
            arm = sign * it.robot.moment_arm(muscle, name)
            if abs(arm - settings['radius_m']) > _SAME_RADIUS * settings['radius_m']:
                raise BadInput(
                    f"{name}: parameter 'radius_m' is {settings['radius_m']:g}, but '{muscle}' pulls at the robot's "
                    f'joint with {arm:.4g} m'
                )
        self._angle = NumberPublisher(node.topics.publisher(Float64, f'{name}/angle', STATE_QOS))
        node.listen(Float64, f'{name}/external_torque', self._take_torque, COMMAND_QOS)
        self.forget()

    def _take_torque(self, message: Float64) -> None:
        torque = read_torque(self._node, self.name, message)
        if torque is not None:
            self._robot.data.qfrc_applied[self._speed] = torque

    def forget(self) -> None:
        """Without a torque that came by topic."""
        self._robot.data.qfrc_applied[self._speed] = self._settings['torque_n_m']

    def publish(self) -> None:
        """Publish the angle."""
        self._angle.send(float(self._robot.data.qpos[self._place]))

    def joint_state(self) -> tuple[float, float, float]:
        """Position rad, velocity rad/s, effort N m of the muscles."""
        agonist, antagonist = self._pair
        effort = self._settings['radius_m'] * (agonist.joint_state()[2] - antagonist.joint_state()[2])
        return float(self._robot.data.qpos[self._place]), float(self._robot.data.qvel[self._speed]), effort


class Eye:
    """Publishes ``camera/image`` at a rate of its own, on the steady clock; made and used by the executor's thread."""

    def __init__(self, node: Any, robot: SimRobot, settings: Settings) -> None:
        self._node, self._robot = node, robot
        self._size = settings['image_width'], settings['image_height']
        self._camera: Camera | None = None
        self._publisher = node.topics.publisher(Image, 'camera/image', STATE_QOS)
        node.create_timer(1.0 / settings['image_rate_hz'], self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _look(self) -> None:
        if self._publisher.get_subscription_count() == 0:
            return
        with self._node.lock:
            still, stamp = self._robot.robot.still(), Time(nanoseconds=max(self._node.time_base.now(), 0)).to_msg()
        if self._camera is None:
            self._camera = camera(still, *self._size)
            self._node.get_logger().info(f'pictures by {self._camera.backend}')
        seen = self._camera.picture(still)
        height, width, _ = seen.shape
        message = Image(height=height, width=width, encoding='rgb8', step=3 * width)
        message.header.stamp, message.header.frame_id = stamp, OPTICAL
        message.data = array('B', seen.tobytes())
        self._publisher.publish(message)

    def close(self) -> None:
        """Give back what the graphics hold."""
        if self._camera is not None:
            self._camera.close()
