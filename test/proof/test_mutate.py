"""Damaged inputs at every command, up to the end of its gate; a thousand each by ``python -m proof.mutate``."""

import shutil

import pytest

from proof import mutate

TRIALS = 50


@pytest.fixture(scope='module')
def good(tmp_path_factory):
    folder = tmp_path_factory.mktemp('good')
    mutate.good_inputs(folder)
    return folder


@pytest.mark.parametrize('command', mutate.COMMANDS)
def test_damaged_inputs_are_admitted_or_refused_in_one_line_and_nothing_is_overwritten(command, good):
    ended = {seed: mutate.trial(command, seed, good) for seed in range(TRIALS)}
    assert {seed: (trial.damages, trial.wrong) for seed, trial in ended.items() if trial.wrong} == {}
    assert {trial.code for trial in ended.values()} == {0, 2}


@pytest.mark.parametrize('command', mutate.COMMANDS)
def test_the_inputs_that_are_damaged_are_good(command, good, tmp_path, monkeypatch):
    shutil.copytree(good, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    line, _ = mutate.COMMANDS[command]
    with mutate.answering(tmp_path / 'answers.txt'):
        assert mutate.tool([command.split()[0], *line], until_admitted=True) == 0


def test_what_must_not_be_is_seen():
    before = {'a': '1', 'b': ''}
    assert mutate._wrong(2, '', 'no\n', before, before) == ''
    assert 'exit code 1' in mutate._wrong(1, '', 'internal error: x\n', before, before)
    assert 'changed: a' in mutate._wrong(0, '', '', before, {'a': '2', 'b': ''})
    assert 'left behind: c' in mutate._wrong(2, '', 'no\n', before, {**before, 'c': ''})
    assert '2 lines' in mutate._wrong(2, '', 'no\nno\n', before, before)
    assert 'traceback' in mutate._wrong(2, '', 'Traceback (most recent call last)', before, before)
