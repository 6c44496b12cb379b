"""Ages beside a parameter file: a worn muscle is written as it is now and replayed as it was."""

from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.recording import UNDATED_NS
from tcp_muscle_ros.settings.ages import Age, as_old_as_then, path_beside, read_ages, write_ages

AGES = (Age(10, {'fatigue.n0': 0.0}), Age(20, {'fatigue.n0': 3.5}, 60.0))


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


def test_a_known_recording_is_replayed_as_old_as_the_muscle_was_then_any_other_as_it_is_now():
    now = Parameters({'fatigue.n0': 7.0}, ('fatigue',))
    assert as_old_as_then(now, AGES, 20, 60.0)['fatigue.n0'] == 3.5
    assert as_old_as_then(now, AGES, 30, 60.0)['fatigue.n0'] == 7.0


def test_of_files_that_say_no_date_the_length_says_which_it_is():
    """Every CSV file begins at the same instant: a new one is none of the old ones."""
    now = Parameters({'fatigue.n0': 7.0}, ('fatigue',))
    old = tuple(Age(UNDATED_NS, {'fatigue.n0': float(k)}, 100.0 + 50.0 * k) for k in range(3))
    assert [as_old_as_then(now, old, UNDATED_NS, 100.3 + 50.0 * k)['fatigue.n0'] for k in range(3)] == [0.0, 1.0, 2.0]
    assert as_old_as_then(now, old, UNDATED_NS, 130.0)['fatigue.n0'] == 7.0
