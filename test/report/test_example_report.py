"""The worked example of docs/reading_a_report.md is what the tool does."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_the_worked_example_finds_what_was_hidden_and_the_document_shows_it(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / 'scripts'))
    text, report = __import__('example_report').make(tmp_path)
    del sys.modules['example_report']
    assert report['verdict'] == 'missing_physics'
    (found,) = report['findings']
    assert found['effect'] == 'creep' and set(found['improvement']) == {'displacement'}
    share = found['parameters']['J']
    assert share['low'] < 0.25 < share['high']
    document = (ROOT / 'docs' / 'reading_a_report.md').read_text()
    shown = re.search(r'<!-- table: terminal -->\n```\n(.*?)\n```', document, re.DOTALL)[1]
    assert [line.split()[0] for line in shown.splitlines()[3:]] == [line.split()[0] for line in text.splitlines()[3:]]
    errors, explained = report['fit']['displacement'], (ROOT / 'docs' / 'diagnosis.md').read_text()
    falls = {'rmse_nominal': "the paper's parameters", 'rmse_calibrated': 'calibrated, no new physics (step 3)'}
    for error, what in falls.items():
        assert f'| {what} | {1e3 * errors[error]:.2f} mm |' in explained


def test_the_explanation_keeps_to_three_pages_and_its_rates_are_those_of_the_proof():
    explained, proof = ((ROOT / 'docs' / name).read_text() for name in ('diagnosis.md', 'proof.md'))
    assert len(explained.split()) <= 3 * 700
    scores = (
        'false physics on nulls',
        'decoys named as physics',
        'single named first',
        'two effects, exactly',
        'two effects, one at least',
        'three effects, exactly',
        'unlisted flagged',
        'unlisted given a false name',
    )
    for score in scores:
        right, of = re.search(rf'^\| {score} \|.*?\| (\d+)/(\d+) \|', proof, re.MULTILINE).groups()
        assert re.search(rf'\b{right} of\s{of}\b', explained), score
