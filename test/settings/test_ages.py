"""Ages beside a parameter file: a worn muscle is written as it is now and replayed as it was."""

from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.settings.ages import Age, as_old_as_then, path_beside, read_ages, write_ages

AGES = (Age(10, {'fatigue.n0': 0.0}), Age(20, {'fatigue.n0': 3.5}))


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
    assert as_old_as_then(now, AGES, 20)['fatigue.n0'] == 3.5
    assert as_old_as_then(now, AGES, 30)['fatigue.n0'] == 7.0
