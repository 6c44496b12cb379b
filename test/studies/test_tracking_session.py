"""A session is cut at its setpoints, and each part is judged beside what is possible."""

import numpy as np
import pytest

from tcp_muscle_ros.control.offline import run
from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.studies import control_study as study
from tcp_muscle_ros.studies.tracking_session import judge, largest_gap, possible_time, stretches

MODEL = Parameters.named('karami_tadesse_2017')
TIME = np.arange(0.0, 50.0, study.PERIOD)
SINE = 0.025 - 0.005 * np.cos(2.0 * np.pi * (TIME - 20.0) / 15.0)
SETPOINT = np.select([TIME < 3.0, TIME < 20.0, TIME < 35.0], [0.0, 0.020, SINE], 0.0)


def channel(name, value):
    return Channel(name, TIME, value, name)


def test_a_session_is_cut_where_a_setpoint_was_held():
    found = stretches(channel('displacement_setpoint', SETPOINT))
    # The sine's first point is 20 mm still.
    assert [round(s.begin, 2) for s in found] == [0.0, 3.0, 20.01, 35.0]
    assert [s.is_path for s in found] == [False, False, True, False]
    assert found[1].target == 0.020


def test_steps_and_paths_are_judged():
    happened = run(study.controller(MODEL, 0.27), Muscle(MODEL, load=study.LOAD), study.PERIOD, SETPOINT)
    channels = {
        'displacement_setpoint': channel('displacement_setpoint', SETPOINT),
        'displacement': channel('displacement', happened.displacement),
        'current': channel('current', happened.current),
    }
    steps, paths = judge(Recording('bag', channels, 0), MODEL, 0.27, study.LOAD)
    assert [step.stretch.target for step in steps] == [0.020, 0.0]
    assert steps[0].possible_time == pytest.approx(study.full_current_time(MODEL, 0.27, 0.020), abs=0.011)
    assert steps[0].response.settling_time == pytest.approx(steps[0].possible_time, rel=0.02)
    assert len(paths) == 1
    assert paths[0].rms_error < 5e-5


def test_what_is_possible_from_the_middle_and_what_is_not():
    from_rest = possible_time(MODEL, 0.27, 0.0, 0.04, study.LOAD)
    assert 0.0 < possible_time(MODEL, 0.27, 0.02, 0.04, study.LOAD) < from_rest
    assert np.isnan(possible_time(MODEL, 0.18, 0.0, 0.04, study.LOAD))
    assert possible_time(MODEL, 0.27, 0.02, 0.0, study.LOAD) == pytest.approx(33.6, abs=0.2)


def test_a_node_that_was_held_up_is_seen():
    time = np.delete(TIME, slice(1000, 1012))
    channels = {
        'displacement_setpoint': channel('displacement_setpoint', SETPOINT),
        'displacement': channel('displacement', SETPOINT),
        'current_command': Channel('current_command', time, 0.0 * time, ''),
    }
    assert largest_gap(Recording('bag', channels, 0)) == pytest.approx(0.13)
