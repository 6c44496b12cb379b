"""Scores on reports made by hand, whose figures are known."""

import hashlib
import json

import pytest

from proof import ambiguous
from proof.answers import Answer, covered, gap_closed, matched, read
from proof.document import comparison, met, score_table, wins, write_document
from proof.rates import wilson
from proof.score import power_curve, scores, strength_curve, tables
from proof.truth import EFFECTS

NOISE = {'temperature': 0.2, 'displacement': 5e-5}


def answer(kind: str, effects: list[str], findings: list[dict], verdict: str = 'missing_physics', **more) -> Answer:
    report = more.pop('report', {})
    held_out, limits = more.pop('held_out', None), more.pop('limits', {'recalibration': None, 'oracle': None})
    strength, peak = more.pop('strength', 0.5), more.pop('peak', 9.0)
    visible = {'detectable': peak >= 1.0, 'peak': {'temperature': peak}, **more.pop('visibility', {})}
    truth = [{'effect': e, 'stage': EFFECTS[e].stage, 'strength': strength, 'visibility': visible} for e in effects]
    label = {
        'case': 'case_0000', 'kind': kind, 'effects': truth, 'verdicts': ['match'], 'noise': NOISE,
        'parameters': {'hA': 0.02, 'k0': 23.0}, 'what': '', 'partner': '', **more,
    }  # fmt: skip
    return Answer(label, {'verdict': verdict, 'findings': findings, **report}, held_out, limits)


def finding(effect: str, *alike: str) -> dict:
    return {'effect': effect, 'stage': EFFECTS[effect].stage, 'indistinguishable_from': list(alike)}


def row(answers: list[Answer], name: str) -> dict:
    return next(r for r in scores(answers) if r['score'] == name)


def value(answers: list[Answer], name: str):
    return row(answers, name)['value']


def test_a_match_and_wrong_parameters_are_counted_apart():
    known, moved = {'nominal': {'hA': 0.02}}, {'nominal': {}}
    answers = [
        answer('null', [], [], 'match', **known),
        answer('null', [], [], 'wrong_parameters', **known),
        answer('null', [], [], 'wrong_parameters', **moved),
        answer('null', [], [], 'match', **moved),
        answer('null', [], [], 'wrong_parameters', **moved),
    ]
    assert value(answers, 'muscles as the lab says: match') == pytest.approx(1 / 2)
    assert value(answers, 'muscles with other parameters: wrong parameters') == pytest.approx(2 / 3)


def test_scores_count_what_they_say():
    answers = [
        answer('single', ['creep'], [finding('creep')]),
        answer('single', ['radiation'], [finding('natural_convection', 'radiation')]),
        answer('single', ['friction'], []),
        answer('single', ['creep'], [finding('creep'), finding('radiation')]),
        answer('null', [], [], 'match'),
        answer('null', [], [finding('creep')]),
        answer('decoy', ['thermocouple_lag'], [finding('thermocouple_lag')]),
        answer('decoy', ['thermocouple_lag'], [finding('two_node')], what='thermocouple_lag'),
        answer('double', ['creep', 'radiation'], [finding('natural_convection', 'radiation'), finding('creep')]),
        answer('double', ['creep', 'radiation'], [finding('radiation'), finding('creep')]),
        answer('triple', ['creep', 'radiation', 'friction'], [finding('radiation'), finding('creep')]),
    ]
    assert value(answers, 'single named first') == pytest.approx(2 / 4)
    assert value(answers, 'single in the reported set') == pytest.approx(3 / 4)
    assert value(answers, 'single, nothing else named') == pytest.approx(2 / 4)
    assert value(answers, 'stage right, singles') == pytest.approx(3 / 4)
    assert value(answers, 'mean size of the set') == pytest.approx(4 / 3)
    assert value(answers, 'false physics on nulls') == 0.5
    assert value(answers, 'decoys named as physics') == 0.5
    assert value(answers, 'two effects, exactly') == 0.5
    assert value(answers, 'two effects, as sets') == 1.0
    assert value(answers, 'three effects, exactly') == 0.0


def test_an_effect_that_cannot_be_seen_is_not_asked_for_but_must_not_be_misnamed():
    weak = {'peak': 0.3}
    answers = [
        answer('single', ['creep'], [], 'match', **weak),
        answer('single', ['creep'], [finding('friction')], **weak),
        answer('single', ['creep'], [finding('creep')], **weak),
        answer('single', ['creep'], [finding('displacement_drift')], 'sensor_or_setup', **weak),
    ]
    assert row(answers, 'single named first')['n'] == 0
    assert value(answers, 'undetectable single: no false name') == pytest.approx(3 / 4)


