"""Settling, overshoot and errors, against curves whose figures are known."""

from math import exp, isnan, log

import numpy as np
import pytest

from tcp_muscle_ros.studies.step_response import entry_time, overshoot, rms_error, settling_time, step_response

TIME = np.arange(0.0, 20.0, 0.001)


def test_a_first_order_response_settles_when_its_exponential_says():
    value = 1.0 - np.exp(-TIME / 2.0)
    assert settling_time(TIME, value, 1.0, 0.02) == pytest.approx(-2.0 * log(0.02), abs=0.002)
    assert entry_time(TIME, value, 1.0, 0.02) == settling_time(TIME, value, 1.0, 0.02)
    assert overshoot(value, 0.0, 1.0) == 0.0


def test_settling_is_the_last_entry_not_the_first():
    damping = 0.2
    fast = np.sqrt(1.0 - damping**2)
    value = 1.0 - np.exp(-damping * TIME) * (np.cos(fast * TIME) + damping / fast * np.sin(fast * TIME))
    assert entry_time(TIME, value, 1.0, 0.02) < 2.0 < 10.0 < settling_time(TIME, value, 1.0, 0.02)
    assert overshoot(value, 0.0, 1.0) == pytest.approx(exp(-np.pi * damping / fast), abs=1e-4)


def test_overshoot_of_a_release_is_downwards():
    assert overshoot(np.array([4.0, 2.0, 0.9, 1.0]), 4.0, 1.0) == pytest.approx(0.1 / 3.0)
    assert isnan(overshoot(np.array([1.0, 1.0]), 1.0, 1.0))


def test_what_never_settles_is_not_a_number():
    value = np.sin(TIME)
    assert isnan(settling_time(TIME, value, 2.0, 0.02))
    assert isnan(entry_time(TIME, value, 2.0, 0.02))
    assert settling_time(TIME, 0.0 * value, 0.0, 0.02) == 0.0


def test_a_step_response_counts_from_its_first_sample():
    time = TIME + 100.0
    value = 0.01 + 0.02 * (1.0 - np.exp(-TIME))
    response = step_response(time, value, np.full(TIME.size, 0.2), 0.03)
    assert response.start == 0.01
    assert response.settling_time == pytest.approx(-log(0.02), abs=0.002)
    assert response.steady_error == pytest.approx(0.02 * exp(-15.0), rel=0.01)
    assert response.ripple == pytest.approx(0.0, abs=1e-12)
    assert response.rms_error == pytest.approx(rms_error(value, 0.03))
