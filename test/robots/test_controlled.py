"""The joints of a simulated robot in closed loop."""

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.robots.controlled import ControlledRobot
from tcp_muscle_ros.robots.models import path_of

pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")
PAPER = Parameters.named('karami_tadesse_2017')


def lifted(compensate, muscles=None):
    """The arm's angles (rad) while its shoulder is lifted by 0.6 rad and its elbow is to stay at 0.3, all warm."""
    arm = ControlledRobot('arm', PAPER, muscles, compensate=compensate)
    angles = []
    for k in range(1300):
        arm.tick([0.0 if k < 500 else 0.6, 0.3], [0.7, 0.7])
        angles.append(arm.angles.copy())
    return np.array(angles[500:]).T


def test_gravity_that_is_known_lets_the_other_joint_stay_where_it_is():
    known, unknown = (lifted(compensate) for compensate in (True, False))
    for shoulder, _ in (known, unknown):
        assert shoulder[-1] == pytest.approx(0.6, abs=3e-3)
    strayed = [np.abs(elbow - 0.3).max() for _, elbow in (known, unknown)]
    assert strayed[0] < 0.5 * strayed[1], strayed
    assert strayed[1] > 5e-3


def test_muscles_that_are_not_as_believed_are_turned_to_the_same_angles():
    other = {'shoulder_flexor': PAPER.replace(k0=27.0, hA=0.016), 'elbow_extensor': PAPER.replace(R0=16.0, hA=0.023)}
    shoulder, elbow = lifted(True, other)
    assert shoulder[-1] == pytest.approx(0.6, abs=5e-3)
    assert elbow[-1] == pytest.approx(0.3, abs=3e-3)


@pytest.mark.parametrize('draw', [1, 2, 3])
def test_an_arm_of_drawn_muscles_comes_to_its_angles(draw):
    """Each muscle off by up to a fifth in five values, as in scripts/arm_table.py, whose worst is 8.7 % past."""
    chance = np.random.default_rng(draw)
    names = [f'{joint}_{role}' for joint in ('shoulder', 'elbow') for role in ('flexor', 'extensor')]
    muscles = {
        name: PAPER.replace({key: PAPER[key] * chance.uniform(0.8, 1.2) for key in ('hA', 'k0', 'R0', 'm', 'B')})
        for name in names
    }
    arm, most = ControlledRobot('arm', PAPER, muscles), np.zeros(2)
    for _ in range(1600):
        arm.tick((0.4, 0.5), (0.7, 0.7))
        most = np.maximum(most, arm.angles)
    assert arm.angles == pytest.approx((0.4, 0.5), abs=1e-3)
    assert (most / (0.4, 0.5) - 1.0 < 0.1).all()


def test_a_robot_is_a_path_too():
    assert ControlledRobot(path_of('finger'), PAPER).joints == ControlledRobot('finger', PAPER).joints


def test_a_muscle_that_it_does_not_have_is_refused():
    with pytest.raises(BadInput, match="no muscle 'sholder_flexor'; did you mean 'shoulder_flexor'"):
        ControlledRobot('arm', PAPER, {'sholder_flexor': PAPER.replace(hA=0.03)})


def test_a_tendon_that_is_pushed_slack_is_taken_up_again():
    """Pushed by hand further than its flexor is stretched, and let go: the flexor is slack, then it pulls again."""
    arm = ControlledRobot('arm', PAPER, load=0.15)
    pushed, tensions = arm.robot.data.qfrc_applied, []
    for k in range(800):
        pushed[arm.robot.speed_place('shoulder')] = 0.02 if 50 <= k < 200 else 0.0
        arm.tick([0.2, 0.0], [0.3, 0.3])
        tensions.append(arm.robot.tensions[0])
    assert max(tensions[100:200]) == 0.0
    assert tensions[-1] > 0.1 and arm.angles == pytest.approx((0.2, 0.0), abs=0.01)
    assert arm.robot.temperatures.max() < 373.65
