"""What the controller must show (offline, against the simulated muscle, with the nodes' timing)."""

from dataclasses import astuple
from math import inf, isfinite

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tcp_muscle_ros.control.inverse import Inverse
from tcp_muscle_ros.control.observer import Noise, Observer
from tcp_muscle_ros.control.offline import Sensors, run
from tcp_muscle_ros.control.setpoint import Slope
from tcp_muscle_ros.control.tracking import MODES, Command, Settings
from tcp_muscle_ros.control.watches import FeedbackWatch
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscle, Parameters, simulate
from tcp_muscle_ros.settings.operating import OPERATING
from tcp_muscle_ros.studies import control_study as study
from tcp_muscle_ros.studies.step_response import rms_error

MODEL = Parameters.named('karami_tadesse_2017')
STEPS = [(0.27, 0.020), (0.27, 0.040), (0.40, 0.020), (0.40, 0.040)]


def within(figures, factor):
    return figures.response.settling_time <= factor * figures.physical_time + study.PERIOD + 1e-9


# Steps


@pytest.mark.parametrize(('limit', 'target'), STEPS)
def test_heats_as_fast_as_the_muscle_can_and_stops_there(limit, target):
    figures = study.heating(MODEL, MODEL, limit, target)
    assert within(figures, 1.05)
    assert figures.response.overshoot < 0.02
    assert figures.response.steady_error < 1e-4


@pytest.mark.parametrize(('begin', 'end'), [(0.04, 0.0), (0.02, 0.0), (0.04, 0.02), (0.03, 0.025)])
def test_releases_as_fast_as_the_muscle_cools(begin, end):
    figures = study.release(MODEL, MODEL, begin, end, 0.4)
    assert within(figures, 1.05)
    assert figures.response.overshoot < 0.02
    assert figures.response.steady_error < 1e-4


@pytest.mark.parametrize(
    ('limit', 'target'), [pytest.param(*step, marks=pytest.mark.long if step[1] > 0.03 else ()) for step in STEPS]
)
def test_copes_with_muscles_that_are_not_the_model(limit, target):
    tried = 0
    for plant, factors in study.draws(MODEL, 20, seed=1):
        if study.reachable(plant, limit, target):
            figures = study.heating(plant, MODEL, limit, target)
            assert within(figures, 1.3), factors
            assert figures.response.overshoot < 0.05, factors
            assert figures.response.steady_error < 1e-4, factors
            tried += 1
    assert tried >= 10


@pytest.mark.parametrize('effect', ['creep', 'thermocouple_lag', 'resistance_strain', 'natural_convection'])
@pytest.mark.parametrize(('limit', 'target'), [(0.27, 0.040), (0.40, 0.020)])
def test_copes_with_physics_that_the_model_lacks(effect, limit, target):
    figures = study.heating(MODEL.with_effects(effect), MODEL, limit, target)
    assert within(figures, 1.3)
    assert figures.response.overshoot < 0.05
    assert figures.response.steady_error < 1e-4


@pytest.mark.parametrize('told', [True, False])
@pytest.mark.parametrize('extra', [0.3, -0.3])
def test_rejects_a_load_step(told, extra):
    figures = study.load_step(MODEL, MODEL, 0.02, extra, 0.27, told)
    assert figures.response.steady_error < 1e-4
    assert figures.response.overshoot < 0.02
    if extra > 0.0:
        assert within(figures, 1.05)


@pytest.mark.parametrize(('noise', 'ripple'), [(2e-5, 5e-3), (5e-5, 8e-3)])
def test_noise_of_the_sensor_hardly_reaches_the_current(noise, ripple):
    for limit, target in STEPS:
        figures = study.heating(MODEL, MODEL, limit, target, Sensors(displacement_noise=noise))
        assert within(figures, 1.05)
        assert figures.response.overshoot < 0.02
        assert figures.response.steady_error < 1e-4
        assert figures.response.ripple < ripple


