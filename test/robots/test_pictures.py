"""Pictures without a screen."""

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.robots.pictures import BACKENDS, camera
from tcp_muscle_ros.robots.robot import Robot

pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")
NAMES = [f'{joint}_{role}' for joint in ('knuckle', 'middle') for role in ('flexor', 'extensor')]


@pytest.fixture
def finger():
    paper = Parameters.named('karami_tadesse_2017')
    return Robot('finger', {name: Muscle(paper, end='blocked', load=0.4) for name in NAMES})


@pytest.mark.parametrize('backend', BACKENDS)
def test_what_moves_and_what_is_warm_is_seen(finger, backend):
    try:
        eye = camera(finger, 200, 120, backend)
    except BadInput as problem:
        pytest.skip(str(problem))
    try:
        still = eye.picture(finger)
        assert still.shape == (120, 200, 3) and still.dtype == np.uint8 and still.std() > 10.0
        blue = (still[:, :, 2].astype(int) - still[:, :, 0] > 60).sum()
        assert 100 < blue < 3000  # the ball
        finger.step([0.27, 0.0, 0.27, 0.0], 2500)
        seen = eye.picture(finger)
        assert (np.abs(seen.astype(int) - still).max(axis=2) > 30).sum() > 100
        red = [(picture[:, :100, 0].astype(int) - picture[:, :100, 1] > 40).sum() for picture in (still, seen)]
        assert red[0] < 10 < red[1]
    finally:
        eye.close()


def test_without_graphics_it_is_drawn(finger, monkeypatch):
    for name in ('egl', 'osmesa'):
        monkeypatch.setitem(__import__('sys').modules, f'mujoco.{name}', None)
    assert camera(finger).backend == 'drawn'
    with pytest.raises(BadInput, match='no pictures can be drawn with egl here'):
        camera(finger, backend='egl')
    with pytest.raises(BadInput, match="unknown backend 'eglo'; did you mean 'egl'"):
        camera(finger, backend='eglo')
