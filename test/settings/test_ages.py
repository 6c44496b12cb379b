"""Ages beside a parameter file: a worn muscle is written as it is now and replayed as it was."""

import json

import numpy as np

from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.mending import mend
from tcp_muscle_ros.recording.recording import UNDATED_NS, Channel, Recording
from tcp_muscle_ros.settings.ages import Age, as_old_as_then, path_beside, read_ages, write_ages

DATE_NS = 1_700_000_000 * 1_000_000_000
AGES = (Age(DATE_NS + 10, {'fatigue.n0': 0.0}), Age(DATE_NS + 20, {'fatigue.n0': 3.5}, 60.0, 'f0'))
NOW = Parameters({'fatigue.n0': 7.0}, ('fatigue',))


def recording(seed=0, end=100.0, start_ns=UNDATED_NS, lost=(0.0, 0.0)):
    """Of one protocol, with noise of its own; of the input nothing is there between two instants (s)."""
    time = np.linspace(0.0, end, 501)
    seen = 0.01 + 1e-4 * np.random.default_rng(seed).standard_normal(time.size)
    kept = (time < lost[0]) | (time >= lost[1])
    channels = (
        Channel('current', time[kept], np.where(time % 50.0 < 25.0, 0.25, 0.0)[kept], '/current'),
        Channel('displacement', time, seen, '/displacement'),
    )
    return Recording('csv', {channel.name: channel for channel in channels}, start_ns)


def diagnosed(*recordings):
    """The ages that a diagnosis of them writes: k cycles before the k-th of the parts that a model can follow."""
    parts = [part for each in recordings for part in mend(each).parts]
    return tuple(
        Age(part.start_ns, {'fatigue.n0': float(k)}, part.end, part.fingerprint) for k, part in enumerate(parts)
    )


def cycles(ages, of):
    return as_old_as_then(NOW, ages, of)['fatigue.n0']


def test_ages_are_read_as_they_were_written(tmp_path):
    write_ages(tmp_path / 'improved.yaml', AGES)
    assert read_ages(tmp_path / 'improved.yaml') == AGES


def test_a_muscle_that_does_not_age_leaves_no_file(tmp_path):
    write_ages(tmp_path / 'improved.yaml', ())
    assert not path_beside(tmp_path / 'improved.yaml').exists()
    assert read_ages(tmp_path / 'improved.yaml') == ()


def test_a_file_that_is_something_else_holds_no_ages(tmp_path):
    for text in ('{', '{"schema": "else"}', '[]', '{"schema": "tcp_muscle_ros/ages-1"}'):
        path_beside(tmp_path / 'improved.yaml').write_text(text)
        assert read_ages(tmp_path / 'improved.yaml') == ()


def test_ages_written_before_recordings_were_known_by_their_readings_are_read(tmp_path):
    entry = {'start_ns': 20, 'end_s': 60.0, 'values': {'fatigue.n0': 3.5}}
    content = {'schema': 'tcp_muscle_ros/ages-1', 'recordings': [entry]}
    path_beside(tmp_path / 'improved.yaml').write_text(json.dumps(content))
    assert read_ages(tmp_path / 'improved.yaml') == (Age(20, {'fatigue.n0': 3.5}, 60.0),)


def test_a_known_recording_is_replayed_as_old_as_the_muscle_was_then_any_other_as_it_is_now():
    assert cycles(AGES, recording(start_ns=DATE_NS + 20)) == 3.5
    assert cycles(AGES, recording(start_ns=DATE_NS + 30)) == 7.0


def test_of_files_that_say_no_date_the_readings_say_which_it_is():
    """Every CSV file begins at the same instant, and runs of one protocol are equally long: a new one is none of the
    old ones."""
    runs = [recording(seed) for seed in range(4)]
    ages = diagnosed(*runs[:3])
    assert [cycles(ages, run) for run in runs] == [0.0, 1.0, 2.0, 7.0]


def test_of_simulated_bags_the_readings_say_which_it_is():
    """The clock of a simulation begins at 0 in every bag."""
    runs = [recording(seed, start_ns=0) for seed in range(3)]
    assert [cycles(diagnosed(*runs[:2]), run) for run in runs] == [0.0, 1.0, 7.0]


def test_a_file_without_a_date_of_which_a_part_is_lost_is_as_old_as_its_first_part():
    runs = [recording(0), recording(1, lost=(40.0, 60.0)), recording(2)]
    ages = diagnosed(*runs)
    assert len(ages) == 4
    assert [cycles(ages, run) for run in runs] == [0.0, 1.0, 3.0]


def test_a_conversion_of_units_and_back_leaves_a_recording_what_it_is():
    run = recording()
    there = run['displacement'].value * 1e3 / 3.0
    again = Channel('displacement', run['displacement'].time, there * 3.0 / 1e3, '/stroke')
    assert np.any(again.value != run['displacement'].value)
    assert Recording('bag', {**run.channels, 'displacement': again}, 5).fingerprint == run.fingerprint


def test_where_an_older_file_knows_no_readings_it_is_the_only_one_of_that_length():
    old = tuple(Age(UNDATED_NS, {'fatigue.n0': float(k)}, 100.0 + 50.0 * k) for k in range(3))
    assert [cycles(old, recording(end=100.3 + 50.0 * k)) for k in range(3)] == [0.0, 1.0, 2.0]
    assert cycles(old, recording(end=130.0)) == 7.0
    equal = tuple(Age(UNDATED_NS, {'fatigue.n0': float(k)}, 100.0) for k in range(3))
    assert cycles(equal, recording(end=100.0)) == 7.0
