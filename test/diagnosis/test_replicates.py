"""What differs between the same thing done twice is noise, however much the model misses of both."""

from dataclasses import replace

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.noise.replicates import copies, done_twice, protocols, pure_error
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.imposed import Holding, Imposed
from tcp_muscle_ros.diagnosis.observation.observed import Observed

NOISE = 5e-5
TIME = np.arange(0.0, 200.0, 0.2)


def recording(begin, *, load=0.6, current=0.25):
    """Two pulses, of different lengths so that no cycle repeats within a recording, from ``begin`` on."""
    since = TIME - begin
    drive = np.where(((since > 0.0) & (since < 40.0)) | ((since > 90.0) & (since < 110.0)), current, 0.0)
    imposed = Imposed('current', TIME, drive, np.full(TIME.size, load), np.full(TIME.size, 296.0))
    observed = {'displacement': Observed(TIME, np.zeros(TIME.size), np.ones(TIME.size))}
    return Experiment('made', imposed, Holding(), observed)


def missed(begin, seed):
    """What a model misses: far more than the noise, the same each time."""
    return 1e-3 * np.sin(0.7 * (TIME - begin)) + np.random.default_rng(seed).normal(0.0, NOISE, TIME.size)


def test_the_same_recording_made_again_tells_the_noise_from_what_the_model_misses():
    made = [recording(5.0), recording(11.0)]
    assert copies(made[0].imposed, made[1].imposed)[2] == pytest.approx(6.0, abs=0.3)
    left = [{'displacement': missed(5.0, 1)}, {'displacement': missed(11.0, 2)}]
    found = pure_error(made, left, 'displacement', done_twice(made))
    assert found.sigma == pytest.approx(NOISE, rel=0.35)


def test_what_both_miss_alike_is_no_noise_where_one_weighs_more():
    made = [recording(5.0), recording(11.0)]
    seen = made[1].observed['displacement']
    made[1] = replace(made[1], observed={'displacement': replace(seen, beside=4.0)})
    left = [{'displacement': missed(5.0, 1)}, {'displacement': 4.0 * missed(11.0, 2)}]
    found = pure_error(made, left, 'displacement', done_twice(made))
    assert found.sigma == pytest.approx(np.sqrt(2.0 / (1.0 + 4.0**-2)) * NOISE, rel=0.35)


@pytest.mark.parametrize('other', [recording(5.0, load=0.4), recording(5.0, current=0.2)], ids=['load', 'current'])
def test_another_load_or_current_is_another_recording(other):
    made = recording(5.0)
    assert copies(made.imposed, other.imposed) is None
    left = [{'displacement': missed(5.0, 1)}, {'displacement': missed(5.0, 2)}]
    assert pure_error([made, other], left, 'displacement', done_twice([made, other])) is None


def test_runs_before_which_another_load_hung_are_not_of_one_protocol():
    made = [recording(50.0), recording(50.0), recording(80.0)]
    assert [one.recordings for one in protocols(made)] == [(0, 1, 2)]
    for before in (slice(50, 150), slice(200, 300)):  # within what both have of it, and where one goes back further
        made[2].imposed.load[before] = 1.2
        assert [one.recordings for one in protocols(made)] == [(0, 1)]
        made[2].imposed.load[before] = 0.6
