"""``diagnose --rig``: what is known of the rig is no finding, and the next experiment is one that it can do."""

import json

import numpy as np
import pytest
import yaml

from tcp_muscle_ros.diagnosis.answer.protocols import plans, reach, varied
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters, simulate
from tcp_muscle_ros.recording.protocol import read_protocol
from tcp_muscle_ros.settings.parameter_file import read, write
from tcp_muscle_ros.settings.rig import RigLimits, read_rig
from tcp_muscle_ros.tool import main

MUSCLE = Parameters({'hA': 0.0212})
RIG = """
instruments:
  temperature: {lag_s: 2.5}
limits:
  largest_current_a: 0.2
  loads_n: [0.3, 0.6]
"""
PROTOCOL = """
rate_hz: 10
input: current
load_n: 0.588
segments:
  - {duration_s: 10, value: 0}
  - {duration_s: 40, value: 0.2}
  - {duration_s: 40, value: 0}
  - {duration_s: 40, value: 0.25}
  - {duration_s: 40, value: 0}
"""


@pytest.fixture(scope='module')
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp('lab')
    lagging = MUSCLE.with_effects('thermocouple_lag').replace({'thermocouple_lag.tau': 2.5})
    noise = {'temperature_noise_k': 0.2, 'displacement_noise_m': 5e-5, 'resistance_noise_ohm': 0.02}
    write(folder / 'muscle.yaml', lagging, operating=noise)
    (folder / 'protocol.yaml').write_text(PROTOCOL)
    (folder / 'rig.yaml').write_text(RIG)
    words = ('simulate', 'protocol.yaml', '--params', 'muscle.yaml', '--output', 'bag')
    assert main([str(folder / word) if '.' in word or word == 'bag' else word for word in words]) == 0
    return folder


def diagnosed(lab, output, *options):
    assert main(['diagnose', str(lab / 'bag'), '--output', str(lab / output), *options]) == 0
    return json.loads((lab / output / 'report.json').read_text())


@pytest.mark.long
def test_a_lag_that_is_known_is_no_finding_and_stays_in_rig_yaml_alone(lab):
    unknown = diagnosed(lab, 'unknown')
    assert 'thermocouple_lag' in [f['effect'] for f in unknown['findings']]
    known = diagnosed(lab, 'known', '--rig', str(lab / 'rig.yaml'))
    assert known['findings'] == [] and known['verdict'] == 'wrong_parameters'
    assert known['fit']['temperature']['rmse_calibrated'] < 0.5 * unknown['fit']['temperature']['rmse_calibrated']
    assert {'effect': 'thermocouple_lag', 'why': 'known by --rig'} in known['not_testable']
    handed_on = read_rig(lab / 'known' / 'rig.yaml')
    assert handed_on.instruments['temperature']['lag_s'].value == 2.5
    assert handed_on.limits == read_rig(lab / 'rig.yaml').limits
    improved = read(str(lab / 'known' / 'improved.yaml')).parameters
    assert improved.effects == () and improved['hA'] == pytest.approx(0.0212, rel=0.01)


def test_without_a_verdict_rig_yaml_is_what_was_known_or_seen_of_the_rig(lab):
    (lab / 'still.yaml').write_text('rate_hz: 4\ninput: current\nload_n: 0.4\nsegments: [{duration_s: 60, value: 0}]')
    words = ('simulate', str(lab / 'still.yaml'), '--output', str(lab / 'still'))
    assert main(list(words)) == 0
    for name, options in {'nothing': (), 'nothing_known': ('--rig', str(lab / 'rig.yaml'))}.items():
        assert main(['diagnose', str(lab / 'still'), '--output', str(lab / name), *options]) == 0
        assert json.loads((lab / name / 'report.json').read_text())['verdict'] == 'insufficient_data'
    assert read_rig(lab / 'nothing' / 'rig.yaml').limits.loads == (0.4,)
    assert read_rig(lab / 'nothing_known' / 'rig.yaml') == read_rig(lab / 'rig.yaml')


@pytest.mark.parametrize(
    ('text', 'said'),
    [('instruments: {thermometer: {lag_s: 1}}', 'thermometer'), ('instruments: {force: {gain: 2}}', 'force.gain')],
)
def test_a_rig_that_cannot_be_is_one_line(lab, tmp_path, capsys, text, said):
    (tmp_path / 'rig.yaml').write_text(yaml.safe_dump(yaml.safe_load(text)))
    asked = ('--rig', str(tmp_path / 'rig.yaml'), '--output', str(tmp_path / 'o'))
    assert main(['diagnose', str(lab / 'bag'), *asked]) == 2
    line = capsys.readouterr().err.strip()
    assert said in line and '\n' not in line and str(tmp_path / 'rig.yaml') in line
    assert not (tmp_path / 'o').exists()


