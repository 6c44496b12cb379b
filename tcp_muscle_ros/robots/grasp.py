"""A finger presses a ball against its palm, and holds it while gravity turns by a right angle.

First the finger is lifted, then it closes; the setpoints of its angles lie beyond the ball, so that it presses. Then
gravity turns from "into the palm" to "along the palm, out of the grasp", as if the hand were turned.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any

import numpy as np

from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.robots.controlled import ControlledRobot
from tcp_muscle_ros.robots.coupling import Book

LIFTED, CLOSED, HELD, END = 6.0, 13.0, 18.0, 20.0  # s: until when each part lasts; gravity turns from CLOSED to HELD
OPEN_POSE, GRASP_POSE = (-0.15, 0.0), (0.3, 0.5)  # rad: knuckle, middle
COCONTRACTION = 0.6  # N
WARMEST = 75.0 + ZERO_CELSIUS  # K: as hard as it presses; it would go to its temperature limit else
_GRAVITY = 9.81  # m/s^2
_COLUMNS = ('time', 'setpoints', 'angles', 'tensions', 'temperatures', 'ball', 'pressed', 'turned')


@dataclass(frozen=True)
class Grasp:
    """What happened, once a period: SI, temperatures in K; shape (n,) or (n, joints or muscles or 3)."""

    time: Array
    setpoints: Array
    angles: Array
    tensions: Array
    temperatures: Array
    ball: Array  # its centre
    pressed: Array  # N, on the palm
    turned: Array  # rad, of gravity
    joints: tuple[str, ...]
    muscles: tuple[str, ...]
    book: Book

    @property
    def slip(self) -> float:
        """m: how far the ball got from where it was when gravity began to turn."""
        since = self.time >= CLOSED
        return float(np.linalg.norm(self.ball[since] - self.ball[since][0], axis=1).max())


def grasp(
    watch: Callable[[ControlledRobot, float], None] = lambda finger, turned: None,
    before: Callable[[ControlledRobot, float], None] = lambda finger, time: None,
    until: float = END,
) -> Grasp:
    """Let it happen.

    Args:
        watch: called after every period with the finger and the angle (rad) by which gravity has turned.
        before: called before every period with the finger and the time (s), to break something.
        until: s, when it ends.
    """
    finger = ControlledRobot('finger', Parameters.named('karami_tadesse_2017'), temperature_limit=WARMEST)
    robot = finger.robot
    place = robot.place('ball')
    palm = robot.model.geom('palm').id
    rows = []
    for k in range(round(until / finger.period)):
        time = k * finger.period
        turned = 0.5 * pi * float(np.clip((time - CLOSED) / (HELD - CLOSED), 0.0, 1.0))
        robot.model.opt.gravity[:] = _GRAVITY * sin(turned), 0.0, -_GRAVITY * cos(turned)
        setpoints = OPEN_POSE if time < LIFTED else GRASP_POSE
        before(finger, time)
        finger.tick(setpoints, (COCONTRACTION, COCONTRACTION))
        rows.append(
            (
                time + finger.period,
                setpoints,
                finger.angles,
                robot.tensions.copy(),
                robot.temperatures.copy(),
                robot.data.qpos[place : place + 3].copy(),
                robot.pressure(palm),
                turned,
            )
        )
        watch(finger, turned)
    columns: dict[str, Any] = {
        name: np.array(column) for name, column in zip(_COLUMNS, zip(*rows, strict=True), strict=True)
    }
    return Grasp(joints=finger.joints, muscles=robot.names, book=robot.book(), **columns)
