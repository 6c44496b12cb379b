"""The noise of instruments that read an input, and which of several readings the source holds."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis import truth

from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.observation import prepare as prepare_module
from tcp_muscle_ros.diagnosis.observation.input_noise import noise_of, quiet, still_air, which_is_held
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.recording import Channel

NOMINAL = Parameters.named('karami_tadesse_2017')
TIME = np.arange(0.0, 300.0, 0.05)
STEPS = np.select([TIME % 70.0 < 25.0, TIME % 70.0 < 40.0], [0.24, 0.22], 0.015)
TRIANGLE = 0.28 * (1.0 - np.abs(TIME / 150.0 - 1.0))
SIGMA = 1.2e-4  # A
SEED = 4722  # of its own: the development suite is tuned on others


def read(values, sigma=SIGMA, name='current'):
    noise = sigma * np.random.default_rng(3).standard_normal(TIME.size)
    return Channel(name, TIME, values + noise, name)


def test_between_its_steps_a_noisy_input_is_its_mean_and_steps_where_it_stepped():
    found, sigma = quiet(read(STEPS))
    assert sigma == pytest.approx(SIGMA, rel=0.05)
    np.testing.assert_array_equal(np.diff(found.value) != 0.0, np.diff(STEPS) != 0.0)
    assert np.max(np.abs(found.value - STEPS)) < 4.0 * SIGMA / np.sqrt(280)


def test_a_ramp_keeps_its_slope_and_its_tip():
    found, _ = quiet(read(TRIANGLE))
    error = found.value - TRIANGLE
    assert np.std(error) < 0.35 * SIGMA
    assert np.quantile(np.abs(error), 0.99) < SIGMA
    assert np.max(np.abs(error)) < 5.0 * SIGMA


@pytest.mark.parametrize('sigma', [3e-5, 6e-5])
def test_the_last_digit_of_an_ammeter_flickers_and_heats_nothing(sigma):
    """Most readings are the same: the median of their changes is none."""
    flickering = replace(read(STEPS), value=np.round(read(STEPS, sigma).value, 4))
    found, taken = quiet(flickering)
    assert np.median(np.abs(np.diff(flickering.value, 2))) <= 1.1e-4
    assert sigma < taken < 1e-4
    np.testing.assert_array_equal(np.diff(found.value) != 0.0, np.diff(STEPS) != 0.0)
    assert np.max(np.abs(found.value - STEPS)) < 2e-5


def test_a_ramp_of_commands_in_whole_digits_is_no_noise():
    stairs = Channel('current', TIME, np.round(TRIANGLE, 3), 'current')
    assert quiet(stairs) == (stairs, 0.0)


SLOWLY = np.arange(0.0, 350.0, 2.0)
RELAXING = 296.0 + 1.5 * (1.0 - np.exp(-SLOWLY / 150.0))


def room(values):
    return Channel('ambient', SLOWLY, values, 'ambient_temperature')


@pytest.mark.parametrize(('step', 'noise'), [(0.1, 0.04), (0.1, 0.0), (0.0, 0.05)], ids=['both', 'steps', 'noise'])
def test_air_does_not_change_by_what_its_thermometer_adds(step, noise):
    read_as = RELAXING + noise * np.random.default_rng(8).standard_normal(SLOWLY.size)
    read_as = np.round(read_as / step) * step if step else read_as
    found, unsure = still_air(room(read_as))
    left = np.sqrt(np.mean((found.value - RELAXING) ** 2))
    assert left < 0.5 * np.sqrt(np.mean((read_as - RELAXING) ** 2))
    assert 0.2 * unsure < left < 2.0 * unsure


@pytest.mark.parametrize(
    'exact',
    [RELAXING, np.full(SLOWLY.size, 296.0), np.where(SLOWLY > 100.0, 301.0, 296.0)],
    ids=['smooth', 'still', 'step'],
)
def test_an_exact_room_stays_bit_for_bit(exact):
    channel = room(exact)
    assert still_air(channel) == (channel, 0.0)


@pytest.mark.parametrize(
    'exact',
    [STEPS, TRIANGLE, 0.14 + 0.1 * np.sin(TIME / 9.0), np.where(np.arange(TIME.size) % 2 == 0, 0.2, 0.0)],
    ids=['steps', 'triangle', 'sine', 'switching at each sample'],
)
def test_what_is_exact_stays_bit_for_bit(exact):
    channel = Channel('current', TIME, exact, 'current')
    found, sigma = quiet(channel)
    assert sigma == 0.0
    assert found is channel


def test_a_zero_that_is_exact_and_a_coarse_reading_hide_no_noise():
    shown = np.where(STEPS > 0.1, np.round(read(STEPS).value, 4), 0.0)
    found, sigma = quiet(Channel('current', TIME, shown, 'current'))
    assert sigma == pytest.approx(SIGMA, rel=0.1)
    assert np.all(found.value[STEPS < 0.1] == 0.0)


def test_what_may_have_been_imposed_is_left():
    jitter = read(STEPS, sigma=0.02 * np.ptp(STEPS))
    assert quiet(jitter) == (jitter, 0.0)


def test_few_readings_say_nothing():
    few = replace(read(STEPS), time=TIME[:30], value=read(STEPS).value[:30])
    assert noise_of(few) == 0.0


@pytest.mark.parametrize('constant', [0, 1, 2])
def test_the_source_holds_what_is_constant_between_steps(constant):
    resistance = 13.0 + 2.0 * (1.0 - np.exp(-(TIME % 35.0) / 7.0))
    level = np.where(TIME % 70.0 < 35.0, 1.0, 0.01)
    power = {0: level**2 * resistance, 1: level, 2: level**2 / resistance}[constant]
    current = np.sqrt(power / resistance)
    readings = [read(v, 2e-4 * np.ptp(v)) for v in (current, power, current * resistance)]
    assert which_is_held(readings) == constant


@pytest.mark.parametrize('held', ['current', 'voltage'])
def test_a_voltage_that_was_logged_more_seldom_changes_more_seldom_whatever_is_held(held):
    """At 1 Hz beside a current at 20 Hz, as two instruments log them."""
    resistance = 13.0 + 2.0 * (1.0 - np.exp(-(TIME % 35.0) / 7.0))
    level = 0.15 + 0.1 * np.sin(TIME / 9.0) if held == 'current' else np.where(TIME % 70.0 < 35.0, 3.0, 0.1)
    current, voltage = (level, level * resistance) if held == 'current' else (level / resistance, level)
    power = read(current * voltage, 2e-4 * np.ptp(current * voltage))
    seldom = Channel('voltage', TIME[::20], read(voltage, 2e-3).value[::20], 'voltage')
    assert which_is_held([read(current), power, seldom]) == {'current': 0, 'voltage': 2}[held]


@pytest.fixture(scope='module')
def recordings(tmp_path_factory):
    def fine(case):
        finer = replace(case.noise['displacement'], sigma=1.5e-5, quantum=0.0, coloured=0.0, lost=0.0, bursts=0)
        case.noise.update(displacement=finer)

    return truth.recordings(tmp_path_factory.mktemp('truth'), 'development', SEED, 0, 'null', '', fine)[:2]


def metered(recording):
    current = recording['current']
    noise = 4e-4 * np.random.default_rng(5).standard_normal(len(current))
    shown = replace(current, value=current.value + noise)
    return replace(recording, channels={**recording.channels, 'current': shown})


def missed(recordings):
    fitted = calibrate([prepare(recording, NOMINAL, most=800) for recording in recordings], NOMINAL).fit
    return fitted.mean_square['displacement']


def test_what_an_ammeter_adds_is_no_heat(recordings, monkeypatch):
    exact, shown = missed(recordings), [metered(recording) for recording in recordings]
    quieted = missed(shown)
    assert 'the noise of the current was averaged out' in prepare(shown[0], NOMINAL).notes[-1]
    monkeypatch.setattr(prepare_module, 'quiet', lambda channel, span=None: (channel, 0.0))
    believed = missed(shown)
    assert believed > 1.5 * exact
    assert quieted - exact < 0.6 * (believed - exact)  # the mean of each level stays unsure


def test_a_controller_imposes_what_it_makes_of_its_sensors_noise(recordings):
    shown = metered(recordings[0])
    setpoint = Channel('displacement_setpoint', TIME[:2], np.array([0.0, 0.01]), 'setpoint')
    followed = replace(shown, channels={**shown.channels, 'displacement_setpoint': setpoint})
    drive = prepare(followed, NOMINAL).imposed.drive
    assert np.unique(drive).size > 0.9 * len(shown['current'])
