"""A run in this process, with what it sends caught: what it does once it knows that it must stop."""

import os
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import rclpy

from tcp_muscle_ros.control.playing import Part
from tcp_muscle_ros.nodes.runner import Runner

_LEFT = []  # kept, so that nothing destroys its node (see conftest.py)


@pytest.fixture
def runner():
    rclpy.init(domain_id=1 + (os.getpid() + 71) % 100)
    _LEFT.append(made := Runner('', 'current', 373.15, print))
    yield made
    rclpy.try_shutdown()


@contextmanager
def kept_nowhere(*_):
    yield SimpleNamespace(failure=None)


def test_neither_a_current_nor_a_load_is_sent_once_the_muscle_is_too_hot(runner, monkeypatch, tmp_path):
    sent, hung, waits = [], [], []
    acknowledged = SimpleNamespace(wait_for_all_acked=lambda _: None)
    caught = {
        '_command': SimpleNamespace(send=sent.append, publisher=acknowledged),
        '_load': SimpleNamespace(send=hung.append),
        '_late': SimpleNamespace(send=lambda _: None),
        '_rivals': SimpleNamespace(refuse=lambda *_: None, newcomer=lambda: ''),
    }
    for name, stands_in in caught.items():  # made when a muscle is found
        monkeypatch.setattr(runner, name, stands_in, raising=False)
    monkeypatch.setattr(runner, '_recorded', kept_nowhere)

    def waits_until(due):
        waits.append(due)
        if len(waits) == 3:
            runner._supervisor.temperature(400.0)

    monkeypatch.setattr(runner, '_wait', waits_until)
    time = np.array([0.0, 0.1, 0.2, 0.3])
    part = Part(1, time, np.array([0.0, 0.1, 0.27, 0.27]), np.array([0.3, 0.3, 1.0, 1.0]))
    assert 'the limit 100.0 degC' in runner.play(part, tmp_path, {}).stopped
    assert sent == [0.0, 0.1, 0.0] and hung == [0.3]