def test_an_alarm_on_a_null_counts_beside_false_physics():
    left = {'stage': 'mechanical', 'channel': 'displacement', 'share': 0.5}
    answers = [
        answer('null', [], [], 'match'),
        answer('null', [], [], 'unexplained', report={'unexplained': left}),
        answer('null', [], [finding('clock_skew')], 'sensor_or_setup'),
    ]
    assert value(answers, 'false physics on nulls') == 0.0
    assert value(answers, 'nulls: any alarm (physics, sensor, unexplained)') == pytest.approx(2 / 3)


def test_something_unlisted_is_flagged_by_the_verdict_or_beside_a_name():
    left = {'stage': 'mechanical', 'channel': 'displacement', 'share': 0.5}
    answers = [
        answer('unlisted', ['rate_stroke'], [], 'unexplained', report={'unexplained': left}),
        answer('unlisted', ['rate_stroke'], [finding('creep')], report={'unexplained': left}),
        answer('unlisted', ['rate_stroke'], [finding('creep')]),
        answer('unlisted', ['peltier'], [], 'unexplained', report={'unexplained': left}),
    ]
    assert value(answers, 'unlisted flagged') == pytest.approx(3 / 4)
    assert value(answers, 'unlisted flagged in its stage') == pytest.approx(2 / 4)
    assert value(answers, 'unlisted given a false name') == pytest.approx(2 / 4)


def test_a_missing_report_is_a_failure():
    label = answer('single', ['creep'], []).label
    assert value([Answer(label, None)], 'single named first') == 0.0
    assert value([Answer(label, None)], 'reports written') == 0.0
    assert value([Answer({**label, 'kind': 'null'}, None)], 'false physics on nulls') is None


@pytest.mark.parametrize(
    ('kind', 'more', 'score', 'hits', 'n'),
    [
        ('null', {'nominal': {'hA': 0.02}}, 'muscles as the lab says: match', 1, 2),
        (
            'null',
            {'nominal': {}, 'verdict': 'wrong_parameters'},
            'muscles with other parameters: wrong parameters',
            1,
            2,
        ),
        ('decoy', {}, 'verdict right on decoys', 1, 2),
        ('decoy', {}, 'decoys named as physics', 0, 1),
        ('single', {'peak': 0.1}, 'undetectable single: no false name', 1, 1),
        ('unlisted', {}, 'unlisted given a false name', 0, 1),
        ('unlisted', {}, 'unlisted flagged', 0, 2),
    ],
)
def test_a_missing_report_is_a_failure_where_something_is_asked_and_not_counted_as_restraint(
    kind, more, score, hits, n
):
    one = answer(kind, [] if kind == 'null' else ['thermocouple_lag'], [], **{'verdict': 'match', **more})
    found = row([one, Answer(one.label, None)], score)
    assert (found['hits'], found['n']) == (hits, n)


def test_without_a_muscle_all_of_the_recalibrated_error_is_left():
    answers = [answer('single', ['creep'], [], held_out=held_out, limits=LIMITS) for held_out in (ORACLE, None)]
    found = row(answers, 'held-out error left, of the recalibrated, median')
    assert (found['value'], found['n']) == (pytest.approx(0.6), 2)


def test_sets_are_matched_one_to_one():
    both = finding('creep', 'friction')
    assert matched([both, finding('friction')], ['friction', 'creep'])
    assert not matched([both, finding('radiation')], ['friction', 'creep'])
    assert not matched([both], ['friction', 'creep'])


def test_wilson_intervals_are_those_of_the_textbook():
    assert wilson(0, 30) == pytest.approx((0.0, 0.1135), abs=1e-3)  # 0 of 30 only shows less than 11 %
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-3)  # Newcombe 1998


# --- the held-out gap ----

RECALIBRATED = {'temperature': 2.0, 'displacement': 5e-4}  # ten times the noise
ORACLE = {'temperature': 0.4, 'displacement': 1e-4}  # twice
LIMITS = {'recalibration': RECALIBRATED, 'oracle': ORACLE}


@pytest.mark.parametrize(
    ('held_out', 'closed'),
    [
        (RECALIBRATED, 0.0),
        (ORACLE, 1.0),
        ({'temperature': 1.2, 'displacement': 3e-4}, 0.5),
        ({'temperature': 0.2, 'displacement': 5e-5}, 1.125),  # better than the oracle
        ({'temperature': 3.6, 'displacement': 9e-4}, -1.0),
        (None, 0.0),  # no report, nothing gained
    ],
)
def test_the_gap_lies_between_the_recalibrated_muscle_and_the_oracle(held_out, closed):
    assert gap_closed(answer('single', ['creep'], [], held_out=held_out, limits=LIMITS)) == pytest.approx(closed)