def test_a_coarse_sensor_is_no_reason_to_chatter():
    figures = study.heating(MODEL, MODEL, 0.27, 0.02, Sensors(displacement_quantum=5e-5))
    assert within(figures, 1.05)
    assert figures.response.steady_error < 1e-4
    assert figures.response.ripple < 2e-3


@pytest.mark.parametrize('rate', [10.0, 50.0, 1000.0])
def test_works_at_other_rates(rate):
    period = 1.0 / rate
    controller = study.controller(MODEL, 0.27, period=period)
    happened = run(controller, Muscle(MODEL, load=study.LOAD), period, np.full(round(20.0 * rate), 0.02))
    physical = study.full_current_time(MODEL, 0.27, 0.02)
    inside = np.abs(happened.displacement - 0.02) <= 4e-4
    assert inside[happened.time >= 1.05 * physical + 3.0 * period].all()
    assert happened.displacement.max() < 0.0204


def test_follows_a_sine_without_lag():
    time = np.arange(0.0, 60.0, study.PERIOD)
    wanted = 0.025 + 0.005 * np.sin(2.0 * np.pi * time / 20.0)
    late = time > 15.0
    errors = {}
    for mode in ('model', 'pid'):
        happened = run(study.controller(MODEL, 0.27, mode=mode), Muscle(MODEL, load=study.LOAD), study.PERIOD, wanted)
        errors[mode] = rms_error(happened.displacement[late], wanted[late])
    assert errors['model'] < 2e-5
    assert errors['model'] < 0.2 * errors['pid']


def test_the_plain_pid_settles_too():
    for limit, target in STEPS:
        figures = study.heating(MODEL, MODEL, limit, target, mode='pid')
        assert figures.ratio < 1.5
        assert figures.response.overshoot < 0.02
        assert figures.response.steady_error < 1e-4


# On resistance alone


def test_closes_the_loop_on_resistance_alone():
    for limit, target in STEPS:
        figures = study.heating(MODEL, MODEL, limit, target, Sensors(feedback='resistance'))
        assert within(figures, 1.05)
        assert figures.response.steady_error < 1e-4


def test_coasts_while_no_current_shows_no_resistance():
    time = np.arange(0.0, 60.0, study.PERIOD)
    wanted = np.where(time < 20.0, 0.03, 0.01)
    sensors = Sensors(feedback='resistance', resistance_noise=0.01, least_sense_current=0.05)
    happened = run(study.controller(MODEL, 0.4), Muscle(MODEL, load=study.LOAD), study.PERIOD, wanted, sensors=sensors)
    assert happened.current.min() == 0.0
    assert np.abs(happened.displacement - wanted)[time > 50.0].max() < 2e-4


def test_probes_if_asked_to():
    controller = study.controller(MODEL, 0.27, probe_current=0.05)
    assert controller.update(0.0, applied_current=0.0).current == 0.05
    assert controller.update(0.0, displacement=0.0, applied_current=0.05).current == 0.0


# Limits


@pytest.mark.parametrize('told', [True, False])
def test_stays_below_the_temperature_limit(told):
    limit = 80.0 + ZERO_CELSIUS
    controller = study.controller(MODEL, 0.4, temperature_limit=limit)
    # Without a thermometer only the model knows; with one, a muscle that sheds less heat is held as well.
    plant = Muscle(MODEL.replace(hA=0.8 * MODEL['hA']) if told else MODEL, load=study.LOAD)
    reading, flowing, hottest, command = plant.reading(), 0.0, 0.0, None
    for _ in range(4000):
        command = controller.update(
            0.1,
            displacement=reading.displacement,
            temperature=reading.temperature if told else None,
            applied_current=flowing,
        )
        reading = plant.step(study.PERIOD, flowing)
        flowing = command.current
        hottest = max(hottest, reading.fibre_temperature)
    assert limit - 1.0 < hottest < limit + 0.2
    assert command.shaped_setpoint < 0.1


