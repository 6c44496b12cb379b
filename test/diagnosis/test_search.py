"""The search for an effect, piece by piece: screening, choices, what is kept back, and what a wrong form does."""

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.sentences import finding_sentence
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.sandwich import inflation
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import effect_unknowns
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, screen, variants
from tcp_muscle_ros.diagnosis.search.holdout import confirmation
from tcp_muscle_ros.diagnosis.search.refitting import grow, rivals_for
from tcp_muscle_ros.diagnosis.search.rivals import Rival, begins

CHANNELS = ('temperature', 'resistance', 'displacement')
LOADS = np.select([np.mod(TIME, 70.0) < 20.0, np.mod(TIME, 70.0) < 45.0], [0.3, 1.2], 0.6)


def calibrated(muscle, loads=(0.3, LOADS, 0.98)):
    runs = [experiment(CHANNELS, 0.27, load, k, muscle=muscle) for k, load in enumerate(loads)]
    return settle_noise(calibrate(runs, NOMINAL).fit)[0]


def test_an_effect_far_weaker_than_usual_is_seen_by_the_screening():
    """From the usual strength alone, the straight line to nothing misses what bends on the way."""
    fitted = calibrated(TRUE.replace({'exposed_area.e': 0.1}).with_effects('exposed_area'))
    ranked, _ = screen(fitted, ['exposed_area', 'creep', 'heat_capacity', 'friction'])
    assert ranked[0].effect == 'exposed_area'
    grown = grow(fitted, ranked[0], 20)
    assert grown.muscle['exposed_area.e'] == pytest.approx(0.1, abs=0.02)
    assert ranked[0].gain > 0.5 * (fitted.objective - grown.objective)


@pytest.mark.filterwarnings('ignore::RuntimeWarning')
def test_a_start_from_which_the_model_runs_away_is_none():
    """Less resistance where it is longer: the shorter, the more it heats, and so on."""
    runaway = Candidate('resistance_strain', {'resistance_strain.GF': -3.0}, 1.0, 1.0)
    warm, hot = (calibrate([experiment(CHANNELS, current, 0.3)], NOMINAL).fit for current in (0.27, 0.5))
    grown = grow(warm, runaway, 20)
    assert grown.muscle['resistance_strain.GF'] > -0.5  # back from there
    assert grown.misfit < warm.misfit
    assert grow(hot, runaway, 20) is None
    assert rivals_for(hot, [runaway], None) == []


@pytest.mark.parametrize(('blows', 'there'), [(0.3, True), (0.0, False)])
def test_a_gust_in_a_muscle_that_nothing_heated_is_none(blows, there):
    """It changes nothing there, so that recording fixes no strength of it, however large the one it begins with."""
    gust = {'airflow.g': blows, 'airflow.t1': 60.0, 'airflow.d': 60.0}
    blown = TRUE.replace(gust).with_effects('airflow') if blows else TRUE
    runs = [experiment(CHANNELS, 0.27, 0.588, 0, muscle=blown), experiment(CHANNELS, 0.0, 0.588, 1)]
    fitted = settle_noise(calibrate(runs, NOMINAL).fit)[0]
    each = tuple({**gust, 'airflow.g': g} for g in (0.01, 0.3))
    grown = grow(fitted, Candidate('airflow', each[0], 1.0, 1.0, each), 20)
    assert begins(Rival('airflow', grown, 0.0)) is there


@pytest.mark.parametrize('duration', [4.0, 2e5])
def test_what_is_as_long_as_a_recording_stays_within_its_bounds(duration):
    for effect in ('ambient_drift', 'displacement_drift'):
        for values in variants(TCP_MUSCLE, effect, duration):
            assert NOMINAL.replace(values)


def test_a_choice_is_tried_and_never_fitted():
    tried = variants(TCP_MUSCLE, 'clock_skew', 210.0)
    assert {values['clock_skew.channel'] for values in tried} == {0.0, 1.0, 2.0, 3.0}
    late = TRUE.replace({'clock_skew.d': 0.4, 'clock_skew.channel': 1.0}).with_effects('clock_skew')
    assert [u.name for u in effect_unknowns(TCP_MUSCLE, 'clock_skew', late)] == ['clock_skew.d', 'clock_skew.r']
    fitted = calibrated(late)
    ranked, _ = screen(fitted, ['clock_skew', 'inertia', 'two_node', 'friction'])
    found = rivals_for(fitted, ranked, None)[0].fit
    assert ranked[0].effect == 'clock_skew'
    assert found.muscle['clock_skew.channel'] == 1.0
    # A delay and a pace trade: 0.4 s on average over the recordings.
    mean = found.muscle['clock_skew.d'] + found.muscle['clock_skew.r'] * 0.5 * TIME[-1]
    assert mean == pytest.approx(0.4, abs=0.1)