def test_no_gap_where_there_is_nothing_to_gain():
    same = {'recalibration': RECALIBRATED, 'oracle': {'temperature': 1.9, 'displacement': 4.9e-4}}
    assert gap_closed(answer('single', ['creep'], [], held_out=ORACLE, limits=same)) is None
    assert gap_closed(answer('single', ['creep'], [], held_out=ORACLE)) is None


def test_gaps_are_told_of_physics_that_can_be_seen_only():
    closed = {'held_out': ORACLE, 'limits': LIMITS}
    answers = [
        answer('single', ['creep'], [], **closed, case='a'),
        answer('single', ['creep'], [], peak=0.1, **closed, case='b'),
        answer('decoy', ['thermocouple_lag'], [], **closed, case='c'),
        answer('double', ['creep', 'radiation'], [], held_out=RECALIBRATED, limits=LIMITS, case='d'),
    ]
    assert value(answers, 'held-out gap closed, median') == pytest.approx(0.5)
    assert row(answers, 'held-out gap closed, median')['n'] == 2
    assert value(answers, 'held-out gap closed, 10th percentile') == pytest.approx(0.1)
    assert tables(answers)['gaps'] == pytest.approx({'a': 1.0, 'd': 0.0})


def test_a_muscle_made_worse_is_counted_wherever_no_sensor_is_at_fault():
    far = {'temperature': 2.3, 'displacement': 6e-4}
    answers = [
        answer('null', [], [finding('creep')], held_out=far, limits=LIMITS),
        answer('unlisted', ['peltier'], [], held_out=RECALIBRATED, limits=LIMITS),
        answer('decoy', ['thermocouple_gain'], [], held_out=far, limits=LIMITS),
        answer('null', [], []),
    ]
    found = row(answers, 'held-out error made worse by a tenth')
    assert (found['hits'], found['n']) == (1, 2)


# --- intervals, curves ----


def test_coverage_is_judged_on_shared_parameters_that_the_data_fix():
    calibration = {
        'hA': {'low': 0.019, 'high': 0.021, 'fixed_by_data': True},
        'k0': {'low': 24.0, 'high': 25.0, 'fixed_by_data': True},
        'c2': {'low': 0.0, 'high': 1.0, 'fixed_by_data': True},
    }
    assert sorted(covered(answer('null', [], [], report={'calibration': calibration}))) == [False, True]
    calibration['k0']['fixed_by_data'] = False
    assert covered(answer('null', [], [], report={'calibration': calibration})) == [True]
    # a single that was not solved says nothing of intervals under the right model, nor does a decoy that biases them
    others = [
        answer('single', ['creep'], [], report={'calibration': calibration}),
        answer('decoy', ['current_gain'], [], what='current_gain', report={'calibration': calibration}),
    ]
    assert row(others, '90 % intervals that cover, where the answer is right')['n'] == 0


def test_intervals_of_wrong_answers_count_as_stated():
    covering, missing = ({'calibration': {'hA': {'low': low, 'high': low + 0.002}}} for low in (0.019, 0.025))
    answers = [
        answer('single', ['creep'], [finding('creep')], report=covering),
        answer('single', ['creep'], [finding('friction')], report=missing),
        answer('double', ['creep', 'friction'], [finding('creep')], report=missing),
    ]
    found = row(answers, '90 % intervals that cover')
    assert (found['hits'], found['n'], found['aim']) == (1, 3, '85 to 95 %')
    solved = row(answers, '90 % intervals that cover, where the answer is right')
    assert (solved['hits'], solved['n'], solved['aim']) == (1, 1, '')


@pytest.mark.parametrize(
    ('concealed', 'said', 'n'),
    [('radiation', 'radiation', 1), ('radiation', 'creep', 1), ('creep', 'creep', 2), ('creep', 'free_conductance', 1)],
)
def test_a_parameter_that_means_something_else_is_not_compared(concealed, said, n):
    named = {'effect': said, 'stage': 'thermal', 'unlisted': {'driver': 'force'} if said.startswith('free_') else None}
    calibration = {name: {'low': 0.0, 'high': 99.0} for name in ('hA', 'k0')}
    assert len(covered(answer('single', [concealed], [named], report={'calibration': calibration}))) == n