def test_says_how_far_the_muscle_can_follow():
    controller = study.controller(MODEL, 0.21)
    far = controller.update(0.06, displacement=0.0, applied_current=0.0).shaped_setpoint
    settled = simulate(MODEL, [0.0, 200.0], 0.21, load=study.LOAD).displacement[-1]
    assert far == pytest.approx(settled, rel=1e-3)
    assert controller.update(-0.01, displacement=0.0, applied_current=0.0).shaped_setpoint == pytest.approx(
        0.0, abs=1e-6
    )
    assert controller.update(0.02, displacement=0.0, applied_current=0.0).shaped_setpoint == 0.02


HEAVY = [(2.5, 0.31), (3.0, 0.27)]  # N and A: softening overtakes the contraction before 100 degC


def under_a_heavy_load(load, limit, share):
    """The last 10 s of a run to a share of the furthest, and the furthest (m)."""
    furthest = Inverse(MODEL, load).furthest(load)
    wanted = np.full(6000, share * furthest)
    sensors = Sensors(displacement_noise=1e-5)
    controller = study.controller(MODEL, limit, load=load)
    happened = run(controller, Muscle(MODEL, load=load), study.PERIOD, wanted, sensors=sensors)
    return happened.displacement[5000:], happened.shaped[-1], furthest


@pytest.mark.parametrize(('load', 'limit'), HEAVY)
@pytest.mark.parametrize('share', [0.97, 0.99])
def test_settles_near_the_furthest_under_a_heavy_load(load, limit, share):
    x, shaped, furthest = under_a_heavy_load(load, limit, share)
    assert shaped == share * furthest
    assert np.abs(x - shaped).max() < 5e-5


@pytest.mark.parametrize(('load', 'limit'), HEAVY)
def test_beyond_the_furthest_it_holds_what_it_can(load, limit):
    """A load may come when the setpoint is there already."""
    x, shaped, furthest = under_a_heavy_load(load, limit, 1.1)
    assert furthest - 1e-4 < shaped < furthest
    assert np.abs(x - shaped).max() < 5e-5


def perhaps(low, high):
    return st.none() | st.floats(low, high)


EVENT = st.tuples(st.floats(-0.2, 0.3), perhaps(-0.2, 0.3), perhaps(1.0, 100.0), perhaps(0.0, 0.5), perhaps(0.0, 20.0))


@settings(max_examples=40, deadline=None)
@given(st.lists(EVENT, max_size=60), st.sampled_from(MODES), st.floats(0.0, 1.0))
def test_whatever_is_measured_the_current_stays_within_its_limits(events, mode, limit):
    controller = study.controller(MODEL, limit, mode=mode, probe_current=0.02)
    for setpoint, displacement, resistance, applied, load in events:
        command = controller.update(
            setpoint, displacement=displacement, resistance=resistance, applied_current=applied, load=load
        )
        assert 0.0 <= command.current <= limit
        assert all(isfinite(value) for value in astuple(command))


# Start, reset, prediction


def test_starts_from_where_the_muscle_is():
    hot = Muscle(MODEL, load=study.LOAD, temperature=60.0 + ZERO_CELSIUS)
    x = hot.reading().displacement
    command = study.controller(MODEL, 0.27).update(x, displacement=x, applied_current=0.0)
    assert command.predicted_temperature == pytest.approx(60.0 + ZERO_CELSIUS, abs=0.01)
    assert command.predicted_displacement == pytest.approx(x, abs=1e-5)


@pytest.mark.parametrize('mode', ['model', 'pid'])
def test_reset_forgets_what_a_long_stop_has_taught(mode):
    controller = study.controller(MODEL, 0.27, mode=mode)
    for _ in range(500):  # asked for, but nothing flows: nothing may pile up
        controller.update(0.02, displacement=0.0, applied_current=0.0)
    controller.reset()
    muscle = Muscle(MODEL, load=study.LOAD)
    happened = run(controller, muscle, study.PERIOD, np.full(2000, 0.02))
    assert happened.displacement.max() < 0.0204


