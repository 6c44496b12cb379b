import tracemalloc

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.plausibility import refuse_implausible
from tcp_muscle_ros.recording.recording import Channel, Recording


def test_a_recording_of_months_is_looked_at_in_little_memory():
    time = np.linspace(0.0, 100 * 86400.0, 2000)  # 270 MB a channel at four instants a second
    drive = 0.3 * (np.sin(time / 86400.0) > 0)
    recording = Recording(
        '',
        {
            'current': Channel('current', time, drive, '/current'),
            'displacement': Channel('displacement', time, 0.01 * drive + 1e-5 * np.cos(time), '/displacement'),
        },
        0,
    )
    tracemalloc.start()
    try:
        refuse_implausible(recording)
        assert tracemalloc.get_traced_memory()[1] < 150e6
    finally:
        tracemalloc.stop()


def test_a_room_that_yaml_takes_for_a_word_is_a_room():
    time = np.arange(100) / 10
    drive = Channel('current', time, np.where(time > 5, 0.3, 0.0), '/current')
    warm = Channel('temperature', time, np.full(100, 323.15), '/temperature')
    room = Recording('', {'current': drive, 'temperature': warm}, 0, {'ambient_c': '5e1'})
    refuse_implausible(room)
    with pytest.raises(BadInput, match=r'would be a room of 10\.0 degC'):
        refuse_implausible(Recording('', room.channels, 0, {'ambient_c': 'not measured'}))