def test_noise_that_took_a_misfit_with_it_is_counted_channel_by_channel():
    right = {'temperature': 0.25, 'displacement': 5e-5}
    swallowed = {'temperature': 0.2, 'displacement': 3e-4}
    answers = [answer('single', ['creep'], [], report={'noise': noise}) for noise in (right, swallowed)]
    wandering = answer('decoy', [], [], what='coloured_noise', report={'noise': swallowed})
    assert row([*answers, wandering], 'noise as the instrument has it')['hits'] == 3
    assert row([*answers, wandering], 'noise as the instrument has it')['n'] == 4


def test_curves_sort_singles_by_size_and_by_strength():
    answers = [
        answer('single', ['creep'], [finding('creep')], peak=30.0, strength=0.9),
        answer('single', ['creep'], [finding('friction', 'creep')], peak=3.0, strength=0.3),
        answer('single', ['creep'], [], 'unexplained', peak=3.0, strength=0.1),
        answer('single', ['creep'], [], 'match', peak=0.5, strength=-0.2),
    ]
    peaks = {r['peak']: (r['n'], r['first'], r['in_set'], r['anything']) for r in power_curve(answers)}
    assert peaks['0 to 1'] == (1, 0, 0, 0)
    assert peaks['2 to 5'] == (2, 0, 1, 2)
    assert peaks['20 to 50'] == (1, 1, 1, 1)
    assert [r['n'] for r in strength_curve(answers)] == [1, 1, 1, 0, 1]


# --- what is told ----


@pytest.mark.parametrize(
    ('aim', 'figure', 'said'),
    [('<= 2 %', 0.02, 'yes'), ('<= 2 %', 0.03, '**no**'), ('>= 0.95', 0.96, 'yes'), ('>= 98 %', 0.9, '**no**'),
     ('85 to 95 %', 0.9, 'yes'), ('85 to 95 %', 0.97, '**no**'), ('', 0.5, ''), ('100 %', 1.0, 'yes')],
)  # fmt: skip
def test_an_aim_is_met_or_not(aim, figure, said):
    assert met({'aim': aim, 'value': figure}) == said


def test_where_an_alternative_wins_it_is_said(tmp_path):
    right = answer('single', ['creep'], [finding('creep')], held_out=ORACLE, limits=LIMITS)
    wrong = answer('single', ['creep'], [finding('friction')], held_out=RECALIBRATED, limits=LIMITS)
    methods = {'diagnosis': tables([wrong]), 'whiteness_bic': tables([right]), 'recalibration': tables([wrong])}
    said = ' '.join(wins(methods))
    assert 'whiteness + BIC is better in "single named first"' in said
    assert 'recalibration alone is better' not in said
    named = next(line for line in comparison(methods) if line.startswith('| single named first'))
    assert named.split(' | ')[1:] == ['0.0 % [0.0, 79.3]', 'names nothing', '**100.0 % [20.7, 100.0]** |']
    assert wins({'diagnosis': tables([right]), 'whiteness_bic': tables([wrong])}) == [
        'No alternative is better than the diagnosis in any of these scores.'
    ]


def scored() -> dict:
    """A run as it is scored, of one case."""
    found = tables([answer('single', ['creep'], [finding('friction')], held_out=ORACLE, limits=LIMITS)])
    return {
        'suite': 'sealed', 'cases': 20, 'full': 430, 'seed': 5, 'seal': 'abc', 'date': '2030-01-01', 'commit': '1234',
        'machine': '2 cores', 'samples': 1000, 'seconds': 9.0, 'methods': {'diagnosis': found},
        'compared': {'diagnosis': found}, 'compared_cases': 20,
    }  # fmt: skip


def test_the_document_says_what_it_was_made_from(tmp_path):
    run = scored()
    page = tmp_path / 'proof.md'
    write_document(page, tmp_path / 'images', run, None, './scripts/prove --cases 20')
    text = page.read_text()
    assert 'These are 20 cases, not the 430 of the full suite' in text
    assert '`./scripts/prove --cases 20` on 2030-01-01' in text
    assert '| creep | 1 | 0 | 0 | friction 1 |' in text
    assert '| held-out gap closed, median | >= 0.95 | 1.00 | 1 | yes |' in text
    for name in ('power', 'gap', 'confusion'):
        assert f'images/proof_{name}.png' in text
        assert (tmp_path / 'images' / f'proof_{name}.png').stat().st_size > 5000
    write_document(page, tmp_path / 'images', {**run, 'suite': 'development'}, None, '')
    assert 'it proves nothing' in page.read_text()
    assert score_table(run['methods']['diagnosis']['scores'])[0] == '| score | aim | reached | of | aim met |'


# --- does the proposed experiment decide? ----


def pair(findings: list[dict], **more) -> Answer:
    report = {'next_experiment': {'name': 'long hold', 'power': 0.9}}
    alike = {'visibility': {'likeness': 0.95}}
    return answer(
        'ambiguous', ['radiation'], findings, partner='natural_convection', report=report, **{**alike, **more}
    )


