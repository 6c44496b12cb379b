"""A channel that is late, beside the effect itself run at the pace of the samples."""

import numpy as np
import pytest
from diagnosis.made import NOMINAL

from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.late import Late, taken_out
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.muscle import simulate

SAMPLE = 0.05
# As a recording is averaged in which a weight may ring: single samples after a step of the load, else six together.
BEGINS = np.unique([k for k in range(2400) if k % 6 == 0 or k % 480 < 90])


def averaged(values, begins):
    """Means over the samples from each of these to the next."""
    return np.add.reduceat(values, begins) / np.diff(np.append(begins, values.size))


@pytest.mark.parametrize(('number', 'channel'), [(0, 'temperature'), (1, 'displacement')])
@pytest.mark.parametrize('delay', [0.08, 0.31, 1.1])
@pytest.mark.parametrize('begins', [np.arange(0, 2400, 6), BEGINS], ids=['alike', 'single after a step'])
def test_means_over_samples_are_those_of_the_late_samples(number, channel, delay, begins):
    """Edges of the drive and of the load, and the kinks and jumps that they make later, inside of means."""
    time = SAMPLE * np.arange(120 * 20)
    drive = np.where(np.mod(time, 30.0) < 12.0, 0.27, 0.0)
    load = np.where(np.mod(time, 48.0) < 24.0, 0.4, 0.9)
    skew = {'clock_skew.d': delay, 'clock_skew.r': 5e-4, 'clock_skew.channel': float(number)}
    muscle = NOMINAL.replace(skew).with_effects('clock_skew')
    samples = getattr(simulate(muscle, time, drive, load=load), channel)

    middle = averaged(time, begins)
    edges = time[1:][(np.diff(drive) != 0.0) | (np.diff(load) != 0.0)]
    instants = np.unique(np.concatenate([[0.0], middle, edges]))
    at = np.searchsorted(time, instants + 1e-9, side='right') - 1
    imposed = Imposed('current', instants, drive[at], load[at], np.full(instants.size, NOMINAL['T0']))
    count = np.diff(np.append(begins, time.size)).astype(float)
    seen = {channel: Observed(middle, averaged(samples, begins), count)}
    experiment = Experiment('late', imposed, Holding('load', 0.4), seen)
    plain, late = taken_out(muscle, TCP_MUSCLE)
    outputs = experiment.outputs(plain)
    off = experiment.shown(outputs, late)[channel] - seen[channel].value
    size = np.ptp(samples)
    assert late.channel == channel
    assert float(np.sqrt(np.mean(off**2))) < 1e-3 * size
    assert float(np.max(np.abs(off))) < 1e-2 * size
    plainly = experiment.shown(outputs)[channel]
    assert float(np.sqrt(np.mean((plainly - seen[channel].value) ** 2))) > 5e-3 * size
    # A delay of nothing is nothing.
    assert experiment.shown(outputs, Late(channel, 0.0, 0.0))[channel] == pytest.approx(plainly, abs=1e-12)


def test_where_none_is_late_nothing_is_taken_out():
    muscle = NOMINAL.with_effects('thermocouple_lag')
    assert taken_out(muscle, TCP_MUSCLE) == (muscle, None)
