"""The proposed experiment is one under which what passed for alike differs by more than forms may."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from diagnosis.made import NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.commands.run import allowed_by
from tcp_muscle_ros.control.playing import refuse_beyond
from tcp_muscle_ros.diagnosis.answer import next_experiment
from tcp_muscle_ros.diagnosis.answer.handed_on import limits_seen
from tcp_muscle_ros.diagnosis.answer.next_experiment import (
    Planned,
    Question,
    Under,
    allowing,
    experiment_of,
    kept,
    propose,
    separation,
)
from tcp_muscle_ros.diagnosis.answer.protocols import plans, reach
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.hypothesis.problem import Problem
from tcp_muscle_ros.diagnosis.hypothesis.unknowns import base_unknowns
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, screen, with_effect
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for, shrink
from tcp_muscle_ros.diagnosis.search.rivals import Rival, penalised
from tcp_muscle_ros.muscle import simulate
from tcp_muscle_ros.recording.protocol import parse_protocol
from tcp_muscle_ros.recording.yaml_input import Section
from tcp_muscle_ros.report.protocol_file import render_protocol
from tcp_muscle_ros.settings.rig import RigLimits

CHANNELS = ['temperature', 'resistance', 'displacement']
LATE = TRUE.with_effects('thermocouple_lag').replace({'thermocouple_lag.tau': 0.3})


@pytest.fixture(scope='module')
def late():
    """Recordings with a thermometer that lags, and the two models that explain them."""
    made = [experiment(CHANNELS, seed=k, load=load, muscle=LATE) for k, load in enumerate((0.4, 0.6))]
    bare = calibrate(made, NOMINAL).fit
    ranked, _ = screen(bare, ['thermocouple_lag', 'clock_skew'])
    return bare, {rival.effect: rival for rival in rivals_for(bare, ranked, None)}


def test_a_gain_that_each_run_has_for_itself_is_as_assumed_in_a_further_one():
    """A stroke gain of nothing, which stands for one that is derived, has no logarithm."""
    runs = [experiment(CHANNELS, seed=k) for k in range(2)]
    under = Under(calibrate(runs, NOMINAL, separate=('B',)).fit, runs[0])
    assert under.problem.values(under.z)['B', 0] == pytest.approx(NOMINAL['B'])
    assert all(np.isfinite(shown).all() for shown in under.shown[0].values())


def test_a_further_one_is_of_the_muscle_as_old_as_it_is_by_then():
    worn = NOMINAL.with_effects('fatigue')
    runs = [experiment(CHANNELS, seed=k, muscle=worn) for k in range(3)]
    fitted = in_turn(calibrate(runs, worn).fit)
    ages = [latent.before.cycles for latent in fitted.problem.latents]
    (latent,) = Under(fitted, runs[0]).problem.latents
    assert latent.before.cycles == pytest.approx(ages[-1] + ages[1], rel=0.01)


def proposal(late, *names, limits=None):
    bare, rivals = late
    first = rivals[names[0]].fit
    drop = penalised(bare) - rivals[names[0]].score
    return propose([rivals[name] for name in names], shrink(first, names[0]), drop, limits)


def test_a_lag_is_told_from_a_delay_by_edges_that_follow_before_either_is_over(late):
    found = proposal(late, 'thermocouple_lag', 'clock_skew')
    assert found.name.endswith('rapid switching')
    assert set(found.separates) == {'thermocouple_lag', 'clock_skew'}
    assert 0.9 * next_experiment._HELD < found.power <= next_experiment._HELD  # what the models promise is not all kept
    # Of the rig nothing is said: a driver that nobody has set refuses more.
    assert max(step.current for step in found.steps) <= RigLimits().largest_current


def test_two_others_are_told_apart_where_the_named_one_surely_is_not(late, monkeypatch):
    """By what is kept of a promise: 0.6 of the models is no chance of a half."""
    bare, rivals = late
    third = replace(rivals['clock_skew'], effect='friction')
    for probable, pair in ((0.6, ('clock_skew', 'friction')), (0.8, ('thermocouple_lag', 'clock_skew'))):
        told = {
            ('thermocouple_lag', 'clock_skew'): probable,
            ('thermocouple_lag', 'friction'): 0.1,
            ('clock_skew', 'friction'): 0.95,
        }
        monkeypatch.setattr(Planned, 'told', lambda self, rounds=1, told=told: told)
        monkeypatch.setattr(next_experiment, '_VARIED', 0)
        found = propose([*rivals.values(), third], bare, 100.0)
        assert found.separates == pair


def test_a_model_is_not_told_from_itself(late):
    _, rivals = late
    fitted = rivals['thermocouple_lag'].fit
    for plan in plans(reach(fitted.muscle, 0.5, NOMINAL['T0'])):
        planned = experiment_of(plan, fitted.problem.experiments[0], NOMINAL['T0'])
        assert separation(Under(fitted, planned), Under(fitted, planned)) == pytest.approx(0.0, abs=1e-9)


def with_drift(bare, rate, own, rounds=10):
    """The fit with a drift (m/s): of each recording by itself, or one for all."""
    values = {'displacement_drift.r': rate}
    each = tuple(values for _ in bare.problem.experiments) if own else ()
    problem = with_effect(bare.problem, Candidate('displacement_drift', values, 0.0, 0.0, each))
    return fit(problem, np.concatenate([bare.z, problem.start()[bare.z.size :]]), rounds=rounds)


def test_what_an_effect_has_for_each_recording_by_itself_it_has_anew(late):
    """A drift of its own in each recording follows any drift of the next; one for all is what it was."""
    bare, _ = late
    rest = next(p for p in plans(reach(bare.muscle, 0.5, NOMINAL['T0'])) if p.name == 'at rest')
    planned = experiment_of(rest, bare.problem.experiments[0], NOMINAL['T0'])
    drifting = Under(with_drift(bare, -3e-5, own=False, rounds=0), planned)  # 9 mm in the 300 s
    assert separation(drifting, Under(with_drift(bare, 1e-5, own=True), planned)) < 200.0  # what its prior says of it
    assert separation(drifting, Under(with_drift(bare, 1e-5, own=False), planned)) > 1e4


@pytest.mark.long
def test_what_flows_is_told_from_an_end_that_turns_at_other_loads_but_not_surely(monkeypatch):
    """Both grow with the load: the experiment is the right one, and its promise is no greater than it is;
    adapted to the two it promises more."""
    flowing = TRUE.with_effects('viscous_flow').replace({'viscous_flow.m': 5e-6})
    bare = calibrate([experiment(CHANNELS, seed=1, muscle=flowing)], NOMINAL).fit
    ranked, _ = screen(bare, ['viscous_flow', 'torsional_leakage'])
    rivals = {rival.effect: rival for rival in rivals_for(bare, ranked, None)}
    rig = RigLimits(largest_current=0.4, loads=(0.294, 0.588, 1.176), longest_run=900.0)
    adapted = proposal((bare, rivals), 'viscous_flow', 'torsional_leakage', limits=rig)
    monkeypatch.setattr(next_experiment, '_VARIED', 0)
    found = proposal((bare, rivals), 'viscous_flow', 'torsional_leakage', limits=rig)
    assert found.name in ('three loads', 'holds at three loads')
    assert found.separates == adapted.separates == ('viscous_flow', 'torsional_leakage')
    assert 0.1 < found.power / next_experiment._HELD < 0.5
    assert adapted.power > 1.1 * found.power


def test_a_promise_is_worth_what_the_muscle_keeps_of_it():
    assert kept(100.0, 100.0) == pytest.approx(0.5)
    assert kept(200.0, 100.0) == pytest.approx(0.841, abs=1e-3)
    assert kept(0.0, 100.0) < 1e-9


def test_a_promise_is_for_whichever_of_all_rivals_is_the_muscles(late, monkeypatch):
    """Where the third is, which is near both, none of the two is left out."""
    bare, rivals = late
    lag, skew = rivals['thermocouple_lag'], rivals['clock_skew']
    third = Rival('friction', replace(lag.fit), lag.score)
    rest = next(p for p in plans(reach(bare.muscle, 0.5, NOMINAL['T0'])) if p.name == 'at rest')

    def far(a, b, rounds):
        return 0.0 if third.fit in (a.fitted, b.fitted) else 1e9

    def told(*members):
        even = [replace(rival, score=lag.score) for rival in members]
        planned = experiment_of(rest, bare.problem.experiments[0], NOMINAL['T0'])
        return Planned(rest, planned, Question(even, bare, 100.0)).told()['thermocouple_lag', 'clock_skew']

    monkeypatch.setattr(next_experiment, 'separation', far)
    assert told(lag, skew) == pytest.approx(1.0, abs=1e-3)
    assert told(lag, skew, third) == pytest.approx(2 / 3, abs=1e-3)


def test_a_plan_under_which_a_model_runs_away_tells_nothing(late):
    """A wire whose resistance falls with the length heats the more the shorter it is."""
    bare, rivals = late
    wild = with_effect(bare.problem, Candidate('resistance_strain', {'resistance_strain.GF': -1.0}, 0.0, 0.0))
    running = fit(wild, np.concatenate([bare.z, wild.start()[bare.z.size :]]), rounds=0)
    hold = next(p for p in plans(reach(bare.muscle, 0.5, NOMINAL['T0'])) if p.name == 'long hold')
    planned = experiment_of(hold, bare.problem.experiments[0], NOMINAL['T0'])
    wild, lagging = Under(running, planned), Under(rivals['thermocouple_lag'].fit, planned)
    for rounds in (1, 4):
        assert separation(wild, lagging, rounds) == 0.0
        assert separation(lagging, wild, rounds) == 0.0


def test_no_plan_is_hotter_than_a_muscle_bears():
    for plan in plans(reach(NOMINAL, 0.5, NOMINAL['T0'])):
        planned = experiment_of(plan, experiment(CHANNELS), NOMINAL['T0'])
        assert planned.outputs(NOMINAL).fibre_temperature.max() < 273.15 + 90.1, plan.name


DRIVES = {'current': 0.2, 'power': 0.6, 'voltage': 2.8}  # A, W, V: the muscle becomes some 50 degC hot
COLD = TRUE.replace({name: 40.0 * TRUE[name] for name in ('hA', 'C', 'B')})  # moves alike, and hardly warms


def proposed_to(kind, channels, limits=None):
    """What is proposed where a fit has the muscle cold, and a delay passes for a lag; and the recordings."""
    made = [experiment(channels, DRIVES[kind], load, k, kind=kind) for k, load in enumerate((0.4, 0.6))]
    problem = Problem(tuple(made), COLD, tuple(base_unknowns(made, COLD, {})), quick_noise(made))
    bare = fit(problem, problem.start(), rounds=0)

    def rival(effect, values):
        more = with_effect(problem, Candidate(effect, values, 0.0, 0.0))
        return Rival(effect, fit(more, more.start(), rounds=0), 0.0)

    channel = 3.0 if 'temperature' not in channels else 0.0
    lag = rival('supply_lag', {'supply_lag.tau': 1.0})
    skew = rival('clock_skew', {'clock_skew.d': 1.0, 'clock_skew.channel': channel})
    return propose([lag, skew], bare, 100.0, limits), made


def played(found, made):
    """The protocol as the file says it."""
    return parse_protocol(Section(yaml.safe_load(render_protocol(found, made[0].holding)), 'next_protocol.yaml'))


@pytest.mark.parametrize('kind', DRIVES)
@pytest.mark.parametrize('limits', [None, RigLimits(0.5, loads=(0.4, 0.6)), RigLimits(0.15, loads=(0.4, 0.6))])
def test_where_nothing_shows_the_temperature_no_more_is_asked_than_the_muscle_has_borne(kind, limits):
    """By its fit the muscle would be cold at ten times the drive: it is asked for no more, in the drive that it had."""
    found, made = proposed_to(kind, ('displacement',), limits)
    assert found.kind == kind and max(step.current for step in found.steps) <= DRIVES[kind]
    protocol = played(found, made)
    at = protocol.sampled()
    shown = simulate(TRUE, at.time, at.drive, kind=at.kind, load=at.load, ambient=at.ambient)
    been = max(float(simulate(TRUE, TIME, e.imposed.drive, kind=kind).fibre_temperature.max()) for e in made)
    assert shown.fibre_temperature.max() - NOMINAL['T0'] < 1.05 * (been - NOMINAL['T0'])
    # A rig of which nothing is said is handed on with the limits that were seen: by these it may be played.
    handed_on = limits or allowing(limits_seen(made, COLD), found, made, COLD)
    refuse_beyond(protocol, COLD, allowed_by(handed_on, None))


@pytest.mark.parametrize('kind', DRIVES)
def test_a_rig_that_is_handed_on_plays_what_is_proposed_also_where_a_thermometer_allows_more(kind):
    found, made = proposed_to(kind, CHANNELS)
    assert found.kind == 'current' and max(step.current for step in found.steps) > 0.25
    handed_on = allowing(limits_seen(made, COLD), found, made, COLD)
    refuse_beyond(played(found, made), COLD, allowed_by(handed_on, None))
