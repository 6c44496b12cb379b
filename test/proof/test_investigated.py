"""How investigate is measured on muscles of the truth: what is played, what is kept back, what the table counts."""

import numpy as np
import pytest

from proof.investigated import OURS, Bench, Muscle, Plant, as_experiment, document, drawn, earlier, keep
from tcp_muscle_ros.commands.exploring import kept_back_protocol
from tcp_muscle_ros.commands.investigation import render
from tcp_muscle_ros.recording.bag import read_bag

NOISE = {'temperature': 0.2, 'displacement': 5e-5}


@pytest.fixture(scope='module')
def muscle():
    return drawn(25, 0)


def test_the_first_muscle_has_one_effect_which_can_be_seen(muscle):
    case, label = muscle
    assert label['kind'] == 'single' and len(label['effects']) == 1
    assert label['effects'][0]['visibility']['detectable']
    assert case.lab.rate == 20.0 and case.channels == ('temperature', 'resistance', 'displacement')


def test_a_protocol_is_played_on_the_truth_and_the_kept_back_run_lies_elsewhere(muscle, tmp_path):
    case, _ = muscle
    protocol = kept_back_protocol(0.2, 0.6, 296.15)
    path = tmp_path / 'protocol.yaml'
    path.write_text(render(protocol))
    plant = Plant(Bench(case, tmp_path / 'runs'), tmp_path / 'unseen')
    (seen,) = plant.record(path, tmp_path / 'run_1')
    (kept,) = plant.record(path, tmp_path / 'kept_back')
    assert seen.is_relative_to(tmp_path / 'runs') and kept.is_relative_to(tmp_path / 'unseen')
    recording = read_bag(seen)
    assert recording['current'].value.max() == pytest.approx(0.2, abs=0.002)
    assert recording['load'].value.tolist() == pytest.approx([0.6] * len(recording['load'].value))
    done = as_experiment(protocol, 24.0)
    assert done.ambient == 24.0 and np.isclose(done.time[-1], protocol.duration)


def result(number, kind, truth, named, **others):
    visible = {'detectable': True, 'peak': {'temperature': 9.0}}
    effects = [{'effect': name, 'stage': 'thermal', 'visibility': visible} for name in truth]

    def way(names):
        findings = [{'effect': name, 'stage': 'thermal', 'indistinguishable_from': []} for name in names]
        return {'report': {'verdict': 'missing_physics', 'findings': findings}, 'held_out': {'temperature': 0.3}}

    steps = [{'step': 'run', 'duration_s': 600.0}, {'step': 'kept_back', 'duration_s': 120.0}]
    return {
        'seed': 25,
        'number': number,
        'revision': 'abc1234',
        'label': {'kind': kind, 'effects': effects, 'noise': NOISE},
        'limits': {'recalibration': {'temperature': 0.7}, 'oracle': {'temperature': 0.2}},
        'ways': {
            OURS: {**way(named), 'steps': steps, 'why': 'decided', 'seconds': 10.0},
            **{name: way(said) for name, said in others.items()},
        },
    }


def test_the_table_counts_what_is_named_exactly_and_what_is_not_done_is_not_there():
    results = [
        result(0, 'single', ['radiation'], ['radiation'], passive=['airflow']),
        result(1, 'double', ['radiation', 'creep'], ['creep', 'radiation'], passive=['creep']),
        result(2, 'single', ['creep'], ['creep', 'slack']),
    ]
    text = document(results, 'command')
    ours, passive = (next(line for line in text.splitlines() if line.startswith(f'| {w} |')) for w in (OURS, 'passive'))
    assert '| 1/2 (' in ours and '| 1/1 (' in ours and '0.80 (0.80), of 3' in ours
    assert passive.count('| 0/1 (') == 4
    assert '| random |' not in text and '| book |' not in text
    assert '| no | creep | creep, slack | 1 | 12 | decided |' in text
    assert '2 muscles with one concealed effect, 1 with two' in text


def test_ways_are_compared_on_the_muscles_that_were_recorded_in_all_of_them():
    others = {way: ['radiation'] for way in ('random', 'book')}
    results = [
        result(0, 'single', ['radiation'], ['radiation'], passive=['airflow'], **others),
        result(1, 'single', ['creep'], ['slack'], passive=['creep']),
    ]
    lines = {line.split('|')[1].strip(): line for line in document(results, 'command').splitlines() if '|' in line}
    assert '| 0/1 (' in lines['passive']
    assert '| 1/1 (' in lines[f'{OURS}, the same 1 muscles']
    assert '| 1/2 (' in lines[OURS]


def test_results_of_an_earlier_run_are_not_made_again(tmp_path, monkeypatch):
    file = tmp_path / 'results.jsonl'
    assert earlier(file, 25) == {}
    done = result(7, 'double', ['radiation', 'creep'], ['creep', 'radiation'])
    keep(done, file)
    keep({**done, 'seed': 26}, file)
    with file.open('a') as torn:
        torn.write('{"seed": 25, "numb')
    assert earlier(file, 25) == {7: done}
    keep({**done, 'number': 8}, file)
    assert sorted(earlier(file, 25)) == [7, 8]
    again = Muscle(tmp_path / 'muscle_07', 25, 7, known=earlier(file, 25)[7])
    monkeypatch.setattr(Muscle, '_investigated', lambda self: pytest.fail('it was investigated again'))
    again.run(('passive',))  # the run that was kept back is not here
    assert again.result == done
    assert 'revision abc1234,' in document([done, {**done, 'number': 9}], 'command')
