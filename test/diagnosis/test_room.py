"""What a warmer room does to a recording, and what the instruments may have missed without a name for it."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.draught import with_course, without_course
from tcp_muscle_ros.diagnosis.fitting.generic import hats
from tcp_muscle_ros.diagnosis.fitting.room import as_well_as_read, knots_of, responses
from tcp_muscle_ros.diagnosis.hypothesis.latents import Draught, Latent
from tcp_muscle_ros.muscle import simulate

CHANNELS = ('temperature', 'resistance', 'displacement')
QUIET = 5e-6  # m: a laser's noise


@pytest.fixture(scope='module')
def fitted():
    return calibrate([experiment(CHANNELS)], NOMINAL).fit


def in_a_room(ambient, seed=0, delay=0.0):
    """A recording in a room that its thermometer did not follow, by a laser that may be late."""
    clean = experiment(CHANNELS, seed=seed)
    out = simulate(TRUE, TIME, clean.imposed.drive, kind='current', load=clean.imposed.load, ambient=ambient)
    stroke = np.interp(TIME - delay, TIME, out.displacement)
    stroke = stroke + QUIET * np.random.default_rng(seed).standard_normal(TIME.size)
    observed = {**clean.observed, 'displacement': replace(clean.observed['displacement'], value=stroke)}
    return replace(clean, observed=observed)


def test_the_responses_to_a_warmer_room_are_those_of_the_model(fitted):
    experiment_, values = fitted.problem.experiments[0], fitted.values
    knots = knots_of(experiment_, 4.0, 400)
    shown = responses(fitted, 0, knots)
    course = 0.3 * np.sin(knots / 20.0)
    blown = Latent(draught=Draught(knots, hats(TIME, knots) @ course))
    expected = fitted.problem.with_latents([blown]).predict(values, 0)
    for name in CHANNELS:
        change = expected[name] - fitted.predictions[0][name]
        np.testing.assert_allclose(shown[name] @ course, change, atol=0.02 * np.max(np.abs(change)))


@pytest.mark.parametrize('missed', ['room', 'instant'])
def test_what_the_instruments_do_not_tell_is_no_misfit(missed):
    """Two hundredths of a kelvin, or eight milliseconds, that a laser shows."""
    wander = 0.02 * np.sin(TIME / 17.0) if missed == 'room' else np.zeros(TIME.size)
    run = in_a_room(NOMINAL['T0'] + wander, delay=0.008 if missed == 'instant' else 0.0)
    run = replace(run, imposed=replace(run.imposed, unsure=0.02 if missed == 'room' else 0.0))
    plain = calibrate([run], NOMINAL).fit
    allowed = as_well_as_read(plain)
    before, after = (np.std(mine.weighed[0]['displacement']) for mine in (plain, allowed))
    assert before > 1.3 * QUIET
    assert after < 1.15 * QUIET


def wandering(seed):
    """A room that goes its own way by a tenth of a kelvin."""
    return 0.1 * np.cumsum(np.random.default_rng(seed).standard_normal(TIME.size)) / np.sqrt(TIME.size)


def warming(seed):
    """A room that warms, or cools, by a kelvin and a half."""
    return 1.5 * (-1.0) ** seed * TIME / TIME[-1]


@pytest.mark.long
@pytest.mark.parametrize(('goes', 'named'), [(wandering, ()), (warming, ('ambient_drift',))])
def test_a_room_that_nobody_read_is_named_where_it_goes_farther_than_rooms_do(goes, named):
    runs = []
    for seed, load in enumerate((0.4, 0.8)):
        run = experiment(CHANNELS, load=load, seed=seed, ambient=NOMINAL['T0'] + goes(seed))
        runs.append(replace(run, imposed=replace(run.imposed, unread=True)))
    assert tuple(f.effect for f in diagnose(runs, NOMINAL).findings) == named


def test_the_course_of_gusts_fits_to_the_noise_and_is_taken_back():
    """Gusts that come and go within a second, forty of them: more than any one gust tells."""
    clean = experiment(CHANNELS)
    blowing = np.repeat(np.random.default_rng(12).random(42) < 0.5, 25)[: TIME.size]
    excess = simulate(TRUE, TIME, clean.imposed.drive, kind='current', load=clean.imposed.load).fibre_temperature
    ambient = NOMINAL['T0'] - 0.4 * blowing * (excess - NOMINAL['T0'])
    run = in_a_room(ambient)
    heated = simulate(TRUE, TIME, clean.imposed.drive, kind='current', load=clean.imposed.load, ambient=ambient)
    noise = 0.2 * np.random.default_rng(1).standard_normal(TIME.size)
    seen = {**run.observed, 'temperature': replace(run.observed['temperature'], value=heated.temperature + noise)}
    seen.pop('resistance')
    plain = calibrate([replace(run, observed=seen)], NOMINAL).fit
    blown = with_course(plain, ['airflow'])
    assert plain.mean_square['temperature'] > 25.0 * 0.2**2
    assert blown.mean_square['temperature'] < 1.3 * 0.2**2
    assert without_course(blown).mean_square['temperature'] == pytest.approx(plain.mean_square['temperature'], rel=0.05)
