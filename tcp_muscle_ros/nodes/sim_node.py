"""Muscles that are not there: currents, powers or voltages in, and out what real ones with their sensors would show."""

from __future__ import annotations

if __name__ == '__main__':  # python -m: before the rest is loaded, as entry.py does
    from tcp_muscle_ros.process.quiet_end import end_quietly_when_asked

    end_quietly_when_asked()

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Muscles
from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.lockstep import LeadingTime
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.nodes.plan import pair
from tcp_muscle_ros.nodes.safe_node import SafeNode
from tcp_muscle_ros.nodes.serialized import SerializedPublisher
from tcp_muscle_ros.nodes.sim_joint import SimJoint
from tcp_muscle_ros.nodes.sim_muscle import SimMuscle, joint_states, make_muscle
from tcp_muscle_ros.nodes.ticks import SECOND, TimeBase
from tcp_muscle_ros.nodes.topics import STATE_QOS
from tcp_muscle_ros.settings.operating import SIM

if TYPE_CHECKING:  # MuJoCo is loaded where a robot is asked for
    from tcp_muscle_ros.nodes.sim_robot import Eye, RobotJoint, SimRobot


class SimNode(SafeNode[SimMuscle]):
    """Steps its muscles at a fixed rate and publishes what contracts.md calls one muscle's topics, for each.

    At tick k the state is advanced to t_k under the current decided at tick k - 1; then the current of tick k is
    decided. State and current of one tick are published together: an input stamped t_k holds from t_k to t_{k+1}.
    """

    def __init__(self) -> None:
        self._stamps: list[memoryview[int]] = []  # the tick's, in every stamped message
        super().__init__(SIM)
        self._robot: SimRobot | None = self._make_robot()
        self._eye: Eye | None = None
        self._joints: list[SimJoint | RobotJoint] = [
            self._make_joint(name, settings) for name, settings in self.plan.joints.items()
        ]
        if self._robot is not None and self.common['image_rate_hz'] > 0.0:
            from tcp_muscle_ros.nodes import sim_robot

            self._eye = sim_robot.Eye(self, self._robot, self.common)
        self._currents = [0.0] * len(self.muscles)
        self.gather()
        self._all_joints = None
        if self.plan.many:
            names = [muscle.settings['joint_name'] for muscle in self.muscles] + [joint.name for joint in self._joints]
            joints = joint_states(names)
            joints.header.frame_id = '' if self._robot is None else self._robot.frame
            self._all_joints, (self._position, self._velocity, self._effort) = self.stamped(
                'joint_states', joints, 'position', 'velocity', 'effort'
            )

    def _make_robot(self) -> SimRobot | None:
        if not self.common['robot']:
            return None
        from tcp_muscle_ros.nodes.sim_robot import SimRobot

        if not self.plan.many:
            raise BadInput("parameter 'robot' needs 'muscles': the names of the robot's tendons")
        for name, muscle in self.by_name.items():
            if muscle.settings['end'] != 'blocked':
                raise BadInput(
                    f"{name}: parameter 'end' is '{muscle.settings['end']}', but the robot holds it: blocked"
                )
        return SimRobot(self.common['robot'], self.by_name)

    def _make_joint(self, name: str, settings: Settings) -> SimJoint | RobotJoint:
        if self._robot is not None:
            from tcp_muscle_ros.nodes.sim_robot import RobotJoint

            return RobotJoint(self, name, settings, self.by_name, self._robot)
        return SimJoint(self, name, settings, *(self.by_name[one] for one in pair(settings)))

    def check(self, settings: Settings) -> None:
        """Raise BadInput against values that make no muscle, no limits or no clock."""
        settings.limits(command_timeout=settings['command_timeout_s'])
        make_muscle(settings)
        if settings['real_time_factor'] != 1.0 and self.get_parameter('use_sim_time').value:
            raise BadInput(
                f'real_time_factor is {settings["real_time_factor"]:g} and use_sim_time is true: this node cannot '
                f'publish /clock and follow it; expected one of them'
            )

    def make_muscle(self, name: str, settings: Settings) -> SimMuscle:
        """A simulated muscle."""
        return SimMuscle(self, name, settings)

    def make_time_base(self) -> TimeBase:
        """The clock that the ticks keep to: its own unless it runs in real time."""
        of_all = self.common
        if of_all['real_time_factor'] != 1.0:
            return LeadingTime(self, of_all['real_time_factor'], of_all['lockstep_nodes'], of_all['lockstep_timeout_s'])
        return super().make_time_base()

    def stamped(self, topic: str, message: Any, *fields: str) -> tuple[SerializedPublisher, list[memoryview[float]]]:
        """A topic whose message has the stamp of the tick, and where its fields are."""
        serialized = SerializedPublisher(self.topics.publisher(type(message), topic, STATE_QOS), message)
        self._stamps.append(serialized.stamp())
        return serialized, [serialized.numbers(field) for field in fields]

    def gather(self) -> None:
        """Step the muscles together as they now are."""
        muscles = [muscle.muscle for muscle in self.muscles]
        if self._robot is not None:
            self._robot.take(muscles)
            self._together: Muscles | SimRobot = self._robot
        else:
            joints = [joint for joint in self._joints if isinstance(joint, SimJoint)]
            for joint in joints:
                joint.gather()
            self._together = Muscles(muscles, [joint.joint for joint in joints])
        self._together.step(0.0, self._currents)  # what is still to be compiled is compiled before the first tick

    def forget(self) -> str:
        """~/reset: every muscle is at rest again, every joint at angle 0."""
        if self._robot is not None:
            self._robot.reset()
        for joint in self._joints:
            joint.forget()
        return super().forget()

    def work(self, stamp: int, dt: float, now: float, publish: bool) -> None:
        """Advance the muscles to this tick, decide their currents, publish both."""
        currents = self._currents
        for k, muscle in enumerate(self.muscles):
            currents[k] = muscle.current
        if not 0.0 < dt <= self.common.longest_step:
            dt = 0.0  # no step of time: the muscles stay as they are, the safety machines count it
        for muscle, reading in zip(self.muscles, self._together.step(dt, currents), strict=True):
            muscle.decide(reading, dt, now)
        if publish:
            self._publish(stamp)

    def _publish(self, stamp: int) -> None:
        sec, nanosec = divmod(stamp, SECOND)
        for place in self._stamps:
            place[0], place[1] = sec, nanosec
        for muscle in self.muscles:
            muscle.publish()
        for joint in self._joints:
            joint.publish()
        if self._all_joints is not None:
            position, velocity, effort = self._position, self._velocity, self._effort
            for k, muscle in enumerate(self.muscles):
                position[k], velocity[k], effort[k] = muscle.joint_state()
            for k, joint in enumerate(self._joints, len(self.muscles)):
                position[k], velocity[k], effort[k] = joint.joint_state()
            self._all_joints.publish()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run(SimNode, SIM, args)


if __name__ == '__main__':
    raise SystemExit(main())
