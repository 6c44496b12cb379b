"""A controller's recording is told from one that a generator played, with or without its setpoint."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, experiment

from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.diagnosis.observation.closed_loop import is_closed_loop
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import FOLLOWS_SETPOINT, Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle import Muscle

NOISE = 5e-5  # m


def controlled(mode, period=0.02):
    """A slow sine followed by the package's controller, which sees a noisy displacement."""
    controller = TrackingController(
        NOMINAL, period, 0.27, 0.588, NOMINAL['T0'], mode=mode, temperature_limit=373.0, time_constant=1.0,
        probe_current=0.0, pid_kp=20.0, pid_ki=10.0, pid_kd=0.0, pid_filter_time=0.1,
    )  # fmt: skip
    muscle, rng = Muscle(NOMINAL, load=0.588), np.random.default_rng(3)
    time, current, drive, seen = np.arange(0.0, 100.0, period), 0.0, [], []
    for now in time:
        seen.append(muscle.step(period, current).displacement + NOISE * rng.standard_normal())
        wanted = 0.008 * (1.0 + np.sin(2.0 * np.pi * now / 40.0))
        current = controller.update(wanted, displacement=seen[-1], applied_current=current).current
        drive.append(current)
    blocks = np.arange(0, time.size, 5)
    observed = Observed(time[blocks] + 2 * period, np.add.reduceat(seen, blocks) / 5, np.full(blocks.size, 5.0))
    imposed = Imposed('current', time, np.array(drive), np.full(time.size, 0.588), np.full(time.size, NOMINAL['T0']))
    return Experiment('controlled', imposed, Holding('load', 0.588), {'displacement': observed})


@pytest.mark.parametrize('mode', ['model', 'pid'])
def test_a_controller_answers_its_sensors_noise(mode):
    assert is_closed_loop(controlled(mode))


PULSES = np.where(np.mod(TIME, 70.0) < 25.0, 0.27, 0.0)
WAVES = {
    'sine': 0.2 + 0.05 * np.sin(2 * np.pi * TIME / 40.0),
    'chirp': 0.2 + 0.05 * np.sin(2 * np.pi * TIME * (0.01 + 0.1 * TIME / 210.0)),
    'ammeter': np.where(np.mod(TIME, 70.0) < 25.0, 0.27, 0.0)
    + 1e-4 * np.random.default_rng(1).standard_normal(TIME.size),
}


@pytest.mark.parametrize('name', WAVES)
def test_what_a_generator_plays_is_open_loop_however_smooth_or_noisy(name):
    assert not is_closed_loop(experiment(['temperature', 'displacement'], drive=WAVES[name]))


def test_a_ramp_in_many_steps_rests_between_them():
    """Whatever the stroke does at the steps: a controller would change its drive between them, too."""
    ramp = 0.27 * np.sqrt(1.0 - np.abs(2.0 * np.floor(TIME / 0.6) * 0.6 / TIME[-1] - 1.0))
    played = experiment(['displacement'], drive=ramp)
    seen = played.observed['displacement']
    against = replace(seen, value=-0.01 * np.interp(seen.time, TIME, ramp))
    assert not is_closed_loop(replace(played, observed={'displacement': against}))


def test_a_recorded_setpoint_says_so():
    told = experiment(['displacement'], drive=WAVES['sine'])
    told.known[FOLLOWS_SETPOINT] = True
    assert is_closed_loop(told)
    pulses = experiment(['displacement'])  # two levels: somebody switched it
    pulses.known[FOLLOWS_SETPOINT] = True
    assert not is_closed_loop(pulses)
