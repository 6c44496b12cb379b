"""What is said to be gained: each finding's own improvement, errors of single samples, how sure an effect is."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.conclusions import most_missed, not_testable, stage_of
from tcp_muscle_ros.diagnosis.answer.findings import Change, Finding, Value
from tcp_muscle_ros.diagnosis.answer.improvement import certainty, of_samples, own_improvement
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.fitting.weighing import structures
from tcp_muscle_ros.diagnosis.observation.blocks import averaged
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, with_effect
from tcp_muscle_ros.diagnosis.search.holdout import Gain, held_out, stretches
from tcp_muscle_ros.diagnosis.search.picking import NOTHING, Picked
from tcp_muscle_ros.diagnosis.search.rivals import Rival
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection
from tcp_muscle_ros.muscle import SPECIFICATIONS
from tcp_muscle_ros.recording.recording import Channel

EFFECTS = {'creep': {'creep.J': 0.4}, 'natural_convection': {'natural_convection.n': 0.35}}


@pytest.fixture(scope='module')
def selection():
    """Both effects of a muscle, fitted; what a search would have ended with."""
    muscle = TRUE.with_effects(*EFFECTS).replace({k: v for found in EFFECTS.values() for k, v in found.items()})
    loads = np.where(np.mod(TIME, 90.0) < 45.0, 0.8, 0.3)  # under one alone another gain and modulus would do
    runs = [experiment(('temperature', 'displacement'), load=loads, muscle=muscle)]
    bare = calibrate(runs, NOMINAL, rounds=1).fit
    problem = bare.problem
    for effect, values in EFFECTS.items():
        usual = {row: SPECIFICATIONS[row].value for row in SPECIFICATIONS if row.startswith(f'{effect}.')}
        problem = with_effect(problem, Candidate(effect, {**usual, **values}, 0.0, 0.0))
    final = fit(problem, np.concatenate([bare.z, problem.start()[bare.z.size :]]), rounds=60)
    kept_back = stretches(problem)[:2]
    chosen = tuple(Chosen(effect, 100.0, Gain(0.0, 0.0, 0.0, 0.0, 0), 1.0, ()) for effect in EFFECTS)
    before, after = held_out(bare, kept_back), held_out(final, kept_back)
    return Selection(bare, final, chosen, before, after, {}, {}, NOTHING, kept_back=kept_back)


def test_each_finding_has_its_own_improvement_in_the_channels_that_it_changes(selection):
    creep, convection = (own_improvement(selection, effect) for effect in EFFECTS)
    assert set(creep) == {'displacement'}, 'creep changes no temperature'
    assert set(convection) == {'temperature', 'displacement'}
    assert creep['displacement'].before != convection['displacement'].before
    for change in (*creep.values(), *convection.values()):
        assert change.after < 0.9 * change.before
    after = selection.after.rmse()
    assert convection['temperature'].after == pytest.approx(after['temperature']), 'with all findings, for each of them'


@pytest.mark.parametrize('differ', [False, True])
def test_what_was_fitted_or_promises_much_is_none_of_what_recordings_could_not_have_shown(selection, differ):
    ranked = [Candidate('hysteresis', {}, 9.3, 0.1), Candidate('latent_heat', {}, 40.0, 0.1)]
    picked = Picked(None, (0.0, []), tuple(ranked), {'slack': 50.0}, (Rival('hysteresis', selection.final, 1.0),))
    found = replace(selection, first=picked, leads=('cte_kink',))
    why = {n.effect: n.why for n in not_testable(found, {'inertia': 'sampled too slowly'}, differ)}
    assert not {'hysteresis', 'latent_heat', 'slack', 'cte_kink', *EFFECTS} & set(why)
    assert why['inertia'] == 'sampled too slowly' and why['contact_resistance'].startswith('a constant resistance')
    assert ('what runs of one protocol differ by' in why['radiation']) is differ


def test_errors_are_of_single_samples_where_samples_were_averaged():
    rng = np.random.default_rng(3)
    time = np.arange(6000) / 10.0
    slow = 40.0 * np.sin(time / 30.0)
    noisy = Channel('temperature', time, slow + rng.normal(0.0, 0.25, time.size), 'temperature')
    current = Channel('current', time[:1], np.array([0.2]), 'current')
    blocks = averaged(noisy, current, 0.5, 1000, 0.0)
    assert blocks.count.max() == 6
    error = np.sqrt(np.mean((blocks.value - np.interp(blocks.time, time, slow)) ** 2))
    assert error == pytest.approx(0.25 / np.sqrt(6.0), rel=0.1)

    made = experiment(('temperature',))
    fitted = calibrate([made], NOMINAL, rounds=1).fit
    problem = replace(fitted.problem, experiments=(replace(made, observed={'temperature': blocks}),))
    assert of_samples(replace(fitted, problem=problem), {'temperature': error})['temperature'] == pytest.approx(
        0.25, rel=0.05
    )
    assert of_samples(fitted, {'temperature': 0.3}) == {'temperature': 0.3}, 'nothing was averaged'


@pytest.mark.parametrize(
    ('effect', 'values', 'least', 'most', 'nothing'),
    [
        ('heat_capacity', {'c': Value(0.0026, -0.0004, 0.0056, '1')}, 0.5, 0.794, True),
        ('heat_capacity', {'c': Value(0.0, -0.003, 0.003, '1')}, 0.5, 0.5, True),
        ('heat_capacity', {'c': Value(0.3, 0.28, 0.32, '1')}, 0.999, 1.0, False),
        ('thermocouple_gain', {'g': Value(0.99, 0.97, 1.01, '1')}, 0.5, 0.794, True),
        ('creep', {'creep.J': Value(0.1, 0.05, 0.15, '1'), 'creep.aT': Value(0.0, 0.0, 0.1, '1')}, 0.99, 1.0, False),
        ('airflow', {'g [1]': Value(0.01, -0.1, 0.1, '1'), 'g [2]': Value(0.5, 0.4, 0.6, '1')}, 0.99, 1.0, False),
        ('current_gain', {'g': Value(1.0, 0.99, 1.01, '1'), 'z': Value(0.02, 0.018, 0.022, 'A')}, 0.99, 1.0, False),
    ],
)  # fmt: skip
def test_nothing_is_sure_whose_interval_contains_no_effect(effect, values, least, most, nothing):
    assert least <= certainty(effect, values) <= most
    found = Finding(effect, 'thermal', '', '', values, 1.0, (), {}, 9.0)
    assert found.may_be_nothing is nothing
    assert found.singled_out is not nothing
    assert not replace(found, indistinguishable_from=('slack',)).singled_out


def test_a_misfit_is_said_to_be_seen_where_it_is_the_most_noises(selection):
    """Not in a channel that follows from it, and shows it a little but more regularly."""
    seen = replace(
        selection,
        structure_before=structures(selection.calibrated),
        structure_after=structures(selection.final),
    )
    noises = {name: s.noise.sigma for name, s in seen.structure_after.items()}
    (left,) = selection.calibrated.left
    missed = {name: float(np.sqrt(np.mean(left[name] ** 2))) / noises[name] for name in noises}
    assert most_missed(seen) == max(missed, key=missed.get) == 'displacement'


def test_a_misfit_is_located_in_the_stage_of_the_finding_that_shows_in_its_channel():
    """A lag of the thermometer, found first, does nothing to the stroke."""

    def finding(effect, stage, **missed):
        improvement = {channel: Change(without, 4e-5) for channel, without in missed.items()}
        return Finding(effect, stage, '', '', {}, 0.9, (), improvement, 1000.0)

    lag = finding('thermocouple_lag', 'sensor', temperature=4.0)
    air = finding('natural_convection', 'thermal', temperature=0.8, displacement=8e-4)
    laser = finding('displacement_drift', 'sensor', displacement=5e-4)
    found = [air, lag, laser]
    assert [stage_of(found, channel) for channel in ('displacement', 'temperature')] == ['thermal', 'sensor']
    assert stage_of([lag], 'displacement') == 'sensor'
