"""What a model shows between the instants at which it is stepped, and on average over a block."""

import numpy as np
import pytest

from tcp_muscle_ros.diagnosis.observation.between import bends, weights
from tcp_muscle_ros.diagnosis.observation.blocks import averaged
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.recording.recording import Channel

TAU = 3.0  # s
SWITCH = 10.0


def cooling(time):
    """A temperature that falls from a switch on."""
    return 300.0 + 50.0 * np.where(time < SWITCH, 1.0, np.exp(-np.maximum(time - SWITCH, 0.0) / TAU))


def read(time, shown, at, load=None):
    drive = np.where(time < SWITCH, 0.3, 0.0)
    places, share = weights(time, *bends(drive, np.zeros(time.size) if load is None else load), at)
    return np.sum(share * shown[places], axis=1)


def test_between_two_instants_a_curve_is_followed_and_no_corner_is_rounded():
    time, at = np.unique(np.append(np.arange(0.1, 30.0, 0.6), SWITCH)), np.arange(0.2, 29.0, 0.05)
    error = read(time, cooling(time), at) - cooling(at)
    assert np.max(np.abs(error)) < 0.02
    assert np.max(np.abs(np.interp(at, time, cooling(time)) - cooling(at))) > 0.15
    assert np.max(np.abs(error[at < SWITCH])) < 1e-9


def test_at_an_instant_it_is_what_was_shown_there():
    time = np.unique(np.append(np.arange(0.1, 30.0, 0.6), SWITCH))
    np.testing.assert_allclose(read(time, cooling(time), time), cooling(time), atol=1e-9)


def test_nothing_is_read_across_a_jump_of_the_load():
    time = np.sort(np.append(np.arange(0.0, 20.0, 0.5), 15.0 - 2e-6))
    load = np.where(time < 15.0, 0.3, 0.6)
    at = np.array([14.9, 15.0, 15.1])
    np.testing.assert_allclose(read(time, load, at, load), [0.3, 0.6, 0.6], atol=1e-6)


@pytest.mark.parametrize('count', [1, 2, 3])
def test_few_instants_are_enough(count):
    time = np.arange(float(count))
    corner = np.zeros(count, dtype=bool)
    places, share = weights(time, corner, corner, np.array([-1.0, 0.25 * (count - 1), 5.0]))
    line = np.sum(share * (2.0 * time)[places], axis=1)
    np.testing.assert_allclose(line, [0.0, 0.5 * (count - 1), 2.0 * (count - 1)], atol=1e-12)


def blocks():
    time = np.arange(0.0, 40.0, 0.05)
    drive = Channel('current', np.array([0.0, SWITCH]), np.array([0.3, 0.0]), 'current')
    return averaged(Channel('temperature', time, cooling(time), 'temperature'), drive, 0.3, 60, 0.0)


def test_a_model_is_compared_with_means_by_its_own_means():
    found = blocks()
    middle = cooling(found.time)
    assert np.max(np.abs(middle - found.value)) > 0.1
    assert np.max(np.abs(found.averaged(middle) - found.value)) < 0.012


def test_the_same_of_a_part_of_the_blocks_and_nothing_across_a_gap():
    found = blocks()
    keep = (found.time < 14.0) | (found.time > 17.0)
    part = found.only(keep)
    whole = found.averaged(cooling(found.time))[keep]
    assert np.max(np.abs(part.averaged(cooling(part.time)) - whole)) < 0.03


def test_single_readings_are_their_own_means():
    time = np.arange(0.0, 5.0, 0.1)
    shown = np.sin(time)
    assert Observed(time, shown, np.ones(time.size)).averaged(shown) is shown
