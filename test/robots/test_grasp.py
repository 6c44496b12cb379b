"""The finger holds a ball while gravity turns; and whatever breaks, it ends cold or warm, never hot or astray."""

import numpy as np
import pytest

from tcp_muscle_ros.robots.grasp import CLOSED, HELD, WARMEST, grasp

mujoco = pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")
WEIGHT = 0.004 * 9.81  # N, of the ball


@pytest.fixture(scope='module')
def whole():
    return grasp()


def test_it_holds_the_ball_while_gravity_turns_by_a_right_angle(whole):
    turning = (whole.time >= CLOSED) & (whole.time <= HELD)
    assert HELD - CLOSED >= 5.0 and whole.turned[turning][-1] == pytest.approx(np.pi / 2.0, abs=0.01)
    assert whole.slip < 2e-3
    assert whole.pressed[turning].min() > 1.5 * WEIGHT
    assert whole.temperatures.max() <= WARMEST + 0.5
    assert abs(whole.book.error) < 0.01 and abs(whole.book.work_error) < 0.01 * whole.book.by_heat


def test_with_a_ball_that_it_does_not_hold_the_ball_is_gone():
    """The same without friction: what holds it above is the grasp, not the model."""

    def smooth(finger, time):
        if time == 0.0:
            finger.robot.model.geom_friction[:] = 1e-5

    assert grasp(before=smooth, until=HELD).slip > 0.02


@pytest.mark.parametrize('broken', ['wire', 'cable'])
def test_a_muscle_that_fails_in_the_grasp_ends_safely(broken, whole):
    """Of the muscle that presses. The ball may fall; nothing gets hotter than the limit or turns beyond its stops."""

    def cut(finger, time):
        if time == pytest.approx(CLOSED):
            (finger.robot.cut_wire if broken == 'wire' else finger.robot.cut_cable)('knuckle_flexor')

    it = grasp(before=cut, until=CLOSED + 5.0)
    assert it.temperatures.max() < WARMEST + 0.5
    assert (it.angles > -0.31).all() and (it.angles < 1.21).all()
    # It ends at rest, with less pressure than the whole one has.
    assert np.abs(np.diff(it.angles[-100:], axis=0)).max() < 1e-3
    assert it.pressed[-1] < whole.pressed[-1]
    if broken == 'cable':
        assert it.tensions[-1][0] == 0.0
    else:
        assert it.temperatures[-1][0] < it.temperatures[round(CLOSED / 0.01)][0] - 5.0


def test_a_blocked_finger_gets_no_hotter_than_its_limit():
    """Held straight by something rigid, it presses as hard as the limit allows, and no harder."""

    def block(finger, time):
        if time == 0.0:
            model = finger.robot.model
            for joint in finger.joints:
                model.jnt_range[model.joint(joint).id] = -0.001, 0.001

    it = grasp(before=block)
    assert np.abs(it.angles).max() < 0.02
    assert WARMEST - 10.0 < it.temperatures.max() < WARMEST + 0.5
