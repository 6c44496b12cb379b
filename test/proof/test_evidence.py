"""The study of the evidence: what it says of an effect that is there, of one that is not, and the table."""

import json

from diagnosis.made import NOMINAL, TRUE, experiment

from proof.evidence import AIMS, log_evidence, main, rates
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for

CHANNELS = ('temperature', 'resistance', 'displacement')


def test_evidence_is_for_an_effect_that_is_there_and_against_one_that_is_not():
    for muscle, there in ((TRUE, False), (TRUE.replace({'radiation.eps': 0.9}).with_effects('radiation'), True)):
        runs = [experiment(CHANNELS, current, 0.588, k, muscle=muscle) for k, current in enumerate((0.27, 0.2))]
        base = settle_noise(calibrate(runs, NOMINAL).fit)[0]
        (found,) = rivals_for(base, screen(base, ['radiation'])[0], None)
        assert (log_evidence(found.fit) > log_evidence(base)) == there


def test_the_table_counts_what_held():
    single = {'kind': 'single', 'effects': [{'effect': 'creep'}]}
    null = {'kind': 'null', 'effects': []}
    rows = rates(
        [
            (single, {'none': -50.0, 'effects': {'creep': -10.0, 'friction': -12.0}, 'named': ['creep']}),
            (single, {'none': -50.0, 'effects': {'creep': -14.0, 'friction': -12.0}, 'named': ['creep', 'friction']}),
            (null, {'none': -5.0, 'effects': {'creep': -4.0}, 'named': []}),
            (null, {'none': -5.0, 'effects': {}, 'named': []}),
        ]
    )
    assert set(AIMS) < set(rows)
    assert rows['the true effect is first, by evidence'] == [True, False]
    assert rows['the true effect is first, by selection'] == [True, True]
    assert rows['none is ahead of every effect where none is missing, by evidence'] == [False, True]


def test_what_was_done_is_read_and_not_done_again(tmp_path, capsys):
    label = {'case': 'case_0', 'kind': 'single', 'effects': [{'effect': 'creep', 'visibility': {'detectable': True}}]}
    (tmp_path / 'labels.json').write_text(json.dumps({'cases': [label]}))
    for path, content in (
        ('reports/diagnosis/case_0/report.json', {'findings': [{'effect': 'creep'}]}),
        ('evidence/case_0.json', {'none': -9.0, 'effects': {'creep': -1.0}}),
    ):
        (tmp_path / path).parent.mkdir(parents=True)
        (tmp_path / path).write_text(json.dumps(content))
    assert main([str(tmp_path)]) == 0
    assert '| the true effect is first, by evidence | 1 | 1.00 |' in capsys.readouterr().out
    assert main([str(tmp_path / 'nothing')]) == 2
