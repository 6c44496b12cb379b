"""The sequential test: no alarm by chance or by what a calibration leaves, and one soon where a model is off."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tcp_muscle_ros.control.sequential import Rule, Sequential, hours_between_false_alarms

RATE = 20.0  # Hz
QUICK = Rule(allowance=0.5, threshold=4.0)  # alarms by chance often enough to be counted


def watch(residual, spread=1e-9, rule=None):
    test = Sequential(residual.shape[:-1], rule)
    for k in range(residual.shape[-1]):
        test.add(residual[..., k], np.full(residual.shape[:-1], spread), k / RATE)
    return test


def noise(shape, seed=0):
    return np.random.default_rng(seed).standard_normal(shape)


@settings(max_examples=20)
@given(st.floats(-3.0, 3.0), st.floats(1e-3, 1e3), st.integers(0, 1000))
def test_what_a_calibration_leaves_is_no_alarm_whatever_the_unit(bias, unit, seed):
    spread = unit / np.sqrt(RATE)  # a second's mean is as unsure by the model as by the noise
    residual = unit * noise((5, 1200), seed) + bias * spread
    assert not np.any(watch(residual, spread).alarm)


@pytest.mark.parametrize(('bias', 'direction'), [(2.0, 0), (-2.0, 1)])
def test_a_difference_is_noticed_soon_and_dated(bias, direction):
    begins = 30.0
    residual = noise((40, 1600))
    residual[:, int(begins * RATE) :] += bias
    test = watch(residual)
    assert np.all(test.alarm)
    assert np.median(test.alarmed_at - begins) <= 6.0
    assert np.all(np.abs(test.since - begins) <= 1.5)
    assert np.all(test.sums[direction] > test.sums[1 - direction])


@pytest.mark.parametrize('bias', [0.0, 0.25])
def test_the_stated_rate_of_false_alarms_is_the_true_one(bias):
    many = 2000
    spread = 1e-9
    residual = noise((many, 2000)) + bias / np.sqrt(RATE)
    test = watch(residual, spread, QUICK)
    expected = (residual.shape[1] / RATE) / 3600.0 / hours_between_false_alarms(QUICK, bias)
    found = -np.log(1.0 - np.mean(test.alarm))
    assert 0.5 < found / expected < 1.6


def test_the_usual_rule_alarms_less_than_once_in_300_hours_where_a_calibration_is_off_by_three_deviations():
    assert hours_between_false_alarms(Rule(), 3.0, channels=4) > 300.0


def test_a_hiccup_of_two_seconds_is_no_alarm_and_missing_samples_are_none():
    residual = noise((3, 2000))
    residual[0, 400:440] += 1e6
    residual[1, 500:900] = np.nan
    residual[2, :] = np.nan
    test = watch(residual)
    assert not np.any(test.alarm)
    assert test.noise[0] == pytest.approx(1.0, rel=0.35)
    assert test.noise[2] == 0.0


@given(st.integers(1, 6))
def test_channels_know_nothing_of_each_other(channels):
    residual = noise((channels, 1000))
    residual[-1] += 3.0
    one, all_of_them = watch(residual[-1:]), watch(residual)
    assert all_of_them.alarmed_at[-1] == one.alarmed_at[0]
    assert not np.any(all_of_them.alarm[:-1])


def test_what_is_forgotten_may_alarm_again_and_the_noise_is_still_known():
    residual = noise((1, 800))
    residual[:, 200:] += 2.0
    test = watch(residual)
    assert test.alarm[0]
    before = test.noise[0]
    test.forget()
    assert not test.alarm[0] and test.noise[0] == before
