"""A draught, or a room that drifts, that goes its own way in every recording; and laws that are neither."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOISE, NOMINAL, TIME, TRUE, experiment, shown_with

from tcp_muscle_ros.diagnosis.answer.notes import on_draught
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.weather import Course, courses
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.search import weathered
from tcp_muscle_ros.diagnosis.search.remaining import unexplained
from tcp_muscle_ros.diagnosis.search.second_start import select_twice
from tcp_muscle_ros.diagnosis.search.weathered import with_weather
from tcp_muscle_ros.muscle import simulate

CHANNELS = ('temperature', 'resistance', 'displacement')
CURRENTS = (0.27, 0.22, 0.25)
CIRCUMSTANCES = ['airflow', 'ambient_drift']


def wander(seed, pace):
    """A course of size 1 that forgets itself at a pace (s)."""
    rng, kept = np.random.default_rng(seed), np.exp(-0.2 / pace)
    steps = np.sqrt(1.0 - kept**2) * rng.standard_normal(TIME.size)
    course = np.zeros(TIME.size)
    for k in range(1, TIME.size):
        course[k] = kept * course[k - 1] + steps[k]
    return course


def blowing(k):
    """Gusts of some seconds, as a room that takes as much heat (K)."""
    clean = experiment(CHANNELS, CURRENTS[k])
    excess = simulate(TRUE, TIME, clean.imposed.drive, kind='current', load=0.588).temperature - NOMINAL['T0']
    return -0.3 * wander(k, 4.0) * excess


def drifting(k):
    """A room that wanders by a kelvin within a minute."""
    return wander(10 + k, 30.0)


def still(k):
    """A room that stays as it is."""
    return np.zeros(TIME.size)


def recorded_in(weather, muscle=TRUE):
    """Three recordings in a weather that their thermometers do not show."""
    return [
        experiment(CHANNELS, current, seed=50 + k, muscle=muscle, ambient=NOMINAL['T0'] + weather(k))
        for k, current in enumerate(CURRENTS)
    ]


def calibrated(runs):
    return in_turn(calibrate(runs, NOMINAL).fit)


@pytest.mark.long
@pytest.mark.parametrize(('weather', 'effect'), [(blowing, 'airflow'), (drifting, 'ambient_drift')])
def test_what_goes_its_own_way_is_named_by_its_course_and_taken_out(weather, effect):
    bare = calibrated(recorded_in(weather))
    found = with_weather(select_twice(bare, ['creep']), ['creep', *CIRCUMSTANCES])
    assert [c.effect for c in found.chosen] == [effect]
    assert unexplained(found.told) is None
    had, left = bare.mean_square, found.told.final.mean_square
    assert all(left[name] < max(0.02 * had[name], 1.2 * sigma**2) for name, sigma in NOISE.items())


@pytest.mark.long
@pytest.mark.parametrize(('weather', 'effect'), [(blowing, 'airflow'), (drifting, 'ambient_drift')])
def test_a_single_recording_has_a_weather_too(weather, effect):
    bare = calibrated(recorded_in(weather)[:1])
    found = with_weather(select_twice(bare, []), CIRCUMSTANCES)
    assert [c.effect for c in found.chosen] == [effect]


@pytest.mark.long
@pytest.mark.parametrize('law', ['natural_convection', 'two_node', 'hysteresis'])
def test_a_law_that_is_not_listed_is_no_weather_of_a_single_recording(law):
    found = select_twice(calibrated(recorded_in(still, TRUE.with_effects(law))[:1]), [])
    assert with_weather(found, CIRCUMSTANCES) is found


@pytest.mark.long
def test_what_it_hid_is_found_beside_it_and_what_was_named_before_stays():
    """A resistance that bends is hidden, friction is not, in the air of a room that drifts."""
    muscle = TRUE.replace({'tcr_curvature.b': -8e-6}).with_effects('friction', 'tcr_curvature')
    runs = recorded_in(drifting, muscle)
    first = select_twice(calibrated(runs), ['friction'])
    assert [c.effect for c in first.chosen] == ['friction']
    found = with_weather(first, ['friction', 'tcr_curvature', 'creep', *CIRCUMSTANCES])
    assert {c.effect for c in found.chosen} == {'ambient_drift', 'friction', 'tcr_curvature'}
    assert any('the room went its own way' in note for note in on_draught(found))


def unsteady(k):
    """A supply whose power wanders by a tenth, as a room that gives as much heat (K)."""
    drive = experiment(CHANNELS, CURRENTS[k]).imposed.drive
    return 0.1 * wander(20 + k, 6.0) * drive**2 * TRUE['R0'] / TRUE['hA']


@pytest.mark.long
def test_an_unsteady_supply_is_no_weather():
    found = select_twice(calibrated(recorded_in(unsteady)), [])
    assert with_weather(found, CIRCUMSTANCES) is found
    evidence = {course.effect: course.evidence for course in courses(found.final)}
    assert evidence[''] > max(0.998 * evidence['airflow'], evidence['ambient_drift'], 1000.0)


def gusts(seed):
    """A draught of up to two fifths of the loss of heat that begins and ends at once, for some tens of seconds."""
    rng, course, begin = np.random.default_rng(seed), np.zeros(TIME.size), 0.0
    while begin < TIME[-1]:
        begin += rng.exponential(40.0)
        lasts = rng.uniform(10.0, 60.0)
        course[(begin <= TIME) & (begin + lasts > TIME)] = 0.4 * rng.uniform(0.5, 1.0)
        begin += lasts
    return course


@pytest.mark.long
@pytest.mark.parametrize('of_the_air', [True, False])
def test_gusts_that_fall_into_long_heating_are_told_from_a_supply_by_what_it_leaves(of_the_air):
    """Hot for minutes, both explain all but a thousandth of a misfit of many times the noise: what the course of a
    supply leaves, where the muscle cools in a gust, tells."""
    runs = []
    for k, current in enumerate((0.27, 0.22)):
        drive = np.where(np.mod(TIME, 140.0) < 115.0, current, 0.0)
        excess = simulate(TRUE, TIME, drive, kind='current', load=0.588).temperature - NOMINAL['T0']
        heat = -excess if of_the_air else drive**2 * TRUE['R0'] / TRUE['hA']
        room = NOMINAL['T0'] + gusts(11 + k) * heat
        runs.append(experiment(CHANNELS, drive=drive, seed=50 + k, ambient=room))
    found = select_twice(calibrated(runs), [])
    evidence = {course.effect: course.evidence for course in courses(found.final)}
    assert evidence[''] > 0.998 * evidence['airflow']
    named = [c.effect for c in with_weather(found, CIRCUMSTANCES).chosen]
    assert named == (['airflow'] if of_the_air else [])


@pytest.mark.long
@pytest.mark.parametrize('effect', ['natural_convection', 'hysteresis', 'tcr_curvature'])
def test_a_law_that_is_not_listed_is_no_weather(effect):
    """Heat that goes with the muscle's state is foretold; what one channel misses the others deny."""
    strong = {'natural_convection': {'natural_convection.n': 0.3}}.get(effect, {})
    runs = recorded_in(still, TRUE.replace(strong).with_effects(effect))
    found = select_twice(calibrated(runs), [])
    assert with_weather(found, CIRCUMSTANCES) is found