def test_a_current_that_was_not_given_does_not_wind_up():
    controller = study.controller(MODEL, 0.27)
    muscle, flowing = Muscle(MODEL, load=study.LOAD), 0.0
    reading, xs = muscle.reading(), []
    for k in range(4000):
        command = controller.update(0.03, displacement=reading.displacement, applied_current=flowing)
        reading = muscle.step(study.PERIOD, flowing)
        flowing = min(command.current, 0.15 if k < 2000 else 1.0)  # held down by someone else for 20 s
        xs.append(reading.displacement)
    assert max(xs) < 0.0306
    assert abs(xs[-1] - 0.03) < 1e-5


def test_the_prediction_knows_nothing_of_what_is_measured():
    def predictions(measured):
        controller = study.controller(MODEL, 0.27)
        first = controller.update(0.02, displacement=0.0, applied_current=0.0)
        rest = [controller.update(0.02, displacement=measured, applied_current=0.2) for _ in range(200)]
        return [c.predicted_displacement for c in (first, *rest)]

    assert predictions(0.0) == predictions(0.01)
    # The first 0.2 A was flowing when the second update came; the third is the first to see what it did.
    reference = simulate(MODEL, study.PERIOD * np.arange(200), 0.2, load=study.LOAD).displacement
    np.testing.assert_allclose(predictions(0.0)[1:], reference, atol=1e-12)


def watched(plant, target, duration, *, limit=0.27, feedback='displacement', quantum=0.0, frozen_after=inf):
    """When the watch first speaks, s, as the node asks it; None: never."""
    controller, muscle, flowing = study.controller(MODEL, limit), Muscle(plant, load=study.LOAD), 0.0
    step = max(quantum, 2e-5 if feedback == 'displacement' else 2e-3)
    watch, expected, shown = FeedbackWatch(feedback, 0.2, step), None, 0.0
    reading = muscle.reading()
    for k in range(round(duration / study.PERIOD)):
        now = k * study.PERIOD
        if now < frozen_after:
            shown = getattr(reading, feedback)
            shown = round(shown / quantum) * quantum if quantum else shown
        watch.receive(shown, now)
        if watch.problem(now, expected):
            return now
        command = controller.update(target(now), applied_current=flowing, **{feedback: shown})
        expected = command.expected_displacement if feedback == 'displacement' else command.expected_resistance
        reading = muscle.step(study.PERIOD, flowing)
        flowing = command.current
    return None


@pytest.mark.parametrize('limit', [0.27, 0.40])
@pytest.mark.parametrize(
    ('feedback', 'quantum'), [('displacement', 0.0), ('displacement', 5e-5), ('resistance', 0.0), ('resistance', 0.01)]
)
def test_a_muscle_at_rest_that_is_not_the_model_is_no_frozen_sensor(feedback, quantum, limit):
    for plant, _ in list(study.draws(MODEL, 20, seed=1))[:8]:
        if feedback == 'resistance':  # its own thermometer has to be calibrated
            plant = plant.replace(R0=MODEL['R0'], a_R=MODEL['a_R'])
        # Without noise what is measured at rest is the same to the last bit, and by the nominal model it should move.
        found = watched(
            plant, lambda t: 0.02 if t < 12.0 else 0.01, 30.0, limit=limit, feedback=feedback, quantum=quantum
        )
        assert found is None


@pytest.mark.parametrize(('frozen_after', 'within'), [(0.0, 0.1), (1.0, 0.1), (12.0, 0.2)])
def test_a_sensor_that_freezes_is_found_as_soon_as_the_muscle_must_move(frozen_after, within):
    found = watched(MODEL, lambda t: 0.02 if t < 12.0 else 0.03, 20.0, frozen_after=frozen_after)
    assert found is not None
    assert frozen_after <= found <= frozen_after + within


def test_without_any_sensor_it_coasts_on_the_model():
    controller = study.controller(MODEL, 0.27)
    muscle, current = Muscle(MODEL, load=study.LOAD), 0.0
    for _ in range(3000):
        reading = muscle.step(study.PERIOD, current)
        command = controller.update(0.02, applied_current=current)
        current = command.current
    assert reading.displacement == pytest.approx(0.02, abs=2e-4)


# Parts


