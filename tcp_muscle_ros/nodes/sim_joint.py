"""A simulated joint between two simulated muscles, behind its topics."""

from __future__ import annotations

from std_msgs.msg import Float64

from tcp_muscle_ros.muscle import Joint, Link
from tcp_muscle_ros.nodes.home import Home
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.plan import naming
from tcp_muscle_ros.nodes.serialized import NumberPublisher
from tcp_muscle_ros.nodes.sim_muscle import SimMuscle
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, STATE_QOS
from tcp_muscle_ros.settings.operating import JOINT


def read_torque(node: Home, joint: str, message: Float64) -> float | None:
    """The torque (N m) of ``external_torque``; None and a warning where it is out of bounds."""
    row = JOINT['torque_n_m']
    if row.low <= message.data <= row.high:  # False for NaN
        return float(message.data)
    node.get_logger().warning(
        f'{joint}: external_torque of {message.data:g} refused; expected {row.low:g} to {row.high:g} N m',
        throttle_duration_sec=5.0,
    )
    return None


class SimJoint:
    """Publishes ``<name>/angle`` (rad) and hears ``<name>/external_torque`` (N m)."""

    def __init__(self, node: Home, name: str, settings: Settings, agonist: SimMuscle, antagonist: SimMuscle) -> None:
        self._node, self._settings = node, settings
        self.name = name
        self._pair = agonist, antagonist
        link = Link(
            radius=settings['radius_m'],
            inertia=settings['inertia_kg_m2'],
            damping=settings['damping_n_m_s'],
            low=settings['low_rad'],
            high=settings['high_rad'],
        )
        with naming(name):
            self.joint = Joint(link, agonist.muscle, antagonist.muscle, settings['torque_n_m'])
        self._angle = NumberPublisher(node.topics.publisher(Float64, f'{name}/angle', STATE_QOS))
        node.listen(Float64, f'{name}/external_torque', self._take_torque, COMMAND_QOS)

    def _take_torque(self, message: Float64) -> None:
        torque = read_torque(self._node, self.name, message)
        if torque is not None:
            self.joint.torque = torque

    def gather(self) -> None:
        """The muscles may have been made anew."""
        agonist, antagonist = self._pair
        self.joint.take(agonist.muscle, antagonist.muscle)

    def forget(self) -> None:
        """At rest at angle 0, without a torque that came by topic. Before the muscles are reset."""
        self.joint.reset()
        self.joint.torque = self._settings['torque_n_m']

    def publish(self) -> None:
        """Publish the angle."""
        self._angle.send(self.joint.angle)

    def joint_state(self) -> tuple[float, float, float]:
        """Position rad, velocity rad/s, effort N m of the muscles."""
        agonist, antagonist = self._pair
        effort = self._settings['radius_m'] * (agonist.joint_state()[2] - antagonist.joint_state()[2])
        return self.joint.angle, self.joint.velocity, effort
