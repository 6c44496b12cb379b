import tracemalloc

import numpy as np

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