def test_the_inverse_inverts():
    inverse = Inverse(MODEL, study.LOAD)
    for temperature in (290.0, 296.15, 330.0, 370.0):
        for load in (0.3, 0.588, 0.9):
            x = inverse.displacement(temperature, load)
            assert inverse.temperature(x, load) == pytest.approx(temperature, abs=1e-6)
    assert inverse.displacement(MODEL['T0'], study.LOAD) == 0.0
    # Beyond the domain it goes on, so that feedback still knows which way to go.
    assert inverse.temperature(-0.06, study.LOAD) < inverse.temperature(-0.05, study.LOAD) < ZERO_CELSIUS


def test_the_observer_steps_as_the_muscle_does():
    observer = Observer(MODEL, 0.5)
    observer.start(310.0)
    muscle = Muscle(MODEL, temperature=310.0)
    for current in (0.0, 0.3, 0.6782, 0.9):
        expected = muscle.step(0.5, current).fibre_temperature
        observer.predict(current, MODEL['T0'])
        assert observer.temperature == pytest.approx(expected, abs=1e-9)


def test_the_current_between_two_temperatures_leads_from_one_to_the_other():
    observer = Observer(MODEL, 0.01)
    for begin, end in ((300.0, 300.02), (350.0, 350.0), (330.0, 330.1)):
        current = observer.current_between(begin, end, MODEL['T0'])
        assert observer.after(begin, current, MODEL['T0']) == pytest.approx(end, abs=1e-6)
    assert observer.current_between(350.0, 340.0, MODEL['T0']) == 0.0


def test_noise_is_found_whatever_the_signal_does():
    chance = np.random.default_rng(5)
    for deviation in (0.01, 0.1):
        noise = Noise()
        for k in range(2000):
            noise.add(300.0 + 0.05 * k + (30.0 if k > 1000 else 0.0) + deviation * chance.standard_normal())
        assert noise.deviation == pytest.approx(deviation, rel=0.3)


def test_a_path_whose_points_come_unevenly_is_smooth():
    chance = np.random.default_rng(2)
    slope, due = Slope(0.01), 0.0
    speeds = []
    for k in range(500):  # 100 setpoints a second, each up to 10 ms late: some periods see two, some none
        due = max(due, 0.01 * k - 0.01 * chance.random())
        speeds.append(slope.update(0.02 * (due // 0.01) * 0.01))
    assert np.abs(np.array(speeds[50:]) - 0.02).max() < 0.003


def test_the_slope_of_a_path_and_of_a_step():
    slope = Slope(0.01)
    path = [slope.update(0.001 * (k // 5)) for k in range(100)]  # setpoints at 20 Hz, 20 mm/s
    assert path[-1] == pytest.approx(0.02)
    assert [slope.update(0.02) for _ in range(50)][-1] == 0.0
    assert slope.update(0.04) == 0.0
    assert slope.update(0.04) == 0.0


@pytest.mark.parametrize(
    ('change', 'says'),
    [
        ({'time_constnat': 0.1}, "did you mean 'time_constant'"),
        ({'mode': 'pdi'}, "did you mean 'pid'"),
        ({'time_constant': float('nan')}, 'time_constant'),
    ],
)
def test_a_wrong_setting_is_named(change, says):
    with pytest.raises(BadInput, match=says):
        study.controller(MODEL, 0.27, **change)


def test_a_command_is_immutable():
    with pytest.raises(AttributeError):
        Command(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0).current = 1.0


def test_the_nodes_parameters_have_these_defaults():
    given = Settings()
    same = {
        'mode': given.mode,
        'time_constant_s': given.time_constant,
        'probe_current_a': given.probe_current,
        'pid_kp_a_per_m': given.pid_kp,
        'pid_ki_a_per_m_s': given.pid_ki,
        'pid_kd_a_s_per_m': given.pid_kd,
        'pid_filter_time_s': given.pid_filter_time,
        'derate_temperature_c': given.temperature_limit - ZERO_CELSIUS,
    }
    assert {name: OPERATING[name].default for name in same} == same
