"""The loop of an investigation: what it does next, when it ends, and that it goes on after a kill wherever it was."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tcp_muscle_ros.commands.exploring import first_protocols, further_protocols, kept_back_protocol, loads_about
from tcp_muscle_ros.commands.investigation import (
    Budget,
    Investigation,
    Log,
    allowed_of,
    cycles_of,
    decided,
    render,
)
from tcp_muscle_ros.commands.run import Overheated
from tcp_muscle_ros.control.playing import Allowed, refuse_beyond
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.protocol import Protocol, Ramp, Segment, read_protocol
from tcp_muscle_ros.tool import main

MODEL = Parameters.named('karami_tadesse_2017')
EXPLORED = first_protocols(0.2, (0.25, 0.5, 1.0), 0.5, 296.15)
FIRST, KEPT = EXPLORED[0], kept_back_protocol(0.2, 0.5, 296.15)
WIDE = Budget(1e6, 100, 1000)


class Killed(BaseException):
    """The end of the process."""


class Rig:
    """What records and diagnoses, and is killed before or after the step ``dies``. The third report decides; what is
    named then, each report says after the count of its bags in ``says``; after those in ``lacks`` something is left
    unexplained. It proposes something new each time, or ``always`` the same. The first ``hot`` runs overheat, and those
    of more than ``most`` A."""

    def __init__(self, dies=None, decides=3, says=None, always=False, lacks=(), hot=0, most=9.0):
        self.lacks, self.hot, self.most = lacks, hot, most
        self.dies, self.decides, self.says, self.always, self.steps = dies, decides, says or {}, always, 0

    def _step(self, work):
        self.steps += 1
        if self.dies == 2 * self.steps - 1:
            raise Killed
        work()
        if self.dies == 2 * self.steps:
            raise Killed

    def record(self, protocol, bag):
        assert read_protocol(protocol).duration > 0.0
        if self.hot or read_protocol(protocol).sampled().drive.max() > self.most:
            self.hot = max(self.hot - 1, 0)
            bag.mkdir()
            raise Overheated('stopped, 0 A: the temperature is 61 degC, the limit 60 degC')
        self._step(bag.mkdir)
        return (bag,)

    def diagnose(self, bags, report):
        assert all(bag.is_dir() for bag in bags)
        self._step(report.mkdir)
        # The room is as it was found, each time a little otherwise: that makes no other protocol.
        load = FIRST.load if self.always else FIRST.load + 0.01 * len(bags)
        (report / 'next.yaml').write_text(render(replace(FIRST, load=load, ambient=FIRST.ambient + 0.01 * len(bags))))
        over = len(bags) >= self.decides
        return {
            'verdict': 'missing_physics',
            'headline': f'after {len(bags)}',
            'unexplained': {} if len(bags) in self.lacks else None,
            'findings': [{'effect': self.says.get(len(bags), 'creep'), 'singled_out': over}],
            'next_experiment': None if over else {'protocol': 'next.yaml'},
        }

    def investigation(self, folder, budget=WIDE, admit=lambda protocol: protocol, rounds=((FIRST,),)):
        return Investigation(folder, self, self.diagnose, rounds, KEPT, admit, budget, lambda _: None)


def test_it_runs_what_is_proposed_until_it_is_decided_and_keeps_one_run_back(tmp_path):
    made = Rig().investigation(tmp_path)
    made.run()
    assert [step['step'] for step in made.log.steps] == [*['run', 'diagnosis'] * 3, 'end', 'kept_back']
    assert 'singled out' in made.log.of('end')[0]['why']
    assert [bag.name for bag in made.bags] == ['run_1', 'run_2', 'run_3']
    assert [bag.name for bag in made.kept_back] == ['kept_back']
    assert made.last_report.name == 'report_3'


def test_all_first_protocols_are_recorded_before_anything_is_concluded_as_far_as_the_budget_goes(tmp_path):
    made = Rig(decides=1).investigation(tmp_path / 'all', rounds=(EXPLORED,))
    made.run()
    assert [step['step'] for step in made.log.steps] == [*['run'] * len(EXPLORED), 'diagnosis', 'end', 'kept_back']
    budget = Budget(sum(one.duration for one in (*EXPLORED[:3], KEPT)), 100, 1000)
    short = Rig(decides=9).investigation(tmp_path / 'short', budget, rounds=(EXPLORED,))
    short.run()
    assert [step['step'] for step in short.log.steps] == [*['run'] * 3, 'diagnosis', 'end', 'kept_back']


TWICE = ((FIRST,), (EXPLORED[1], EXPLORED[2]), (EXPLORED[3],))


def test_an_answer_is_asked_for_again_in_another_way_and_counts_if_it_is_the_same(tmp_path):
    made = Rig(decides=2).investigation(tmp_path, rounds=TWICE)
    made.run()
    steps = ['run', 'diagnosis', 'run', 'diagnosis', 'ask_again', 'run', 'run', 'diagnosis', 'end', 'kept_back']
    assert [step['step'] for step in made.log.steps] == steps
    assert made.log.of('end')[0]['why'].endswith('and 2 further runs say the same')
    asked = [read_protocol(tmp_path / 'protocols' / f'run_{k}.yaml') for k in (3, 4)]
    assert [one.duration for one in asked] == [one.duration for one in TWICE[1]]


def test_an_answer_that_changes_is_asked_for_once_more_as_far_as_rounds_and_budget_go(tmp_path):
    changing = {1: 'creep', 3: 'radiation', 4: 'hysteresis'}
    made = Rig(decides=1, says=changing).investigation(tmp_path / 'all', rounds=TWICE)
    made.run()
    assert [one['named'] for one in made.log.of('diagnosis')] == [['creep'], ['radiation'], ['hysteresis']]
    assert 'say the same' not in made.log.of('end')[0]['why']
    poor = Budget(FIRST.duration + KEPT.duration + 1.0, 100, 1000)
    short = Rig(decides=1).investigation(tmp_path / 'short', poor, rounds=TWICE)
    short.run()
    assert [step['step'] for step in short.log.steps] == ['run', 'diagnosis', 'end', 'kept_back']


@pytest.mark.parametrize(('lacks', 'same'), [((), True), ((1, 3, 4), True), ((1,), False), ((3,), False)])
def test_further_runs_say_the_same_only_if_as_much_is_explained(tmp_path, lacks, same):
    made = Rig(decides=1, lacks=lacks).investigation(tmp_path, rounds=TWICE)
    made.run()
    assert ('and 2 further runs say the same' in made.log.of('end')[0]['why']) == same
    assert (len(made.log.of('ask_again')) == 1) == same


def test_a_budget_that_became_smaller_ends_no_answer_for_good(tmp_path):
    try:
        Rig(dies=5, decides=1).investigation(tmp_path, rounds=TWICE).run()
    except Killed:
        assert Log(tmp_path).steps[-1]['step'] == 'ask_again'
    Rig(decides=1).investigation(tmp_path, Budget(FIRST.duration + KEPT.duration, 100, 1000), rounds=TWICE).run()
    assert 'further runs' not in Log(tmp_path).of('end')[0]['why']
    Rig(decides=1).investigation(tmp_path, rounds=TWICE).run()
    assert Log(tmp_path).of('end')[-1]['why'].endswith('and 2 further runs say the same')


def test_what_overheats_counts_as_played_and_is_played_again_with_less_current(tmp_path):
    made = Rig(decides=2, hot=2).investigation(tmp_path / 'two')
    made.run()
    assert [step['step'] for step in made.log.steps[:3]] == ['overheated', 'overheated', 'run']
    played = read_protocol(tmp_path / 'two' / 'protocols' / 'run_1.yaml').sampled().drive
    assert played.max() == pytest.approx(0.81 * FIRST.sampled().drive.max())
    assert len(list((tmp_path / 'two' / 'runs').glob('run_1*'))) == 3, 'what was recorded of it is kept'
    budget = Budget(2.5 * FIRST.duration + KEPT.duration, 100, 1000)
    with pytest.raises(BadInput, match='before anything is recorded'):
        Rig(hot=2).investigation(tmp_path / 'poor', budget).run()
    with pytest.raises(Overheated, match='the temperature is 61 degC'):
        Rig(hot=99).investigation(tmp_path / 'ever').run()


def test_what_is_proposed_again_after_it_overheated_is_the_same_and_begins_with_as_little_current(tmp_path):
    made = Rig(decides=99, always=True, most=0.19).investigation(tmp_path, rounds=((EXPLORED[1],),))
    made.run()
    kinds = [step['step'] for step in made.log.steps if step['step'] != 'diagnosis']
    # Of the first protocol, of the proposed one that is played twice, and of the one that is kept back.
    assert kinds == [*['overheated', 'run'] * 2, 'run', 'end', 'overheated', 'kept_back']
    assert 'played 2 times' in made.log.of('end')[0]['why']


def test_an_answer_of_which_less_was_written_down_is_the_same_as_far_as_it_goes(tmp_path):
    """As before ``ask_again`` had the verdict and whether something is unexplained."""
    try:
        Rig(dies=5, decides=1).investigation(tmp_path, rounds=TWICE).run()
    except Killed:
        lines = (tmp_path / 'log.jsonl').read_text().splitlines()
    old = {name: value for name, value in json.loads(lines[-1]).items() if name in ('step', 'named', 'runs')}
    (tmp_path / 'log.jsonl').write_text('\n'.join([*lines[:-1], json.dumps(old)]) + '\n')
    made = Rig(decides=1).investigation(tmp_path, rounds=TWICE)
    made.run()
    assert made.log.of('end')[0]['why'].endswith('and 2 further runs say the same')


def test_an_experiment_that_decides_nothing_is_played_twice_and_then_something_else_is_asked(tmp_path):
    made = Rig(decides=99, always=True).investigation(tmp_path, rounds=((EXPLORED[1],), (EXPLORED[2],)))
    made.run()
    played = [read_protocol(tmp_path / 'protocols' / f'{one["name"]}.yaml') for one in made.log.of('run')]
    assert [replace(one, ambient=FIRST.ambient) for one in played].count(FIRST) == 2
    assert len(made.log.of('ask_again')) == 1
    assert 'played 2 times' in made.log.of('end')[0]['why']


@pytest.mark.parametrize('dies', [None, *range(1, 11)])
def test_one_that_its_budget_ended_goes_on_where_that_is_larger_and_keeps_what_it_has(tmp_path, dies):
    poor = Rig(decides=4).investigation(tmp_path, replace(WIDE, runs=3))
    poor.run()
    steps = [*['run', 'diagnosis'] * 2, 'end', 'kept_back']
    assert [step['step'] for step in poor.log.steps] == steps
    Rig(decides=4).investigation(tmp_path, replace(WIDE, runs=2)).run()
    assert [step['step'] for step in Log(tmp_path).steps] == steps, 'a smaller one changes nothing'
    try:
        Rig(dies, decides=4).investigation(tmp_path, replace(WIDE, runs=9)).run()
    except Killed:
        Rig(decides=4).investigation(tmp_path, replace(WIDE, runs=9)).run()
    log = Log(tmp_path)
    assert [one['step'] for one in log.steps if one['step'] != 'more_budget'] == [
        *steps, *['run', 'diagnosis'] * 2, 'end'
    ]  # fmt: skip
    assert 'singled out' in log.of('end')[-1]['why']
    Rig(decides=4).investigation(tmp_path, WIDE).run()
    assert Log(tmp_path).steps == log.steps, 'what has its answer is over, whatever may be spent'


@pytest.mark.parametrize('dies', range(1, 15))
def test_killed_while_it_asks_again_it_ends_as_if_nothing_had_been(tmp_path, dies):
    whole = Rig(decides=1).investigation(tmp_path / 'whole', rounds=TWICE)
    whole.run()
    try:
        Rig(dies, decides=1).investigation(tmp_path / 'killed', rounds=TWICE).run()
    except Killed:
        assert dies <= 12
    else:
        assert dies > 12
    resumed = Rig(decides=1).investigation(tmp_path / 'killed', rounds=TWICE)
    resumed.run()
    assert resumed.log.steps == whole.log.steps


def test_what_is_recorded_further_puts_other_loads_and_paces_and_changes_no_load_where_the_rig_cannot():
    once, again = further_protocols(0.2, (0.25, 0.5, 1.0), 0.5, 296.15)
    assert {one.load for one in once} == {0.25, 0.5, 1.0}
    assert max(one.sampled().drive.max() for one in (*once, *again)) == 0.2
    assert all(one not in EXPLORED for one in (*once, *again))
    assert {one.load for those in further_protocols(0.2, (0.5,), 0.5, 296.15) for one in those} == {0.5}
    assert sum(map(cycles_of, once)) > 1.5 * sum(map(cycles_of, EXPLORED))  # so that wear shows


def test_what_is_recorded_first_covers_what_effects_depend_on_and_changes_no_load_where_the_rig_cannot():
    loads = np.concatenate([one.sampled().load for one in EXPLORED])
    assert set(loads) == {0.25, 0.5, 1.0}
    cold = np.concatenate([one.sampled().load[one.sampled().drive < 0.02] for one in EXPLORED])
    assert set(cold) == {0.25, 0.5, 1.0}
    assert max(one.sampled().drive.max() for one in EXPLORED) == 0.2
    by_hand = first_protocols(0.2, (0.5,), 0.5, 296.15)
    assert len(by_hand) > 2
    assert all(set(one.sampled().load) == {0.5} for one in by_hand)
    assert loads_about(0.6, ()) == (0.15, 0.3, 0.6, 1.2)
    assert loads_about(0.6, (0.9, 0.4, 3.0)) == (0.4, 0.9)


@pytest.mark.parametrize('dies', range(1, 15))
def test_killed_anywhere_it_goes_on_and_ends_as_if_nothing_had_been(tmp_path, dies):
    whole = Rig().investigation(tmp_path / 'whole')
    whole.run()
    with pytest.raises(Killed):
        Rig(dies).investigation(tmp_path / 'killed').run()
    again = Rig()
    resumed = again.investigation(tmp_path / 'killed')
    resumed.run()
    assert resumed.log.steps == whole.log.steps
    assert again.steps == 7 - (dies - 1) // 2  # nothing that was done is done again, but for the step that was cut off
    assert Log(tmp_path / 'killed').steps == whole.log.steps
    assert all(bag.is_dir() for bag in resumed.bags)


@settings(max_examples=30)
@given(st.floats(100.0, 3000.0), st.integers(2, 9), st.integers(1, 20))
def test_no_budget_is_passed(tmp_path_factory, duration, runs, cycles):
    folder = tmp_path_factory.mktemp('budget')
    made = Rig(decides=99).investigation(folder, Budget(duration, runs, cycles))
    if duration < FIRST.duration + KEPT.duration or cycles < cycles_of(FIRST) + cycles_of(KEPT):
        with pytest.raises(BadInput, match='before anything is recorded'):
            made.run()
        assert not made.log.steps
        return
    made.run()
    spent = [*made.log.of('run'), *made.log.of('kept_back')]
    assert sum(one['duration_s'] for one in spent) <= duration
    assert len(spent) <= runs
    assert sum(one['cycles'] for one in spent) <= cycles
    assert 'budget' in made.log.of('end')[0]['why']


def test_an_experiment_that_the_rig_does_not_allow_ends_it(tmp_path):
    def admit(_):
        raise BadInput('no such load')

    made = Rig().investigation(tmp_path, admit=admit)
    made.run()
    assert made.log.of('end')[0]['why'] == 'the rig does not allow the proposed experiment: no such load'


@pytest.mark.parametrize(
    ('more', 'why'),
    [
        ({'verdict': 'match'}, 'explains everything'),
        ({'unexplained': {}, 'next_experiment': {}}, ''),
        ({'unexplained': {}}, 'no experiment is known'),
        ({'findings': [{'singled_out': True}], 'next_experiment': {}}, 'singled out'),
        ({'findings': [{'singled_out': True}, {'singled_out': False}], 'next_experiment': {}}, ''),
    ],
)
def test_what_decides(more, why):
    report = {'verdict': 'missing_physics', 'unexplained': None, 'findings': [], 'next_experiment': None, **more}
    assert (why in decided(report)) if why else decided(report) == ''


@settings(max_examples=25, deadline=None)
@given(st.floats(0.1, 0.27), st.floats(300.0, 390.0))
def test_what_is_played_is_allowed_whatever_is_proposed(current, temperature):
    allowed = Allowed(current=current, temperature=temperature)
    try:
        made = allowed_of(first_protocols(0.27, (0.5,), 0.5, 296.15)[0], MODEL, allowed)
    except BadInput:
        assert current < 0.09 or temperature < 303.0
        return
    refuse_beyond(made, MODEL, allowed)


@given(st.lists(st.tuples(st.floats(0.5, 9.0), st.floats(0.0, 0.27), st.floats(0.1, 2.0)), min_size=1, max_size=4))
def test_a_protocol_that_is_written_is_read_back(tmp_path_factory, steps):
    segments = tuple(Segment(s, Ramp(i, 0.5 * i), Ramp(load, load), Ramp(300.25, 301.25)) for s, i, load in steps)
    made = Protocol(20.0, 'current', segments, 2, load=0.7, ambient=297.15)
    path = tmp_path_factory.mktemp('protocol') / 'p.yaml'
    path.write_text(render(made))
    assert read_protocol(path) == made


def test_cycles_are_counted_by_their_beginnings():
    assert cycles_of(FIRST) == 3
    assert cycles_of(replace(FIRST, repeat=2)) == 6


def test_nothing_is_left_where_it_may_not_begin_and_force_replaces_only_an_investigation(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = ['investigate', '--simulated', 'karami_tadesse_2017', '--output', 'new']
    assert main([*command, '--runs', '1']) == 2
    assert list(tmp_path.iterdir()) == []
    (tmp_path / 'new').mkdir()
    (tmp_path / 'new' / 'settings.json').write_text('{}')
    assert main(command, until_admitted=True) == 2
    assert 'new: exists already and is not overwritten' in capsys.readouterr().err
    assert main([*command, '--force'], until_admitted=True) == 2
    assert '--force replaces nothing else' in capsys.readouterr().err
    (tmp_path / 'new' / 'log.jsonl').write_text('')
    assert main([*command, '--force'], until_admitted=True) == 0
    assert main([*command, '--force', '--resume'], until_admitted=True) == 2
    assert 'expected one of them' in capsys.readouterr().err
