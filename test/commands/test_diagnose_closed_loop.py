"""``tcp_muscle diagnose`` on what a controller did: real nodes, a muscle that is not the nominal one, nothing else."""

import json
import math

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from tcp_muscle_ros.nodes.session import Session
from tcp_muscle_ros.tool import main

pytestmark = [pytest.mark.processes, pytest.mark.slow]
# Another specimen than the nominal one; the controller knows nothing of it.
SPECIMEN = {'hA': 0.024, 'C': 0.19, 'R0': 13.0, 'B': 1.5}
NOISE = {'displacement_noise_m': 3e-5, 'temperature_noise_k': 0.1, 'resistance_noise_ohm': 5e-3}
DURATION = 32.0  # s


def setpoint(t):
    """Three steps, a sine, a release; m."""
    if 14.0 <= t < 24.0:
        return 0.018 + 0.005 * math.cos(math.pi * (t - 14.0) / 5.0)
    return 0.012 if 1.0 <= t < 8.0 else 0.025 if 8.0 <= t < 14.0 else 0.0


@pytest.fixture(scope='module')
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp('closed_loop')
    limits = {'rate_hz': 50.0, 'current_limit_a': 0.27}
    with Session(folder / 'bag', sim={**limits, **NOISE, **SPECIMEN}, controller=limits, rate_hz=50.0) as session:
        session.follow(setpoint, DURATION)
    assert main(['diagnose', str(folder / 'bag'), '--output', str(folder / 'report')]) == 0
    return json.loads((folder / 'report' / 'report.json').read_text())


def test_no_physics_is_made_up(report):
    assert report['findings'] == []
    assert report['unexplained'] is None
    assert report['verdict'] == 'wrong_parameters'
    errors = report['fit']['displacement']
    assert errors['rmse_calibrated'] < 1e-4
    assert errors['rmse_nominal'] > 5.0 * errors['rmse_calibrated']  # by how much depends on what the controller did


def test_it_says_what_closed_loop_data_cannot_show(report):
    (told,) = [note for note in report['notes'] if 'closed loop' in note]
    assert 'creep, hysteresis and a loss of stroke are hard to see; record open-loop steps' in told
    assert {'displacement', 'temperature', 'resistance', 'current'} <= set(report['recordings'][0]['channels'])


def test_the_parameters_that_the_controller_moved_enough_are_found(report):
    for name in ('hA', 'C', 'R0'):
        found = report['calibration'][name]
        assert found['value'] == pytest.approx(SPECIMEN[name], rel=0.05), name