@pytest.mark.parametrize(('evidence', 'plain'), [(980.0, True), (999.0, False)])
def test_what_a_law_would_foretell_counts_as_far_as_it_is_as_likely(evidence, plain):
    """The course of a draught is not foretold; told as a room it is, for it takes the more heat the hotter it is."""
    draught = Course('airflow', 1000.0, 900.0, 0.9, 0.1)
    room = Course('ambient_drift', evidence, 800.0, 0.9, 0.4)
    assert weathered._plain([draught, room], 200.0) is plain
    assert not weathered._plain([room], 200.0)


@pytest.mark.long
def test_a_laser_that_wanders_is_no_weather():
    """A room that moves the stroke alone: by hundredths of a kelvin, which no other channel shows."""
    courses_of = [2e-4 * wander(30 + k, 30.0) for k in range(len(CURRENTS))]
    runs = [
        shown_with(run, lambda t, course=course: np.interp(t, TIME, course))
        for run, course in zip(recorded_in(still), courses_of, strict=True)
    ]
    base, _ = settle_noise(calibrated(runs))
    likely = {course.effect: course for course in courses(base)}
    assert likely['ambient_drift'].evidence > 1000.0
    assert likely['ambient_drift'].witnessed < 0.0
    found = select_twice(calibrated(runs), [])
    assert with_weather(found, CIRCUMSTANCES) is found


@pytest.mark.parametrize('heated', [20.0, 0.6])
def test_a_muscle_that_is_heated_but_once_has_courses_too(heated):
    """For most of the recording, or between two knots, there is no power that a supply could have missed."""
    drive = np.where(np.abs(TIME - 1.0 - 0.5 * heated) < 0.5 * heated, 0.27, 0.0)
    fitted, _ = settle_noise(calibrated([experiment(CHANNELS, drive=drive)]))
    assert all(np.isfinite([course.evidence, course.foretold]).all() for course in courses(fitted))


def test_where_nothing_is_missed_there_is_no_course():
    fitted, _ = settle_noise(calibrated(recorded_in(still)))
    assert all(course.evidence < 0.0 for course in courses(fitted))
    only = {'displacement': fitted.problem.experiments[0].observed['displacement']}
    one = calibrated([replace(fitted.problem.experiments[0], observed=only)])
    assert courses(one) == []
