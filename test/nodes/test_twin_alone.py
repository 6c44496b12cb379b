"""The twin's node in this process, without a muscle: what it makes of what it is handed."""

import os

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import rclpy
from rclpy.parameter import Parameter

from tcp_muscle_ros.nodes.twin_node import TwinNode

_LEFT = []  # nodes: kept, so that nothing destroys them (see conftest.py)


@pytest.fixture
def twin(request, tmp_path):
    """A node whose ticks are not begun, with the parameters that the test asks for."""
    given = {'report_folder': tmp_path, 'keep_s': 20.0, **getattr(request, 'param', {})}
    arguments = [word for name, value in given.items() for word in ('-p', f'{name}:={value}')]
    rclpy.init(args=['--ros-args', *arguments], domain_id=1 + (os.getpid() + 61) % 100)
    made = TwinNode()
    _LEFT.append(made)
    yield made
    rclpy.try_shutdown()


def test_what_two_models_are_compared_on_can_be_set_while_it_runs(twin):
    (done,) = twin.set_parameters([Parameter('trial_s', value=7.0)])
    assert done.successful
    assert twin._twin.trial == 7.0
