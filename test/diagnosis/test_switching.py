"""Switches between two samples of their record, in recordings of the independent truth generator: nothing is concealed,
but the current is shown as a logger samples it."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis import truth

from tcp_muscle_ros.diagnosis.answer.replaying import SETTLED_BY, own_of, replay
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.switching import settled
from tcp_muscle_ros.diagnosis.observation.blocks import switches
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.recording import Channel

NOMINAL = Parameters.named('karami_tadesse_2017')
PERIOD = 0.15  # s
SEED = 4715  # of its own: the development suite is tuned on others


@pytest.fixture(scope='module')
def recordings(tmp_path_factory):
    return truth.recordings(tmp_path_factory.mktemp('truth'), 'development', SEED, 0, 'null', '')


def logged(recording, late=0.0):
    """The recording with its current as a logger shows it, whose samples have nothing to do with the switches."""
    current = recording['current']
    time = np.arange(0.0, current.time[-1], PERIOD)
    value = current.value[np.maximum(np.searchsorted(current.time, time + late, side='right') - 1, 0)]
    shown = Channel('current', time, value, current.topic)
    return replace(recording, channels={**recording.channels, 'current': shown})


def prepared(recordings):
    return tuple(prepare(recording, NOMINAL, most=800) for recording in recordings)


def fitted(experiments, latents=()):
    return calibrate(experiments, NOMINAL, latents=latents).fit


def true_switches(recording):
    current = recording['current']
    return current.time[1:][np.abs(np.diff(current.value)) > 0.05 * np.ptp(current.value)]


def test_switches_are_moved_to_where_all_channels_see_them(recordings):
    shown = prepared([logged(recording) for recording in recordings])
    before_moved = fitted(shown)
    moved = settled(before_moved)
    assert moved is not None
    after_moved = fitted(shown, moved)
    errors = []
    for recording, before, after in zip(recordings, shown, after_moved.problem.followed, strict=True):
        imposed = after.imposed
        at = imposed.time[1:][np.abs(np.diff(imposed.drive)) > 0.05 * np.ptp(imposed.drive)]
        inside = [
            k for k, (low, high) in enumerate(before.imposed.switches) if np.any((at >= low - 1e-6) & (at <= high))
        ]
        assert len(inside) == len(before.imposed.switches)  # none leaves its two samples
        errors += [np.min(np.abs(at - true)) for true in true_switches(recording)[1:]]
        assert 'switched between two samples' in after.notes[-1]
    assert np.median(errors) < 0.15 * PERIOD
    assert after_moved.mean_square['displacement'] < 0.7 * before_moved.mean_square['displacement']
    assert all(mine is run for mine, run in zip(after_moved.problem.experiments, shown, strict=True))


def test_physics_is_not_made_of_switches_that_were_sampled(recordings):
    diagnosis = diagnose(prepared([logged(recording) for recording in recordings]), NOMINAL)
    assert diagnosis.verdict in ('match', 'wrong_parameters')
    assert not diagnosis.findings
    assert any('switched between' in note for recording in diagnosis.recordings for note in recording.issues)


def test_a_replay_switches_when_the_channels_see_it_where_the_muscle_is_the_right_one(recordings):
    muscle = calibrate(prepared(recordings), NOMINAL).parameters
    sampled, shown = (prepare(recording, NOMINAL) for recording in (recordings[0], logged(recordings[0])))
    few = prepare(logged(recordings[0]), NOMINAL, most=SETTLED_BY)
    own = own_of(few, muscle)
    as_was, moved, late = (
        replay(run, muscle, own=o)
        for run, o in ((sampled, own_of(sampled, muscle)), (shown, own), (shown, replace(own, switches=())))
    )
    assert moved['displacement'].rmse < 1.1 * as_was['displacement'].rmse < 0.8 * late['displacement'].rmse
    assert not own_of(few, NOMINAL).switches  # what another muscle misses is no matter of switches


def test_a_record_that_says_when_is_believed(recordings):
    experiments = prepared(recordings)
    assert settled(fitted(experiments)) is None


def test_a_record_that_is_early_is_no_matter_of_samples(recordings):
    experiments = prepared([logged(recording, late=3.0 * PERIOD) for recording in recordings])
    assert settled(fitted(experiments)) is None


def test_only_a_record_at_a_rhythm_leaves_open_when():
    time = np.arange(0.0, 20.0, 0.1)
    sampled = Channel('current', time, np.where(time % 10.0 < 4.95, 0.3, 0.0), '/current')
    np.testing.assert_allclose(switches(sampled)[0], [[4.9, 5.0], [9.9, 10.0], [14.9, 15.0]])
    changes = Channel('current', np.array([0.0, 5.0, 10.0, 15.0]), np.array([0.3, 0.0, 0.3, 0.0]), '/current')
    assert switches(changes)[0].shape == (0, 2)
    wave = Channel('current', time, np.where(np.arange(time.size) % 2 == 0, 0.3, 0.0), '/current')
    assert switches(wave)[0].shape == (0, 2)


def test_where_samples_were_lost_between_two_levels_that_is_told_apart():
    time = np.delete(np.arange(0.0, 20.0, 0.1), [50, 51])
    shown = Channel('current', time, np.where(time % 10.0 < 4.95, 0.3, 0.0), '/current')
    sampled, lost = switches(shown)
    np.testing.assert_allclose(lost, [[4.9, 5.2]])
    np.testing.assert_allclose(sampled, [[9.9, 10.0], [14.9, 15.0]])


def without(recording, first, count):
    """The recording with samples of its current lost."""
    current = recording['current']
    kept = np.ones(len(current), dtype=bool)
    kept[first : first + count] = False
    shown = replace(current, time=current.time[kept], value=current.value[kept])
    return replace(recording, channels={**recording.channels, 'current': shown})


def test_a_switch_whose_sample_was_lost_is_found_from_what_followed(recordings):
    current = recordings[0]['current']
    at = int(np.searchsorted(current.time, true_switches(recordings[0])[2]))
    shown = prepared([without(recordings[0], at, 6), *recordings[1:]])
    assert len(shown[0].imposed.lost) == 1
    before = fitted(shown)
    moved = settled(before)
    assert 'where samples of its record were lost' in moved[0].switched.notes[-1]
    drive = moved[0].switched.imposed
    switched = drive.time[1:][np.abs(np.diff(drive.drive)) > 0.05 * np.ptp(drive.drive)]
    assert np.min(np.abs(switched - current.time[at])) < 0.04
    assert fitted(shown, moved).mean_square['displacement'] < 0.7 * before.mean_square['displacement']


def test_one_switch_that_came_just_after_a_sample_is_moved_alone(recordings):
    current = recordings[0]['current']
    at = int(np.searchsorted(current.time, true_switches(recordings[0])[2]))
    value = current.value.copy()
    value[at] = value[at - 1]  # read just before it switched
    late = replace(current, value=value)
    shown = prepared([replace(recordings[0], channels={**recordings[0].channels, 'current': late}), *recordings[1:]])
    before = fitted(shown)
    moved = settled(before)
    assert '(1 of ' in moved[0].switched.notes[-1]
    assert not any(latent.switched.notes for latent in moved[1:])
    assert fitted(shown, moved).mean_square['displacement'] < before.mean_square['displacement']
