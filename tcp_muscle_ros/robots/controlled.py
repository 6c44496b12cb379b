"""A simulated robot whose joints are controlled: angles in, and everything else as on the bench.

A joint ``j`` is turned by the muscles ``j_flexor`` (towards positive angles) and ``j_extensor``. Controllers and robot
have the timing of the two nodes: what is decided from the measurement at t_k flows from t_{k+1} on.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tcp_muscle_ros.control.antagonist import Hold, Side
from tcp_muscle_ros.control.gravity import Gravity
from tcp_muscle_ros.control.joint_controller import JointController, Measured
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.robots.models import load
from tcp_muscle_ros.robots.robot import Robot
from tcp_muscle_ros.robots.urdf import urdf

FLEXOR, EXTENSOR = 'flexor', 'extensor'


def joints_of(robot: str) -> tuple[str, ...]:
    """The joints of a robot that muscles turn, in the order of its model."""
    model = load(robot)
    tendons = {model.tendon(k).name for k in range(model.ntendon)}
    names = [model.joint(k).name for k in range(model.njnt)]
    return tuple(name for name in names if {f'{name}_{FLEXOR}', f'{name}_{EXTENSOR}'} <= tendons)


class ControlledRobot:
    """A robot that comes along, its muscles and the controllers of its joints.

    Args:
        robot: a name of ``models.ROBOTS``, or an MJCF file.
        believed: what the controllers take every muscle for.
        muscles: what they really are, by muscle or '' for all others; default as believed.
        load: N, the tension with which all are mounted, cold.
        period: s, of the controllers.
        current_limit: A.
        temperature_limit: K.
        compensate: whether the controllers know the robot's masses.

    Raises:
        BadInput: as ``Robot``, or ``muscles`` names one that the robot does not have.
    """

    def __init__(
        self,
        robot: str | Path,
        believed: Parameters,
        muscles: Mapping[str, Parameters] | None = None,
        *,
        load: float = 0.4,
        period: float = 0.01,
        current_limit: float = 0.27,
        temperature_limit: float = 100.0 + ZERO_CELSIUS,
        compensate: bool = True,
    ) -> None:
        robot = str(robot)
        real = {'': believed, **(muscles or {})}
        self.joints = joints_of(robot)
        names = [f'{joint}_{role}' for joint in self.joints for role in (FLEXOR, EXTENSOR)]
        for name in real:
            if name and name not in names:
                raise BadInput(f"muscles: the robot has no muscle '{name}'{nearest(name, names)}")
        self.robot = Robot(robot, {name: Muscle(real.get(name, real['']), end='blocked', load=load) for name in names})
        self.period = period
        self.ambient = believed['T0']
        self._gravity = Gravity(urdf(robot)) if compensate else None
        self._places = [self.robot.place(joint) for joint in self.joints]
        side = Side(believed, load, current_limit, temperature_limit)
        self.controllers = [
            JointController(side, side, self.robot.moment_arm(f'{joint}_{FLEXOR}', joint), period)
            for joint in self.joints
        ]
        self.flowing = np.zeros(len(names))

    @property
    def angles(self) -> Array:
        """rad, shape (joints,)."""
        found: Array = self.robot.data.qpos[self._places]
        return found

    def _holds(self, setpoints: Any) -> list[Hold]:
        if self._gravity is None:
            return [Hold()] * len(self.joints)
        angles, pull = dict(zip(self.joints, self.angles.tolist(), strict=True)), self.robot.model.opt.gravity
        here = self._gravity.torques(angles, pull)
        holds = []
        for joint, setpoint in zip(self.joints, setpoints, strict=True):
            # Where this joint is to be and the others are: they take seconds, and are followed as they go.
            there = self._gravity.torques(angles | {joint: float(setpoint)}, pull)
            holds.append(Hold(here[joint], there[joint]))
        return holds

    def tick(self, setpoints: Any, cocontractions: Any, stiffnesses: Any = None) -> None:
        """One period: decide the currents that flow after it, while those that were decided before it flow.

        Args:
            setpoints: rad, one a joint.
            cocontractions: N, one a joint.
            stiffnesses: N m/rad, one a joint; where they are given, co-contractions follow from them.

        Raises:
            BadInput: as ``Robot.advance``.
        """
        tensions, temperatures = self.robot.tensions.tolist(), self.robot.temperatures.tolist()
        holds, angles = self._holds(setpoints), self.angles.tolist()
        decided: list[float] = []
        for k, controller in enumerate(self.controllers):
            pair = slice(2 * k, 2 * k + 2)
            measured = Measured(
                angles[k],
                tuple(tensions[pair]),
                tuple(temperatures[pair]),
                tuple(self.flowing[pair].tolist()),
                (self.ambient, self.ambient),
            )
            decided += controller.update(
                float(setpoints[k]),
                float(cocontractions[k]),
                measured,
                stiffness=None if stiffnesses is None else float(stiffnesses[k]),
                hold=holds[k],
            )
        self.robot.advance(self.period, self.flowing)
        self.flowing = np.array(decided)