@pytest.mark.long
def test_a_resistance_that_drifts_on_from_recording_to_recording_is_told_from_one_that_begins_anew():
    drift = {'resistance_drift.r': 1e-4, 'resistance_drift.course': 1.0}
    for used, course in ((TIME[-1], 1.0), (0.0, 0.0)):
        muscles = [TRUE.replace({**drift, 'resistance_drift.w0': k * used}) for k in range(2)]
        runs = [
            experiment(CHANNELS, seed=k, muscle=muscle.with_effects('resistance_drift'))
            for k, muscle in enumerate(muscles)
        ]
        fitted = settle_noise(in_turn(calibrate(runs, NOMINAL).fit))[0]
        ranked, _ = screen(fitted, ['resistance_drift', 'temperature_offset', 'airflow'])
        found = rivals_for(fitted, ranked, None)[0]
        assert found.effect == 'resistance_drift'
        assert found.fit.muscle['resistance_drift.course'] == course
        assert found.fit.muscle['resistance_drift.r'] == pytest.approx(1e-4, rel=0.1)


def test_a_drift_shows_in_stretches_that_are_kept_back():
    """With a zero of its own every stretch would hide it."""
    muscle = TRUE.with_effects('viscous_flow')
    fitted = calibrated(muscle, (0.588, 0.588))
    ranked, _ = screen(fitted, ['viscous_flow', 'friction'])
    grown = grow(fitted, ranked[0], 20)
    gain, kept_back = confirmation(fitted, grown)
    assert all(fold.whole is None for fold in kept_back)
    assert ranked[0].effect == 'viscous_flow'
    assert gain.holds


def test_intervals_widen_where_the_same_is_missed_in_the_same_state_each_time():
    rng = np.random.default_rng(1)
    state = np.tile(np.repeat(np.arange(12), 50), 6)
    jacobian = np.column_stack([np.cos(state), np.ones(state.size)])
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    noise = rng.standard_normal(state.size)
    missed = noise + 0.5 * np.sin(2.1 * state)
    assert np.all(inflation(covariance, jacobian, noise, [state]) < 1.6)
    assert np.all(inflation(covariance, jacobian, missed, [state]) > 2.0)


def test_a_finding_names_the_channel_that_is_late():
    from tcp_muscle_ros.diagnosis.answer.findings import Value

    values = {'d': Value(0.4, 0.35, 0.45, 's'), 'channel': Value(1.0, 1.0, 1.0, '1')}
    said = finding_sentence('clock_skew', values, ())
    assert said == 'The recordings show clock skew: d = 0.40 (0.35 to 0.45) s, channel = displacement.'


@pytest.mark.parametrize('loads', [(0.3, 0.588, 0.98), pytest.param((0.588, 0.588), marks=pytest.mark.long)])
def test_a_modulus_that_falls_at_a_temperature_of_its_own_is_told_from_one_that_follows_e(loads):
    """Under one load the muscle makes up for it by becoming as stiff as a rod, where nothing softens any more."""
    step = {'shear_softening.b': 0.2, 'shear_softening.Tg': 318.0, 'shear_softening.w': 4.0}
    softened = TRUE.replace({**step, 'shear_softening.where': 1.0}).with_effects('shear_softening')
    fitted = calibrated(softened, loads)
    assert (fitted.muscle['k0'] > 10.0 * TRUE['k0']) is (len(set(loads)) == 1)
    ranked, _ = screen(fitted, ['shear_softening', 'cte_kink', 'coil_contact', 'two_node'])
    found = rivals_for(fitted, ranked, None)[0]
    assert found.effect == 'shear_softening'
    assert [u.name for u in effect_unknowns(TCP_MUSCLE, 'shear_softening', softened)] == list(step)
    assert {name: found.fit.muscle[name] for name in step} == pytest.approx(step, rel=0.1)
    assert found.fit.muscle['k0'] == pytest.approx(TRUE['k0'], rel=0.1)


def test_what_freezes_far_below_where_it_melts_is_found():
    """From none the fit goes to a narrow band without any, and stays there."""
    melts = {'latent_heat.c': 0.06, 'latent_heat.Tm': 330.0, 'latent_heat.w': 6.0, 'latent_heat.u': 30.0}
    fitted = calibrated(TRUE.replace(melts).with_effects('latent_heat'))
    ranked, _ = screen(fitted, ['latent_heat', 'moisture', 'heat_capacity', 'two_node'])
    found = rivals_for(fitted, ranked, None)[0]
    assert found.effect == 'latent_heat'
    assert {name: found.fit.muscle[name] for name in melts} == pytest.approx(melts, rel=0.05)
