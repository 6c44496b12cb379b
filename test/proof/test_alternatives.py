"""The other ways to answer, on cases small enough to know what they have to say, and the run from end to end."""

import json

import numpy as np
import pytest
from scipy.signal import lfilter

pytest.importorskip('pysindy', reason='pysindy and scikit-learn come with requirements/proof.txt')

from proof import alternatives, prove, sparse
from proof.cases import make_case
from proof.generate import write_case
from proof.tool import Case, errors, experiments_of, replay
from proof.whiteness import ljung_box
from tcp_muscle_ros.muscle import EFFECTS

FOLDERS = ('diagnosis', *alternatives.RUNNERS)


def test_ljung_and_box_raise_an_alarm_on_coloured_noise_and_seldom_on_white():
    rng = np.random.default_rng(1)
    white = rng.standard_normal((400, 300))
    coloured = lfilter([1.0], [1.0, -0.5], white)
    assert np.mean([ljung_box(v) < 0.05 for v in white]) == pytest.approx(0.05, abs=0.03)
    assert np.mean([ljung_box(v) < 0.05 for v in coloured]) > 0.99


def test_terms_stand_for_effects_of_the_catalogue():
    named = {effect for terms in sparse.TERMS.values() for _, plus, minus in terms.values() for effect in (plus, minus)}
    assert named - {''} <= set(EFFECTS)
    assert len(named) > 30


def test_a_sparse_regression_finds_the_term_that_is_there_and_nothing_in_noise():
    rng = np.random.default_rng(2)
    examples, silent = [], []
    for _ in range(3):
        t = np.arange(0.0, 200.0, sparse.STEP)
        T = 296.0 + 50.0 * np.abs(np.sin(2 * np.pi * t / rng.uniform(60.0, 90.0)))
        F, H = np.full(t.size, 0.6), 0.15 - 0.0008 * (T - 296.0) + 0.01 * np.sin(t / 7.0)
        s = sparse.State(t, T, T - 296.0, np.gradient(T, sparse.STEP), F, H, H[0] - H, F, np.zeros(t.size, dtype=int))
        noise = 0.002 * rng.standard_normal(t.size)
        examples.append((s, 0.8 * (H / H[0] - 1.0) + noise, np.zeros(t.size)))
        silent.append((s, noise, np.zeros(t.size)))
    found = sparse.stage(sparse.ELECTRICAL, examples)
    assert [effect for _, effect in found.names()] == ['resistance_strain']
    assert found.weights[list(sparse.ELECTRICAL).index('H/H0')] == pytest.approx(0.8, rel=0.05)
    assert sparse.stage(sparse.ELECTRICAL, silent).names() == []


def test_what_is_held_out_of_a_muscle_that_wears_comes_after_what_was_recorded(tmp_path):
    """Its truth goes on wearing; replayed as when it was new, the true muscle itself would be far off."""
    made = make_case('development', 5, 0, 'single', 'fatigue')
    label = write_case(made, tmp_path / 'cases', tmp_path / 'unseen')
    case = Case(tmp_path / 'cases' / made.name, 500)
    worn = alternatives.oracle(case, label).muscle
    (unseen,) = experiments_of(tmp_path / 'unseen' / made.name, case.nominal, case.most)
    now, new = (errors([replay(unseen, worn, before)])['displacement'] for before in (case.experiments, ()))
    assert now < 0.5 * new


def test_a_method_that_fails_keeps_no_other_from_being_run(tmp_path, monkeypatch):
    """The oracle is the 1 of the gap: without it the case would be in no score of what is held out."""
    made = make_case('development', 5, 1, 'null', '')
    label = write_case(made, tmp_path / 'cases')

    def fails(case, label):
        raise RuntimeError('singular')

    quick = alternatives.Outcome((), Case(tmp_path / 'cases' / made.name).nominal)
    monkeypatch.setattr(alternatives, 'RUNNERS', dict.fromkeys(alternatives.RUNNERS, lambda case, label: quick))
    assert next(iter(alternatives.RUNNERS)) == 'oracle'
    monkeypatch.setitem(alternatives.RUNNERS, 'whiteness_bic', fails)
    reports, names = tmp_path / 'reports', tuple(alternatives.RUNNERS)
    told = alternatives.run(tmp_path / 'cases' / made.name, reports, label, names=names)
    assert told == f'{made.name}, whiteness_bic: RuntimeError: singular'
    assert {path.parent.parent.name for path in reports.glob('*/*/report.json')} == {*names} - {'whiteness_bic'}
    assert 'singular' in (reports / 'whiteness_bic' / made.name / 'failed').read_text()


def test_an_answer_of_another_number_of_samples_is_made_anew(tmp_path, monkeypatch):
    made = make_case('development', 5, 1, 'null', '')
    label = write_case(made, tmp_path / 'cases')
    folder, reports, asked = tmp_path / 'cases' / made.name, tmp_path / 'reports', []
    quick = alternatives.Outcome((), Case(folder).nominal)
    monkeypatch.setitem(alternatives.RUNNERS, 'oracle', lambda case, label: asked.append(1) or quick)
    for most in (300, 300, 500):
        assert alternatives.run(folder, reports, label, names=['oracle'], most=most) is None
    assert len(asked) == 2


