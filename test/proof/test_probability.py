"""Probabilities of findings beside how often they are right: read from runs, weighed on other cases, written back."""

import json

import numpy as np
import pytest
import yaml

from proof import probability as module
from proof.probability import (
    Judged,
    bins,
    fitted,
    last_fit,
    left_out,
    main,
    odds_of,
    read_run,
    rescaled,
    scores,
    verdicts,
    write_weights,
)
from tcp_muscle_ros.diagnosis.answer.probability import NAMELESS, TERMS, probability
from tcp_muscle_ros.settings.policy import SHIPPED, read_policy

SEEN = {'visibility': {'detectable': True}}
TRUE_WEIGHTS = dict.fromkeys(TERMS, 0.0) | {'constant': 0.5, 'among_rivals': 1.0, 'left': -1.0}


def made(count, seed):
    """Findings that are right as often as TRUE_WEIGHTS say."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        evidence = dict.fromkeys(TERMS, 0.0) | {
            'constant': 1.0,
            'among_rivals': float(rng.normal(0.5, 1.5)),
            'left': float(rng.integers(2)),
        }
        p = probability(evidence, TRUE_WEIGHTS)
        yield Judged(f'case_{k}', 'creep', p, evidence, bool(rng.random() < p))


def test_weights_are_found_again_and_states_by_those_of_other_cases_are_right_as_often():
    judged = list(made(1500, 1))
    weights = fitted(judged)
    for name in ('constant', 'among_rivals', 'left'):
        assert weights[name] == pytest.approx(TRUE_WEIGHTS[name], abs=0.25)
    right = [one.right for one in judged]
    found = scores(left_out(judged), right)
    assert found['calibration error'] < 0.05
    assert found['log score'] < found['log score of a constant']
    overstated = scores([min(one.stated + 0.3, 1.0) for one in judged], right)
    assert overstated['calibration error'] > 3.0 * found['calibration error']


def test_log_odds_that_are_twice_too_large_are_halved():
    findings = list(made(4000, 5))
    before = {name: 2.0 * weight + (name == 'constant') for name, weight in TRUE_WEIGHTS.items()}
    weights = rescaled(findings, before)
    assert weights == pytest.approx(TRUE_WEIGHTS, abs=0.12)
    ratio = weights['among_rivals'] / weights['left']
    assert ratio == pytest.approx(before['among_rivals'] / before['left'], rel=0.02), 'what speaks for a finding stays'


def test_bins_have_equal_count_and_hold_all():
    found = bins(np.linspace(0.0, 1.0, 83), [True] * 83)
    assert sum(b.count for b in found) == 83
    assert max(b.count for b in found) - min(b.count for b in found) <= 1
    assert [b.stated for b in found] == sorted(b.stated for b in found)


@pytest.fixture
def run(tmp_path):
    """A run of two cases: a listed effect named rightly, and an unlisted one that is a law without a name."""
    evidence = dict.fromkeys(TERMS, 0.0) | {'constant': 1.0}

    def finding(effect, stage, unlisted=None):
        return {'effect': effect, 'stage': stage, 'probability': 0.7, 'evidence': evidence, 'unlisted': unlisted}

    cases = [
        {'case': 'case_0', 'kind': 'single', 'effects': [{'effect': 'creep', 'stage': 'mechanical', **SEEN}]},
        {'case': 'case_1', 'kind': 'unlisted', 'effects': [{'effect': 'sticky_turns', 'stage': 'mechanical', **SEEN}]},
    ]
    findings = [
        [finding('creep', 'mechanical'), finding('friction', 'mechanical')],
        [finding('free_stroke', 'mechanical', {'stage': 'mechanical'}), finding('free_capacity', 'thermal', {})],
    ]
    (tmp_path / 'labels.json').write_text(json.dumps({'cases': cases}))
    for case, mine in zip(cases, findings, strict=True):
        report = tmp_path / 'reports' / 'diagnosis' / case['case']
        report.mkdir(parents=True)
        dropped = [{'effect': 'slack', 'probability': 0.3, 'evidence': evidence}]
        (report / 'report.json').write_text(
            json.dumps({'verdict': 'missing_physics', 'findings': mine, 'doubtful': dropped})
        )
    return tmp_path


def test_a_finding_is_right_where_its_effect_was_concealed(run, capsys):
    assert [(one.effect, one.right) for one in read_run(run)] == [
        ('creep', True),
        ('friction', False),
        ('free_stroke', True),
        ('free_capacity', False),
    ]
    assert [one.effect for one in read_run(run, doubtful=True)].count('slack') == 2, 'weights are fitted to those too'
    assert main([str(run)]) == 0
    assert '| right | 0.5 |' in capsys.readouterr().out


def test_a_verdict_that_names_nothing_is_right_where_nothing_could_be_seen(tmp_path):
    seen, hidden = ({'visibility': {'detectable': yes}} for yes in (True, False))
    told = [('match', []), ('match', [seen]), ('wrong_parameters', [hidden]), ('unexplained', [seen]),
            ('unexplained', []), ('missing_physics', [])]  # fmt: skip
    cases = [{'case': f'case_{k}', 'kind': 'single', 'effects': effects} for k, (_, effects) in enumerate(told)]
    (tmp_path / 'labels.json').write_text(json.dumps({'cases': cases}))
    for case, (verdict, _) in zip(cases, told, strict=True):
        report = tmp_path / 'reports' / 'diagnosis' / case['case']
        report.mkdir(parents=True)
        (report / 'report.json').write_text(json.dumps({'verdict': verdict, 'findings': []}))
    counts = verdicts([tmp_path])
    assert counts == {'match': (1, 2), 'wrong_parameters': (1, 1), 'unexplained': (1, 2)}
    assert odds_of(counts) == {'match': 0.0, 'wrong_parameters': 0.69, 'unexplained': 0.0}


def test_weights_are_never_fitted_to_a_sealed_suite(run, capsys):
    sealed = run.parent / 'sealed-430'
    run.rename(sealed)
    assert main([str(sealed), '--fit']) == 2
    assert 'never fitted to a sealed suite' in capsys.readouterr().err


def test_weights_may_be_fitted_to_the_suite_outside(run, capsys):
    outside = run.parent / 'outside-100'
    run.rename(outside)
    assert main([str(outside), '--fit']) == 0
    assert 'constant: ' in capsys.readouterr().out


def test_what_is_no_run_is_said_in_one_line(tmp_path, capsys):
    assert main([str(tmp_path)]) == 2
    assert 'expected a folder of ./scripts/prove' in capsys.readouterr().err


def test_weights_are_written_and_all_else_stays(tmp_path):
    path = tmp_path / 'policy.yaml'
    path.write_text(SHIPPED.read_text(encoding='utf-8'), encoding='utf-8')
    weights = {name: round(0.1 * k, 2) for k, name in enumerate((*TERMS, *NAMELESS))}
    write_weights(weights, TRUE_WEIGHTS, 'fitted on varied-108-1', path)
    assert read_policy(path).odds == weights
    assert last_fit(path) == (TRUE_WEIGHTS, 'fitted on varied-108-1')
    before, after = (yaml.safe_load(p.read_text(encoding='utf-8')) for p in (SHIPPED, path))
    assert {k: v for k, v in before.items() if k != 'odds'} == {k: v for k, v in after.items() if k != 'odds'}
    assert all(before['odds'][key] == after['odds'][key] for key in ('unit', 'meaning'))


def test_weights_that_are_scaled_again_on_the_same_muscles_stay(run, tmp_path, monkeypatch):
    path = tmp_path / 'policy.yaml'
    path.write_text(SHIPPED.read_text(encoding='utf-8'), encoding='utf-8')
    monkeypatch.setattr(module, 'SHIPPED', path)
    fit, written = last_fit(path), []
    for _ in range(2):
        assert main([str(run), '--rescale', '--write']) == 0
        written.append(path.read_text(encoding='utf-8'))
    assert written[0] == written[1] != SHIPPED.read_text(encoding='utf-8')
    assert last_fit(path) == fit
    by = yaml.safe_load(written[0])['odds']['set_by']
    assert by.startswith(f'{fit[1]}; scaled on {run.name} (2 of 2 cases); ')
    assert main([str(run), '--fit', '--write']) == 0
    weights, by = last_fit(path)
    assert weights == {name: read_policy(path).odds[name] for name in TERMS}
    assert by.startswith(f'fitted on {run.name} (2 of 2 cases); ')


def test_the_page_has_its_figure(run, tmp_path, monkeypatch):
    monkeypatch.setattr(module, 'PAGE', tmp_path / 'page.md')
    monkeypatch.setattr(module, 'FIGURE', tmp_path / 'figure.png')
    assert main([str(run), '--document']) == 0
    assert '| stated (mean) | findings |' in (tmp_path / 'page.md').read_text(encoding='utf-8')
    assert (tmp_path / 'figure.png').stat().st_size > 5000
