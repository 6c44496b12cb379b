"""Where a recording is cut, and what is kept between the cuts."""

import numpy as np
import pytest

from tcp_muscle_ros.recording.leaps import DAY_NS, as_made
from tcp_muscle_ros.recording.mending import mend
from tcp_muscle_ros.recording.recording import UNDATED_NS, Channel, Recording

TIME = np.arange(0.0, 120.0, 0.05)


def recorded(silence: tuple[float, float], jump: float) -> Recording:
    """A current that is unknown during the silence (s), and another run from a jump (s) on."""
    known = (silence[0] > TIME) | (silence[1] < TIME)
    current = np.where((TIME // 10.0) % 2.0 == 0.0, 0.2, 0.0)
    noise = 0.05 * np.random.default_rng(0).standard_normal(TIME.size)
    temperature = 300.0 + 20.0 * np.sin(TIME / 15.0) + 60.0 * (jump <= TIME) + noise
    channels = {
        'current': Channel('current', TIME[known], current[known], '/current'),
        'temperature': Channel('temperature', TIME, temperature, '/temperature'),
    }
    return Recording('recorded', channels, 0)


@pytest.mark.parametrize(
    ('jump', 'spans'),
    [
        (20.0, [(0.0, 20.0), (20.0, 40.0), (70.0, 120.0)]),
        (50.0, [(0.0, 40.0), (70.0, 120.0)]),
        (69.0, [(0.0, 40.0), (70.0, 120.0)]),
        (90.0, [(0.0, 40.0), (70.0, 90.0), (90.0, 120.0)]),
    ],
)
def test_nothing_is_kept_of_a_silence_wherever_another_run_begins(jump, spans):
    parts = mend(recorded((40.0, 70.0), jump)).parts
    found = [(part.start_ns * 1e-9, part.start_ns * 1e-9 + part.duration) for part in parts]
    assert np.array(found) == pytest.approx(np.array(spans), abs=0.2)
    assert all('no current for 30.' in part.notes[-1] and f'jumps at {jump:.1f} s' in part.notes[-1] for part in parts)


def test_a_part_with_hardly_a_value_is_none():
    # The record resumes for 6 s, in which a thermometer that is read once a second tells nothing of a muscle.
    time = np.concatenate([np.arange(0.0, 60.0), np.arange(100.0, 106.0), np.arange(140.0, 200.0)])
    current = np.where(np.mod(time, 20.0) < 10.0, 0.2, 0.0)
    warm = 300.0 + 10.0 * np.sin(time)
    made = {'current': Channel('current', time, current, ''), 'temperature': Channel('temperature', time, warm, '')}
    parts = mend(Recording('made', made, 0)).parts
    assert [round(part['temperature'].time.size, -1) for part in parts] == [60, 60]


def test_recordings_count_in_the_order_in_which_they_were_made_where_all_are_dated():
    def begun(*days):
        return [Recording(str(day), {}, UNDATED_NS + round(day * DAY_NS), {}) for day in days]

    assert [one.path for one in as_made(begun(10, 1, 2.5))] == ['1', '2.5', '10']
    assert [one.path for one in as_made(begun(10, 0, 2.5))] == ['10', '0', '2.5'], 'one is not: nobody knows'