@pytest.fixture(scope='module')
def proven(tmp_path_factory):
    """A case through every phase, and once more over what is already there."""
    folder = tmp_path_factory.mktemp('proof')
    arguments = ['--cases', '1', '--seed', '8', '--output', str(folder), '--samples', '300', '--jobs', '1']
    assert prove.main(arguments) == 0
    return folder, arguments


@pytest.mark.long
def test_a_sample_is_proven_from_end_to_end(proven):
    folder, _ = proven
    for method in FOLDERS:
        answer = folder / 'reports' / method / 'case_0000'
        assert json.loads((answer / 'report.json').read_text())['verdict']
        assert (answer / 'held_out.json').is_file()
    told = json.loads((folder / 'scores.json').read_text())
    assert set(told['compared']) == set(FOLDERS)
    assert set(told['methods']) == {'diagnosis'}
    assert told['suite'] == 'development'
    assert 'it proves nothing' in (folder / 'proof.md').read_text()
    assert Case(folder / 'cases' / 'case_0000').experiments


@pytest.mark.long
def test_a_case_that_is_done_is_not_done_again(proven, capsys):
    folder, arguments = proven
    reports = sorted(folder.glob('reports/*/*/report.json'))
    before = [path.stat().st_mtime_ns for path in reports]
    reports[0].unlink()
    seal = (folder / 'cases' / 'SEAL').read_text()
    assert prove.main([*arguments, '--phase', 'generate', '--phase', 'alternatives', '--phase', 'diagnose']) == 0
    after = [path.stat().st_mtime_ns for path in reports]
    assert after[0] > before[0]
    assert after[1:] == before[1:]
    assert (folder / 'cases' / 'SEAL').read_text() == seal


def test_a_case_that_came_to_nothing_does_not_end_the_score(tmp_path):
    """It is a failure where others were done after it; what was under way when the run was stopped is none."""
    proof = prove.Proof('development', 6, 1, tmp_path, 2, 500)
    for k in range(6):
        (proof.bags / f'case_{k:04d}').mkdir(parents=True)
    for k in (0, 1, 3, 4):
        reports = proof.reports / 'diagnosis' / f'case_{k:04d}'
        reports.mkdir(parents=True)
        (reports / 'report.json').write_text('{}')
    assert proof.answered('diagnosis') == 5
    (proof.reports / 'diagnosis' / 'case_0004' / 'report.json').unlink()
    assert proof.answered('diagnosis') == 2


def test_the_other_methods_have_as_many_samples_as_the_diagnosis(tmp_path, monkeypatch):
    proof, had = prove.Proof('development', 1, 1, tmp_path, 1, 320), []
    proof.labels.write_text(json.dumps({'cases': [{'case': 'case_0000'}]}))
    monkeypatch.setattr(proof, '_each', lambda title, items, work: [work(item) for item in items])
    quick = alternatives.Outcome((), Case(tmp_path).nominal)
    monkeypatch.setattr(
        alternatives, 'RUNNERS', {'oracle': lambda case, label: had.append((case.name, case.most)) or quick}
    )
    monkeypatch.setattr(alternatives, 'experiments_of', lambda *_: [])
    proof.alternatives(['oracle'])
    assert had == [('case_0000', 320)]


def test_a_case_that_failed_last_is_scored_until_it_is_tried_again(tmp_path, monkeypatch):
    proof = prove.Proof('development', 3, 1, tmp_path, 2, 500)
    reports = proof.reports / 'diagnosis'

    def answers(folder, reports, most):
        (reports / folder.name).mkdir(parents=True, exist_ok=True)
        (reports / folder.name / 'report.json').write_text('{}')

    def fails(folder, reports, most):
        raise ArithmeticError('it runs away')

    for k, diagnosed in enumerate((answers, answers, fails)):
        (proof.bags / f'case_{k:04d}').mkdir(parents=True)
        monkeypatch.setattr(prove, 'diagnose_case', diagnosed)
        told = prove._diagnose(proof.bags, reports, 500, f'case_{k:04d}')
    assert told == 'case_0002: ArithmeticError: it runs away'
    assert proof.answered('diagnosis') == 3
    monkeypatch.setattr(prove, 'diagnose_case', answers)
    assert prove._diagnose(proof.bags, reports, 500, 'case_0002') is None
    assert not (reports / 'case_0002' / 'failed').exists()


@pytest.mark.parametrize(
    ('suite', 'cases', 'words'),
    [
        ('sealed', 0, []),
        ('sealed', 20, ['--cases', '20', '--suite', 'sealed']),
        ('development', 20, ['--cases', '20']),
        ('development', 0, ['--suite', 'development']),
        ('varied', 20, ['--cases', '20', '--suite', 'varied']),
    ],
)
def test_the_command_told_is_the_one_that_makes_this_suite(suite, cases, words, tmp_path):
    proof = prove.Proof(suite, cases, 3, tmp_path, 2, prove.MOST)
    assert prove.command(proof).split() == ['./scripts/prove', *words, '--seed', '3']
    assert proof.sealed == (suite == 'sealed')