def test_only_a_set_with_a_proposal_asks_for_a_decision():
    both = [finding('natural_convection', 'radiation')]
    assert ambiguous.asked(pair(both))
    assert not ambiguous.asked(pair([finding('natural_convection')]))
    assert not ambiguous.asked(pair([finding('natural_convection', 'airflow')]))
    assert not ambiguous.asked(pair(both, visibility={'likeness': 0.5}))
    assert not ambiguous.asked(answer('ambiguous', ['radiation'], both, visibility={'likeness': 0.95}))


def test_a_decision_names_the_truth_without_its_partner(tmp_path):
    asked = pair([finding('natural_convection', 'radiation')])
    for findings, decided in (
        ([finding('radiation')], True),
        ([finding('radiation', 'airflow')], True),
        ([finding('radiation', 'natural_convection')], False),
        ([finding('natural_convection')], False),
        ([], False),
    ):
        assert ambiguous.resolved(asked, {'findings': findings}) is decided
    assert not ambiguous.resolved(asked, None)
    (tmp_path / 'case_0000').mkdir()
    (tmp_path / 'case_0000' / 'report.json').write_text(json.dumps({'findings': [finding('radiation')]}))
    found = ambiguous.summary([asked], tmp_path)
    assert (found['hits'], found['n'], found['cases'][0]['after']) == (1, 1, [['radiation']])


def test_a_promise_is_kept_where_no_finding_could_be_either(tmp_path):
    proposed = {'next_experiment': {'name': 'long hold', 'power': 0.83, 'separates': ['radiation', 'airflow']}}
    asked = answer('single', ['radiation'], [finding('radiation', 'airflow')], report=proposed)
    (tmp_path / 'case_0000').mkdir()
    for after, apart, right in (
        ([finding('radiation')], True, True),
        ([finding('airflow')], True, False),
        ([finding('airflow', 'radiation')], False, False),
        ([finding('airflow', 'exposed_area'), finding('radiation')], True, True),
        ([], True, False),
    ):
        (tmp_path / 'case_0000' / 'report.json').write_text(json.dumps({'findings': after}))
        (row,) = ambiguous.promises([asked, answer('null', [], [])], tmp_path)
        assert (row['promised'], row['told_apart'], row['right']) == (0.83, apart, right)
    neither = answer('single', ['creep'], [finding('radiation', 'airflow')], report=proposed)
    (row,) = ambiguous.promises([neither], tmp_path)
    assert (row['told_apart'], row['concealed'], row['right']) == (True, [], False)
    (tmp_path / 'case_0000' / 'report.json').unlink()
    (row,) = ambiguous.promises([asked], tmp_path)
    assert not row['told_apart']


def test_promises_stand_in_tenths_beside_what_was_kept(tmp_path):
    rows = [(0.55, True, ['creep'], True), (0.83, True, [], False), (0.88, False, ['creep'], False), (1.0, True, [], 0)]
    names = ('promised', 'told_apart', 'concealed', 'right')
    pairs = {'n': 0, 'promises': [dict(zip(names, row, strict=True)) for row in rows]}
    write_document(tmp_path / 'proof.md', tmp_path / 'images', scored(), pairs, '')
    lines = (tmp_path / 'proof.md').read_text()
    assert '| 50 to 60 % | 1 | 55 % | 1/1' in lines
    assert '| 80 to 90 % | 2 | 86 % | 1/2' in lines
    assert '| 90 to 100 % | 1 | 100 % | 1/1 (21 to 100 %) | - |' in lines


def test_held_out_errors_are_read_beside_the_reports(tmp_path):
    label = {**answer('single', ['creep'], []).label}
    labels = tmp_path / 'labels.json'
    labels.write_text(json.dumps({'suite': 'development', 'seed': 1, 'cases': [label]}))
    cases = tmp_path / 'cases'
    cases.mkdir()
    (cases / 'SEAL').write_text(hashlib.sha256(labels.read_bytes()).hexdigest() + '  labels\n')
    for method, errors in (('diagnosis', ORACLE), ('recalibration', RECALIBRATED), ('oracle', ORACLE)):
        folder = tmp_path / 'reports' / method / 'case_0000'
        folder.mkdir(parents=True)
        (folder / 'held_out.json').write_text(json.dumps(errors))
    _, (found,) = read(cases, tmp_path / 'reports' / 'diagnosis', labels, tmp_path / 'reports')
    assert found.report is None
    assert gap_closed(found) == pytest.approx(1.0)
