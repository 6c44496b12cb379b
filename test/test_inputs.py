"""Inputs that are no regular files: each command says what they are, and none waits for what never comes."""

import os
import signal
from contextlib import contextmanager

import pytest

import tcp_muscle_ros as tcp
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.settings.parameter_file import read
from tcp_muscle_ros.tool import main

_PATIENCE_S = 60


@contextmanager
def in_time():
    """A read that waits for ever ends as a failure."""

    def end(*_):
        raise AssertionError(f'still waiting after {_PATIENCE_S} s')

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(_PATIENCE_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize('name', ['run.csv', 'run.xlsx', 'run.mcap', 'run'])
@pytest.mark.parametrize(
    'command',
    [
        ['import'],
        ['info'],
        ['export', '--csv', 'table.csv'],
        ['plot', '--output', 'run.png'],
        ['replay', '--params', 'karami_tadesse_2017'],
        ['calibrate', '--output', 'mine.yaml'],
        ['diagnose', '--output', 'report'],
    ],
    ids=lambda words: words[0],
)
def test_a_pipe_is_said_to_be_a_pipe(tmp_path, monkeypatch, capsys, command, name):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(name)
    with in_time():
        assert main([*command[:1], name, *command[1:]]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if not line.startswith('diagnosing: ')]
    assert f'{name}: is a pipe, not a regular file; write what comes through it to a file and give that' in line
    assert os.listdir() == [name]


@pytest.mark.parametrize('name', ['run.csv', 'run.mcap'])
def test_a_pipe_is_said_to_be_one_in_python(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with in_time(), pytest.raises(BadInput, match='is a pipe, not a regular file'):
        tcp.load(tmp_path / name)


def test_a_pipe_in_a_manifest_fails_its_run_alone(tmp_path, capsys):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'runs.yaml').write_text('runs: [{name: first, bags: [pipe]}]')
    with in_time():
        code = main(['diagnose', '--manifest', str(tmp_path / 'runs.yaml'), '--output', str(tmp_path / 'all')])
    assert code == 2
    assert 'is a pipe, not a regular file' in ''.join(capsys.readouterr())


def test_other_things_than_files_are_named(tmp_path, capsys):
    (tmp_path / 'bag').symlink_to('gone')
    for path, said in (
        ('/dev/null', 'is not a regular file; expected a bag'),
        (tmp_path / 'bag', 'a link to gone, which'),
    ):
        with in_time():
            assert main(['info', str(path)]) == 2
        assert said in capsys.readouterr().err


def test_of_a_folder_in_place_of_a_parameter_file_it_says_which_files_are_in_it(tmp_path):
    with pytest.raises(BadInput, match=r'cannot read the parameter file: Is a directory$'):
        read(tmp_path)
    for name in ('rig.yaml', 'improved.yaml', 'report.json'):
        (tmp_path / name).write_text('')
    with pytest.raises(BadInput, match=r'Is a directory, which holds improved\.yaml, rig\.yaml$'):
        read(tmp_path)
