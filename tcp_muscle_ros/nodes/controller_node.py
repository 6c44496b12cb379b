"""Displacements or angles in, currents out: a position controller for one muscle or for several, simulated or real."""

if __name__ == '__main__':  # python -m: before the rest is loaded, as entry.py does
    from tcp_muscle_ros.process.quiet_end import end_quietly_when_asked

    end_quietly_when_asked()

from collections.abc import Callable, Sequence
from itertools import zip_longest
from math import isnan

from diagnostic_msgs.msg import DiagnosticStatus
from sensor_msgs.msg import JointState

from tcp_muscle_ros.errors import nearest
from tcp_muscle_ros.nodes.controlled_joint import ControlledJoint, Weight
from tcp_muscle_ros.nodes.controlled_muscle import ControlledMuscle
from tcp_muscle_ros.nodes.controllers import check_model, make_handover
from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.lockstep import out_of_step
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.plan import pair
from tcp_muscle_ros.nodes.safe_node import SafeNode
from tcp_muscle_ros.nodes.topics import COMMAND_QOS
from tcp_muscle_ros.settings.operating import CONTROL


class ControllerNode(SafeNode[ControlledMuscle]):
    """Each muscle by its own setpoint, limits and faults; ``joint_commands`` may name any of them in one message.

    Two muscles on a joint have one setpoint, the joint's, and are limited and stopped by themselves all the same.
    """

    def __init__(self) -> None:
        self.out_of_step: dict[str, str] = {}  # by topic, why nothing may be built on it
        super().__init__(CONTROL)
        self._joints = {
            name: ControlledJoint(self, name, settings, *(self.by_name[one] for one in pair(settings)))
            for name, settings in self.plan.joints.items()
        }
        self._weight = Weight(self.common['description_file'], self._joints.values())
        self._setpoints: dict[str, Callable[[float, str], None]] = {
            muscle.settings['joint_name']: muscle.go_to for muscle in self.muscles if not muscle.on_joint
        }
        self._told: set[str] = set()  # joints whose commands cannot be followed
        self._setpoints |= {name: joint.go_to for name, joint in self._joints.items()}
        self.listen(JointState, 'joint_commands', self._take_joint_commands, COMMAND_QOS)

    def check(self, settings: Settings) -> None:
        """Raise BadInput against values that make no muscle, no controller or no limits."""
        settings.limits(command_timeout=0.0)
        if kept := check_model(settings):
            self.get_logger().warning(kept)
        make_handover(settings)

    def make_muscle(self, name: str, settings: Settings) -> ControlledMuscle:
        """A muscle with its controller."""
        return ControlledMuscle(
            self, name, settings, on_joint=any(name in pair(joint) for joint in self.plan.joints.values())
        )

    def apply_joint(self, name: str, settings: Settings) -> None:
        """Take over values of a joint that were set while running."""
        self._joints[name].apply(settings)

    def renew(self, muscle: ControlledMuscle) -> None:
        """A muscle has other values: so has the joint that it turns."""
        for joint in self._joints.values():
            if joint.turns(muscle):
                joint.renew()

    def forget(self) -> str:
        """~/reset: no setpoints, nothing learnt."""
        for joint in self._joints.values():
            joint.forget()
        return super().forget()

    def _take_joint_commands(self, message: JointState) -> None:
        names, positions = len(message.name), len(message.position)
        if names != positions:
            self.muscles[0].refused_inputs['joint_commands'] += 1
            self.get_logger().warning(
                f'joint_commands with {names} names and {positions} positions; expected a position for each name',
                throttle_duration_sec=10.0,
            )
        for name, position in zip_longest(message.name, message.position[: len(message.name)]):
            go_to = self._setpoints.get(name)
            if go_to is None:
                self._warn_of(name, f'no joint of this node{nearest(name, self._setpoints)}')
            elif position is None:
                self._warn_of(name, 'without a position')
            elif not isnan(position):  # ros2_control sends NaN as long as no controller claims the joint
                go_to(position, f"joint_commands '{name}'")

    def _warn_of(self, name: str, why: str) -> None:
        """Once of each joint: it may be another node's, or a wrong joint_name."""
        if name not in self._told:
            self._told.add(name)
            self.get_logger().warning(f"joint_commands names '{name}', {why}")

    def more_statuses(self) -> list[DiagnosticStatus]:
        """The joints'."""
        return [joint.status() for joint in self._joints.values()]

    def look_for_unmatched(self) -> None:
        """Also for a simulation that this node cannot follow."""
        super().look_for_unmatched()
        found = out_of_step(self, self.time_base, {muscle.feedback_topic for muscle in self.muscles})
        for sentence in set(found.values()) - set(self.out_of_step.values()):
            self.get_logger().error(f'0 A: {sentence}')
        self.out_of_step = found

    def work(self, stamp: int, dt: float, now: float, publish: bool) -> None:
        """Each muscle's current."""
        for joint, hold in zip(self._joints.values(), self._weight.holds(), strict=True):
            joint.work(now, hold)
        for muscle in self.muscles:
            muscle.work(dt, now, publish)


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run(ControllerNode, CONTROL, args)


if __name__ == '__main__':
    raise SystemExit(main())
