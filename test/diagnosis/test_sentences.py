"""The sentences of a report state numbers, and these are so."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.conclusions import likely_to_decide, would_help
from tcp_muscle_ros.diagnosis.answer.findings import (
    Change,
    ChannelFit,
    Finding,
    FreeLaw,
    Proposal,
    RunToRun,
    Sticking,
    Value,
)
from tcp_muscle_ros.diagnosis.answer.notes import on_one_load, on_unanchored
from tcp_muscle_ros.diagnosis.answer.repeating import said_of_runs
from tcp_muscle_ros.diagnosis.answer.sentences import finding_sentence, free_sentence, headline, with_sticking
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.diagnosis.fitting.generic import Structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import base_unknowns
from tcp_muscle_ros.diagnosis.noise.noise import Noise, quick_noise
from tcp_muscle_ros.diagnosis.search.location import Unexplained, locate
from tcp_muscle_ros.muscle import simulate
from tcp_muscle_ros.report.terminal import summary
from tcp_muscle_ros.report.words import range_text

FINDING = Finding('creep', 'mechanical', '', '', {'creep.J': Value(0.3, 0.2, 0.4, '1')}, 0.9, (), {}, 100.0)


def located(*shifts):
    """Where temperatures that are off by these (K), one a recording, are located; and what is missed there."""
    runs = [experiment(('temperature',), seed=k, muscle=TRUE) for k in range(len(shifts))]
    for run, shift in zip(runs, shifts, strict=True):
        run.observed['temperature'].value[:] += shift
    fitted = fit(Problem(tuple(runs), TRUE, (), quick_noise(runs)), np.zeros(0), rounds=0)
    smooth = [np.full_like(run.observed['temperature'].time, shift) for run, shift in zip(runs, shifts, strict=True)]
    structure = Structure(Noise(0.2), 1.0, 100.0, 1, tuple(smooth), True)
    return locate(fitted, {'temperature': structure}, 'temperature')


@pytest.mark.parametrize('hot', [True, False])
def test_the_headline_points_to_where_the_misfit_is_largest_and_not_to_where_the_time_was_spent(hot):
    """0.5 K are missed in 5 s in which the muscle is hottest (or hardly warm), 0.1 K in 205 s else: in sum, more."""
    drive = np.where(TIME < 5.0, 0.0, np.where(TIME < 25.0, 0.27, 0.05))
    run = experiment(('temperature',), drive=drive, muscle=TRUE)
    at = run.observed['temperature']
    warm = np.interp(TIME, TIME, simulate(TRUE, TIME, drive).fibre_temperature)
    there = (TIME > 20.0) & (TIME < 25.0) if hot else (TIME > 7.0) & (TIME < 12.0)
    missed = np.where(there, 0.5, 0.1)
    assert np.sum(missed[there] ** 2) < np.sum(missed[~there] ** 2)
    at.value[:] += missed
    fitted = fit(Problem((run,), TRUE, (), quick_noise([run])), np.zeros(0), rounds=0)
    place = locate(fitted, {'temperature': Structure(Noise(0.2), 1.0, 100.0, 1, (missed,), True)}, 'temperature')
    (range_,) = place.drivers
    inside = (warm >= range_.low) & (warm <= range_.high)
    assert np.mean(inside[there]) > 0.6 and np.mean(inside[~there]) < 0.2
    assert range_.share == pytest.approx(np.sum(missed[inside] ** 2) / np.sum(missed**2), rel=0.05)
    assert place.phases == ('heating',)
    assert 'while heating, the recorded temperature is on average 0.' in told(place)


@pytest.mark.parametrize(('channels', 'known'), [(('displacement',), False), (('displacement', 'temperature'), True)])
def test_no_temperature_is_named_where_the_recordings_do_not_say_how_hot_the_muscle_was(channels, known):
    """Forty times the heat exchange, capacity and gain: it moves alike, and hardly warms."""
    cold = TRUE.replace({name: 40.0 * TRUE[name] for name in ('hA', 'C', 'B')})
    run = experiment(channels, 0.6, kind='power', muscle=cold)
    unknowns = [u for u in base_unknowns([run], cold, {}) if u.name in ('hA', 'C', 'B')]
    fitted = fit(
        Problem((run,), cold, tuple(unknowns), quick_noise([run])), np.log([cold['hA'], cold['C'], cold['B']]), rounds=0
    )
    gone = run.observed['displacement'].value
    missed = np.where(gone > 0.8 * gone.max(), 1e-3, 1e-5)
    place = locate(fitted, {'displacement': Structure(Noise(5e-5), 1.0, 100.0, 1, (missed,), True)}, 'displacement')
    said = told(place)
    assert ('degC' in said) == known and ('% of the range of the stroke' in said) != known
    assert bool(on_unanchored(fitted)) != known
    if not known:
        (range_, *_) = place.drivers
        assert 0.7 < range_.low < range_.high <= 1.0
        assert range_text(range_).startswith('share of the range of the displacement 0.')


def test_a_muscle_that_cools_under_a_small_current_is_not_said_to_heat():
    """0.05 A, that keep the resistance readable, are on: what is missed there is missed while cooling."""
    run = experiment(('temperature',), drive=np.where(TIME < 25.0, 0.27, 0.05), muscle=TRUE)
    missed = np.where((TIME > 29.0) & (TIME < 40.0), 0.5, 0.02)
    run.observed['temperature'].value[:] += missed
    fitted = fit(Problem((run,), TRUE, (), quick_noise([run])), np.zeros(0), rounds=0)
    place = locate(fitted, {'temperature': Structure(Noise(0.2), 1.0, 100.0, 1, (missed,), True)}, 'temperature')
    assert place.phases == ('cooling',)


def told(location, **more):
    fits = {'temperature': ChannelFit(1.0, 0.5, 0.1, 0.1, Change(0.6, 0.2))}
    return headline('missing_physics', [FINDING], location, {**fits, **more}, None)


@pytest.mark.parametrize(
    ('tried', 'said', 'not_said'), [(True, 'effect explains', 'was tried'), (False, 'effect was tried on', 'explains')]
)
def test_the_headline_says_where_nothing_was_tried(tried, said, not_said):
    place = located(0.5, 0.3)
    left = Unexplained('thermal', 'temperature', 0.9, 'temperature', 300.0, 320.0, (0, 1.0, 2.0))
    runs = RunToRun({'temperature': 0.1}, 'temperature', 0.02, 0.03, 0.1)
    for told in (
        headline('unexplained', [], place, {}, left, tried=tried),
        headline('unexplained', [], None, {}, left, tried=tried),
        said_of_runs(runs, tried),
    ):
        assert f'No listed {said}' in told and not_said not in told


def test_what_is_more_likely_absent_than_there_may_be_lacking():
    place, fits = located(0.5, 0.3), {'temperature': ChannelFit(1.0, 0.5, 0.1, 0.1, Change(0.6, 0.2))}
    for probability, said in ((0.9, 'The simulation lacks creep;'), (0.4, 'The simulation may lack creep;')):
        assert said in headline('missing_physics', [replace(FINDING, probability=probability)], place, fits, None)
    second = replace(FINDING, effect='slack', probability=0.3)  # needed, though more likely absent than there
    both = headline('missing_physics', [FINDING, second], place, fits, None)
    assert 'The simulation lacks creep and may lack slack;' in both
    third = replace(second, effect='friction')
    assert 'lacks creep and may lack slack and friction' in headline(
        'missing_physics', [FINDING, second, third], place, fits, None
    )
    adds = [replace(f, stage='sensor') for f in (FINDING, second)]
    assert 'The sensors add creep and may add slack;' in headline('sensor_or_setup', adds, place, fits, None)
    law = FreeLaw('temperature', 'W/K', np.arange(2.0), np.arange(2.0), np.arange(2.0), np.arange(2.0), None)
    assert 'a law without a name may: ' in free_sentence('free_conductance', law, 0.4)
    assert 'a law without a name does: ' in free_sentence('free_conductance', law, 0.6)
    values = {'c': Value(0.3, 0.2, 0.4, '1')}
    assert finding_sentence('heat_capacity', values, (), 0.4).startswith('The recordings may show heat capacity')
    assert finding_sentence('heat_capacity', values, (), 0.6).startswith('The recordings show heat capacity')


def test_a_room_that_drifts_is_not_said_to_be_physics_that_the_muscle_lacks():
    place, fits = located(0.5, 0.3), {'temperature': ChannelFit(1.0, 0.5, 0.1, 0.1, Change(0.6, 0.2))}
    room = replace(FINDING, effect='ambient_drift', stage='thermal')
    alone = headline('missing_physics', [room], place, fits, None)
    assert 'The recordings have ambient drift, of the room and not of the muscle; with it the error' in alone
    both = headline('missing_physics', [room, FINDING], place, fits, None)
    assert (
        'The simulation lacks creep, and the recordings have ambient drift, of the room and not of the muscle' in both
    )


def test_the_misfit_of_a_sensor_is_not_laid_to_physics():
    """A thermometer that lags misses the temperature; a creep that was found as well does not."""
    place, fits = located(0.5, 0.3), {'temperature': ChannelFit(1.0, 0.5, 0.1, 0.1, Change(0.6, 0.2))}
    found = [FINDING, replace(FINDING, effect='thermocouple_lag', stage='sensor')]
    both = headline('missing_physics', found, replace(place, stage='sensor'), fits, None)
    assert 'The sensors add thermocouple lag, and the simulation lacks creep; with all that was found' in both
    physics = headline('missing_physics', found, replace(place, stage='mechanical'), fits, None)
    assert 'The simulation lacks creep; with all that was found' in physics and 'sensors' not in physics
    alone = headline('missing_physics', [FINDING], replace(place, stage='sensor'), fits, None)
    assert 'The simulation lacks creep; with it' in alone and 'sensors' not in alone


def test_above_and_below_are_said_of_a_mean_that_has_a_sign():
    for shift, side in ((0.5, 'above'), (-0.5, 'below')):
        place = located(shift, 0.6 * shift)
        assert place.mean == pytest.approx(0.8 * shift, abs=0.03)
        said = f'the recorded temperature is on average {abs(place.mean):.2g} K {side} the recalibrated simulation'
        assert said in told(place)


def test_one_recording_above_and_another_below_is_neither():
    """As the demonstration had it: 0.02 above and 0.05 below, and a root mean square was said to be above."""
    place = located(0.2, -0.5)
    assert place.mean is None
    assert place.size == pytest.approx(np.sqrt((0.2**2 + 0.5**2) / 2.0 + 0.2**2), rel=0.05)
    assert 'above' not in told(place) and 'below' not in told(place)
    assert 'the recorded temperature differs from the recalibrated simulation by 0.4' in told(place)


def test_noise_has_no_sign():
    assert located(0.004).mean is None


def test_what_all_findings_do_is_said_where_they_do_it():
    place = located(0.5)
    assert told(place).endswith('with it the error on unseen data falls from 0.6 K to 0.2 K (noise 0.1 K).')
    same = ChannelFit(1.0, 0.5, 0.1, 0.1, Change(0.202, 0.199))
    assert told(place, temperature=same).endswith('the error on unseen data stays about 0.2 K (noise 0.1 K).')
    worse = ChannelFit(1.0, 0.5, 0.1, 0.1, Change(0.2, 0.6))
    assert 'falls' not in told(place, temperature=worse)
    assert 'falls' not in told(place, temperature=ChannelFit(1.0, 0.5, 0.1, 0.1))


def test_recalibration_is_praised_for_what_it_does():
    better = {
        'temperature': ChannelFit(2.0, 1.0, 1.0, 0.2),
        'displacement': ChannelFit(8e-4, 1e-4, 1e-4, 5e-5),
    }
    said = headline('wrong_parameters', [], None, better, None)
    assert said.endswith('recalibrated, the error of the stroke falls from 0.8 mm to 0.1 mm (noise 0.05 mm).')
    worse = headline('wrong_parameters', [], None, {'temperature': ChannelFit(1.0, 1.1, 1.1, 1.0)}, None)
    assert 'falls' not in worse and 'agrees' not in worse


@pytest.mark.parametrize(
    ('effect', 'name', 'value', 'said'),
    [
        ('heat_capacity', 'c', Value(0.30004, 0.29996, 0.30012, '1/K'), 'c = 0.30004 (0.29996 to 0.30012) 1/K.'),
        ('creep', 'tau50', Value(1234.567, 1234.561, 1234.572, 's'), 'tau50 = 1234.567 (1234.561 to 1234.572) s.'),
        (
            'viscous_flow',
            'm',
            Value(1.00004e-6, 1.00001e-6, 1.00007e-6, 'm/(N s)'),
            'm = 1.00004e-06 (1.00001e-06 to 1.00007e-06) m/(N s).',
        ),
        ('heat_capacity', 'Tg', Value(323.15, 322.15, 324.15, 'K'), 'Tg = 50.0 (49.0 to 51.0) degC.'),
        ('heat_capacity', 'c', Value(0.3, 0.3, 0.3, '1/K'), 'c = 0.300 1/K.'),
    ],
)
def test_the_bounds_of_an_interval_are_told_apart(effect, name, value, said):
    assert finding_sentence(effect, {name: value}, ()).startswith(
        f'The recordings show {effect.replace("_", " ")}: {said}'
    )


def test_a_strength_that_may_be_nothing_is_said_to_be():
    said = finding_sentence('heat_capacity', {'c': Value(0.0026, -0.0004, 0.0056, '1')}, ())
    assert said.endswith('Its interval includes no effect at all.')
    assert 'no effect' not in finding_sentence('heat_capacity', {'c': Value(0.3, 0.2, 0.4, '1')}, ())


@pytest.mark.parametrize(
    ('effect', 'values', 'nothing'),
    [
        ('resistance_strain', {'GF': Value(0.12, 0.11, 0.13, '1'), 'n': Value(0.01, -0.01, 0.02, '1')}, False),
        ('clock_skew', {'d': Value(0.38, 0.34, 0.41, 's'), 'r': Value(1e-5, 0.0, 1e-4, '1')}, False),
        ('displacement_drift', {'r': Value(1.4e-6, 1.3e-6, 1.5e-6, 'm/s'), 'c': Value(-0.1, -0.2, 0.1, '1')}, False),
        ('shear_softening', {'b': Value(0.7, 0.1, 1.4, '1'), 'm': Value(-2.0, -2.0, 0.6, '1')}, False),
        ('shear_softening', {'b': Value(0.7, -0.1, 1.4, '1'), 'm': Value(-2.0, -2.0, 0.6, '1')}, True),
        ('thermocouple_gain', {'g': Value(0.99, 0.97, 1.01, '1')}, True),  # no effect is a gain of 1
        ('thermocouple_gain', {'g': Value(0.5, -0.1, 0.9, '1')}, False),
    ],
)
def test_a_second_parameter_that_may_be_zero_does_not_make_an_effect_absent(effect, values, nothing):
    said = finding_sentence(effect, values, ())
    assert ('Its interval includes no effect at all.' in said) is nothing
    assert Finding(effect, '', said, '', values, 0.9, (), {}, 9.0).may_be_nothing is nothing


def test_where_no_experiment_decides_it_is_said_what_would_help():
    runs = [experiment(('displacement',))]
    doubtful = Finding(**{**vars(FINDING), 'indistinguishable_from': ('viscous_flow',)})
    said = would_help([doubtful], None, runs)
    assert 'a thermometer on the muscle' in said[0]
    assert any('second load' in one for one in said)
    assert would_help([FINDING], None, runs) == (), 'nothing is undecided'


@pytest.mark.parametrize(('power', 'proposed'), [(0.009, False), (0.49, False), (0.5, True), (0.97, True)])
def test_an_experiment_is_proposed_only_where_it_is_likely_to_decide(power, proposed):
    planned = Proposal(('creep', 'viscous_flow'), 'loads', 'at other loads', (), 1, 10.0, 'load', power)
    found = likely_to_decide(planned)
    assert found is (planned if proposed else None)
    doubtful = Finding(**{**vars(FINDING), 'indistinguishable_from': ('viscous_flow',)})
    assert (would_help([doubtful], found, [experiment(('displacement',))]) == ()) is proposed


@pytest.mark.parametrize(
    ('seen', 'loads', 'said'),
    [
        (('temperature', 'displacement'), (0.588, 0.59), True),
        (('temperature', 'displacement'), (0.588, 0.3), False),
        (('temperature', 'resistance'), (0.588, 0.588), False),  # no length, and no stroke to foretell
    ],
)
def test_that_one_load_was_hung_is_noted(seen, loads, said):
    runs = [experiment(seen, load=load, seed=k) for k, load in enumerate(loads)]
    told = on_one_load(runs)
    assert bool(told) is said
    if said:
        assert 'one recording under another load would tell' in told[0]
        result = diagnose(runs, NOMINAL)
        assert told[0] in result.notes and told[0] in ' '.join(summary(result).split())


def test_a_motion_that_sticks_is_named_once_in_the_first_sentence():
    sticks = Sticking('displacement', ('a', 'b'), 3, (0.4, 7.2), (3e-4, 2e-3))
    said = with_sticking('It is so.', sticks)
    assert said.startswith('It is so. The stroke sticks and slips in 2 of 3 recordings;')
    assert with_sticking(said, sticks) == said and with_sticking('It is so.', None) == 'It is so.'
