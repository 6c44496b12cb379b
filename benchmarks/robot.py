"""How fast a robot with muscles runs, beside the same robot with plain motors.

    python benchmarks/robot.py

Steps of 2 ms, one core, without ROS; currents and torques are changed every 10 ms. The motors pull at the same joints
with torques; links, contacts and integrator are the same. Needs MuJoCo (extra ``mujoco``).
"""

from xml.etree import ElementTree

import numpy as np
from side_by_side import Contender, in_turns, show

from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.robots.controlled import ControlledRobot, joints_of
from tcp_muscle_ros.robots.models import mujoco, path_of
from tcp_muscle_ros.robots.robot import Robot

PAPER = Parameters.named('karami_tadesse_2017')
FIVE = PAPER.with_effects('natural_convection', 'radiation', 'creep', 'hysteresis', 'thermocouple_lag')
PERIOD, SECONDS, LOAD = 0.01, 5.0, 0.4  # s, s simulated a turn, N


def with_motors(robot: str) -> object:
    """The robot's MuJoCo model with a motor at each joint instead of tendons and muscles."""
    tree = ElementTree.parse(path_of(robot)).getroot()
    for part in ('tendon', 'actuator'):
        tree.remove(tree.find(part))
    default = tree.find('default')
    default.remove(default.find('tendon'))
    default.remove(default.find('general'))
    actuators = ElementTree.SubElement(tree, 'actuator')
    for joint in joints_of(robot):
        ElementTree.SubElement(actuators, 'motor', name=joint, joint=joint)
    return mujoco().MjModel.from_xml_string(ElementTree.tostring(tree, encoding='unicode'))


def contenders(robot: str) -> list[Contender]:
    """Motors, muscles, muscles with effects, and muscles with their joints' controllers."""
    mj, drawn = mujoco(), np.random.default_rng(2).uniform(0.0, 1.0, (round(SECONDS / PERIOD), 4))
    names = [f'{joint}_{role}' for joint in joints_of(robot) for role in ('flexor', 'extensor')]
    model = with_motors(robot)
    data, each = mj.MjData(model), round(PERIOD / model.opt.timestep)
    made = [Robot(robot, {name: Muscle(kind, end='blocked', load=LOAD) for name in names}) for kind in (PAPER, FIVE)]
    controlled = ControlledRobot(robot, PAPER)

    def motors() -> None:
        mj.mj_resetData(model, data)
        for row in drawn:
            data.ctrl[:] = 0.002 * (row[:2] - 0.5)
            for _ in range(each):
                mj.mj_step1(model, data)
                mj.mj_step2(model, data)

    def muscles(it: Robot) -> None:
        it.reset()
        for row in drawn:
            it.advance(PERIOD, 0.2 * row)

    def loop() -> None:
        controlled.robot.reset()
        for row in drawn:
            controlled.tick(0.3 * row[:2], (0.6, 0.6))

    return [
        Contender('plain motors', motors),
        Contender('muscles', lambda: muscles(made[0])),
        Contender('muscles with five effects', lambda: muscles(made[1])),
        Contender('muscles and the controllers of both joints', loop, repeats=3),
    ]


def main() -> None:
    """One table: times real time, and how many times the motors' time."""
    rows = []
    for robot in ('arm', 'finger'):
        measured = in_turns(contenders(robot))
        plain = measured[0].seconds
        rows += [
            (
                robot,
                row.name,
                f'{SECONDS / row.seconds:.0f}',
                f'{1e6 * row.seconds / (SECONDS / 0.002):.1f}',
                f'{row.seconds / plain:.1f}',
            )
            for row in measured
        ]
    show(
        'A robot of two joints and four muscles, steps of 2 ms on one core',
        ('robot', 'turned by', 'times real time', 'us a step', "times the motors' time"),
        rows,
    )


if __name__ == '__main__':
    main()
