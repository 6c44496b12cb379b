"""What a node's muscle says of inputs that it refuses."""

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from tcp_muscle_ros.control.safety import Limits
from tcp_muscle_ros.nodes import safe_muscle
from tcp_muscle_ros.nodes.safe_muscle import SafeMuscle


class Limited(SafeMuscle):
    def limits_of(self, settings):
        return Limits(0.27, 0.0, 0.5, 373.0, 388.0, 1.0)


def test_an_input_that_is_refused_over_and_over_hides_no_other_in_the_log(monkeypatch):
    said, clock = [], [0.0]
    monkeypatch.setattr(safe_muscle, 'time', SimpleNamespace(monotonic=lambda: clock[0]))
    node = SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=said.append))
    thumb, index = (Limited(node, name, {'start_enabled': True, 'joint_name': name}) for name in ('thumb', 'index'))
    for _ in range(100):  # 10 s
        assert not thumb.accept('load', float('nan'), like='load_n')
        clock[0] += 0.1
        if clock[0] > 1.0 and len(said) == 1:
            assert not thumb.accept('ambient_temperature', 1e3, like='ambient_temperature_c')
            assert not index.accept('load', -1.0, like='load_n')
    assert [sentence.partition(' of ')[0] for sentence in said] == [
        'thumb: load',
        'thumb: ambient_temperature',
        'index: load',
        'thumb: load',
    ]
    assert thumb.refused_inputs == {'load': 100, 'ambient_temperature': 1} and index.refused_inputs == {'load': 1}