def test_no_experiment_goes_beyond_the_rig():
    room = ZERO_CELSIUS + 23.0
    rig = reach(MUSCLE, 0.588, room, RigLimits(largest_current=0.2, loads=(0.3, 0.6), longest_run=300.0))
    rng = np.random.default_rng(1)
    book = plans(rig)
    drawn = [varied(plan, rng, rig) for plan in book for _ in range(40)]
    for feasible in (book, [plan for plan in drawn if plan is not None]):
        steps = [step for plan in feasible for step in plan.steps]
        assert max(step.current for step in steps) == pytest.approx(0.2, rel=1e-3)
        assert {step.load for step in steps} == {0.3, 0.6}
        assert all(plan.repeat * sum(s.duration for s in plan.steps) <= 300.0 for plan in feasible)
        assert all(step.duration > 0.0 for step in steps)
    assert len(book) < len(plans(reach(MUSCLE, 0.588, room)))
    hung = reach(MUSCLE, 0.588, room, RigLimits())
    varied_there = [varied(plan, rng, hung) for plan in plans(hung) for _ in range(10)]
    assert {step.load for plan in (*plans(hung), *varied_there) if plan for step in plan.steps} == {0.588}
    assert not [plan.name for plan in plans(hung) if 'loads' in plan.name or plan.name == 'load steps']
    cool = plans(reach(MUSCLE, 0.588, room, RigLimits(highest_temperature=ZERO_CELSIUS + 40.0)))
    assert max(s.current for plan in cool for s in plan.steps) < 0.2


@pytest.mark.parametrize('limit', [40.0, 60.0, 80.0])
def test_what_is_proposed_stays_below_the_temperature_at_which_a_run_ends_by_more_than_noise(limit):
    room = ZERO_CELSIUS + 23.0
    rig = reach(MUSCLE, 0.588, room, RigLimits(highest_temperature=ZERO_CELSIUS + limit, loads=(0.3, 0.6)))
    for plan in plans(rig):
        steps = plan.steps * plan.repeat
        ends = np.cumsum([step.duration for step in steps])
        time = np.arange(0.0, ends[-1], 0.1)
        at = np.searchsorted(ends, time + 1e-9, side='right').clip(max=len(steps) - 1)
        current, load = (np.array([getattr(step, name) for step in steps])[at] for name in ('current', 'load'))
        shown = simulate(MUSCLE, time, current, load=load, ambient=np.full(time.size, room))
        assert shown.temperature.max() < ZERO_CELSIUS + limit - 1.5, plan.name


def test_of_a_rig_of_which_nothing_is_said_no_more_current_is_asked_than_its_driver_allows():
    room, rng = ZERO_CELSIUS + 23.0, np.random.default_rng(1)
    rig = reach(MUSCLE, 0.588, room, most=0.27)
    drawn = [varied(plan, rng, rig) for plan in plans(rig) for _ in range(40)]
    assert max(step.current for plan in (*plans(rig), *drawn) if plan for step in plan.steps) == 0.27


@pytest.mark.parametrize('by_person', [True, False])
def test_no_person_is_asked_to_hang_a_load_for_one_step_among_many(by_person):
    room, rng = ZERO_CELSIUS + 23.0, np.random.default_rng(1)
    rig = reach(MUSCLE, 0.588, room, RigLimits(loads=(0.3, 0.6), by_person=by_person))
    quick = next(plan for plan in plans(rig) if plan.name == 'very rapid switching')
    drawn = [plan for _ in range(200) if (plan := varied(quick, rng, rig)) is not None]
    at_one = [len({step.load for step in plan.steps}) == 1 for plan in drawn]
    assert all(at_one) == by_person


@pytest.mark.long
def test_a_muscle_that_was_held_is_held_in_the_next_experiment(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lagging = MUSCLE.with_effects('thermocouple_lag').replace({'thermocouple_lag.tau': 0.6})
    noise = {'temperature_noise_k': 0.15, 'force_noise_n': 2e-3, 'resistance_noise_ohm': 0.02}
    for k in range(2):
        write('muscle.yaml', lagging, operating={**noise, 'seed': k})
        steps = '[{duration_s: 30, value: 0.25}, {duration_s: 40, value: 0.02}]'
        (tmp_path / 'held.yaml').write_text(f'rate_hz: 4\ninput: current\nend: blocked\nrepeat: 3\nsegments: {steps}')
        assert main(['simulate', 'held.yaml', '--params', 'muscle.yaml', '--output', f'held_{k}']) == 0
    hanging = tmp_path / 'rig.yaml'
    hanging.write_text('limits: {loads_n: [0.3]}')
    for name, options, end in (('report', (), 'blocked'), ('hung', ('--rig', str(hanging)), 'load')):
        assert main(['diagnose', 'held_0', 'held_1', '--output', name, *options]) == 0
        planned = read_protocol(tmp_path / name / 'next_protocol.yaml')
        assert planned.end == end and len(set(planned.sampled().load)) == 1
