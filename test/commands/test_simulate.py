"""``tcp_muscle simulate``: piece by piece, in bounded memory, with a word on what is not to be believed."""

import os
import re
import resource
import subprocess
import sys
import threading

import numpy as np
import pytest

from tcp_muscle_ros.commands import progress
from tcp_muscle_ros.commands import simulate as command
from tcp_muscle_ros.muscle import simulate
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.protocol import read_protocol
from tcp_muscle_ros.settings.parameter_file import read
from tcp_muscle_ros.tool import main

MUSCLE = """
/**:
  ros__parameters:
    effects: [creep, hysteresis, two_node, supply_lag]
    seed: 3
    temperature_noise_k: 0.2
    displacement_quantum_m: 1.0e-5
    force_lag_s: 0.3
"""


@pytest.fixture
def run(tmp_path, capsys):
    """Simulates a protocol; returns (exit code, what was said)."""

    def run(segments, *options, muscle='', rate=20):
        (tmp_path / 'protocol.yaml').write_text(f'rate_hz: {rate}\ninput: current\nsegments: {segments}\n')
        if muscle:
            (tmp_path / 'muscle.yaml').write_text(muscle)
            options = ['--params', tmp_path / 'muscle.yaml', *options]
        code = main(
            ['simulate', str(tmp_path / 'protocol.yaml'), '--output', str(tmp_path / 'bag'), *map(str, options)]
        )
        out, err = capsys.readouterr()
        return code, out + err

    return run


def test_long_work_says_how_far_it_has_come(run, monkeypatch):
    monkeypatch.setattr(command, '_PIECE', 100)
    segments = '[{duration_s: 50, value: 0.2}]'
    assert 'simulating' not in run(segments)[1]  # within two seconds
    monkeypatch.setattr(progress, '_FIRST', 0.0)
    monkeypatch.setattr(progress, '_BETWEEN', 0.0)
    code, said = run(segments, '--force')
    told = [int(far) for far in re.findall(r'^simulating: (\d+) of 50 s, \d+ s$', said, re.MULTILINE)]
    assert code == 0 and told == [*range(5, 51, 5), 50]  # the end is a piece of one instant


def test_pieces_are_the_whole_to_the_last_bit(run, tmp_path, monkeypatch):
    segments = (
        '[{duration_s: 20, value: 0.25, load_n: 0.6}, {duration_s: 15, value: [0.2, 0], load_n: 1, ambient_c: 25}]'
    )
    monkeypatch.setattr(command, '_PIECE', 97)
    assert run(segments, muscle=MUSCLE)[0] == 0
    in_pieces = read_bag(tmp_path / 'bag')
    monkeypatch.setattr(command, '_PIECE', 10_000)
    assert run(segments, '--force', muscle=MUSCLE)[0] == 0
    whole = read_bag(tmp_path / 'bag')
    assert in_pieces.channels.keys() == whole.channels.keys()
    for name, channel in whole.channels.items():
        np.testing.assert_array_equal(in_pieces[name].time, channel.time)
        np.testing.assert_array_equal(in_pieces[name].value, channel.value)
    sampled = read_protocol(tmp_path / 'protocol.yaml').sampled()
    ideal = simulate(
        read(tmp_path / 'muscle.yaml').parameters,
        sampled.time, sampled.drive, load=sampled.load, ambient=sampled.ambient,
    )  # fmt: skip
    np.testing.assert_array_equal(in_pieces['resistance'].value, ideal.resistance)
    assert in_pieces.known['load_n'] == 0.6


def test_the_seed_is_that_of_the_option_before_that_of_the_file(run, tmp_path):
    noise = {}
    for options in ((), ('--seed', 3), ('--seed', 4)):
        assert run('[{duration_s: 5, value: 0}]', '--force', *options, muscle=MUSCLE)[0] == 0
        noise[options] = read_bag(tmp_path / 'bag')['temperature'].value
    np.testing.assert_array_equal(noise[()], noise['--seed', 3])
    assert not np.array_equal(noise[()], noise['--seed', 4])
    assert run('[{duration_s: 5, value: 0}]', '--force', '--seed', '-1') == (
        2,
        'tcp_muscle simulate: --seed -1: expected a whole number of 0 or more\n',
    )


def test_the_instruments_of_a_rig_are_shown_whether_it_is_named_or_in_the_file(run, tmp_path):
    """As sim_node does: ``improved.yaml`` alone has ideal sensors."""
    segments = '[{duration_s: 5, value: 0.25}, {duration_s: 10, value: 0}]'
    (tmp_path / 'rig.yaml').write_text('instruments: {temperature: {lag_s: 2.0}, displacement: {offset_m: 1.0e-3}}\n')
    shown = []
    named = f'/**:\n  ros__parameters:\n    rig_file: {tmp_path / "rig.yaml"}\n'
    for options, muscle in (((), ''), (('--rig', tmp_path / 'rig.yaml'), ''), ((), named)):
        assert run(segments, '--force', *options, muscle=muscle)[0] == 0
        shown.append(read_bag(tmp_path / 'bag'))
    ideal, by_option, by_file = shown
    for name in ('temperature', 'displacement'):
        np.testing.assert_array_equal(by_option[name].value, by_file[name].value)
    np.testing.assert_allclose(by_option['displacement'].value - ideal['displacement'].value, 1e-3, atol=1e-9)
    assert ideal['temperature'].value.max() - by_option['temperature'].value.max() > 2.0
    code, said = run(segments, '--force', '--rig', tmp_path / 'no_rig.yaml')
    assert code == 2 and 'no_rig.yaml' in said


@pytest.mark.parametrize(
    ('segment', 'told'),
    [
        ('value: -0.2', 'value is -0.2, expected >= 0'),
        ('value: 5000', 'segments 1: current is 5000, expected 0 to 1000 A, as sim_node'),
        ('value: 0.2, load_n: 1e6', 'segments 1: load_n is 1e+06, expected 0 to 1000 N, as sim_node'),
        ('value: 0.2, ambient_c: 296', 'segments 1: ambient_c is 296, expected -40 to 100 degC, as sim_node'),
        ('value: 900, duration_s: 300', 'the model has no finite answer from'),
    ],
)
def test_what_no_node_takes_is_refused(run, tmp_path, segment, told):
    code, said = run(f'[{{duration_s: 30, {segment}}}]' if 'duration_s' not in segment else f'[{{{segment}}}]')
    assert code == 2
    assert told in said and said.count('\n') == 1
    assert not (tmp_path / 'bag').exists()


@pytest.mark.parametrize(
    ('segment', 'told'),
    [
        ('value: 0.45', 'outside 0 to 120 degC, where the model is not valid'),
        ('value: 0.7', 'hotter than 255 degC, at which nylon melts: no real muscle does what is simulated there'),
        ('value: 0, load_n: 100', 'from 0 s on the muscle is more than 3 times its own length'),
    ],
)
def test_what_is_not_to_be_believed_is_said_in_few_digits(run, segment, told):
    code, said = run(f'[{{duration_s: 60, {segment}}}]')
    assert code == 0
    assert told in said
    assert max(len(line) for line in said.replace(':', '\n').splitlines()) < 140


def test_a_parameter_of_an_effect_that_is_not_on_is_said_to_do_nothing(run):
    given = 'effects: [radiation]\n    natural_convection.n: 0.3\n    radiation.eps: 0.8\n'
    muscle = f'/**:\n  ros__parameters:\n    {given}'
    code, said = run('[{duration_s: 1, value: 0.1}]', muscle=muscle)
    told = 'note: natural_convection.n has no effect: natural_convection is not among effects: [radiation]'
    assert code == 0 and [line for line in said.splitlines() if 'has no effect' in line] == [told]


def test_a_long_protocol_takes_no_more_memory_than_a_short_one(tmp_path):
    peak = {}
    # The first may have to compile the model, which takes memory too. VmHWM is the program's own: what getrusage tells
    # counts the memory of who started it.
    for minutes in (1, 1, 40):
        text = f'{{rate_hz: 200, input: current, repeat: {minutes}, segments: [{{duration_s: 60, value: 0.2}}]}}'
        (tmp_path / 'protocol.yaml').write_text(text)
        ask = (
            'import sys; from tcp_muscle_ros.tool import main; code = main(sys.argv[1:]);'
            'peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"));'
            'print(peak.split()[1]); sys.exit(code)'
        )
        words = ['simulate', tmp_path / 'protocol.yaml', '--output', tmp_path / f'bag_{minutes}', '--force']
        done = subprocess.run([sys.executable, '-c', ask, *map(str, words)], capture_output=True, text=True, check=True)
        peak[minutes] = int(done.stdout.split()[-1]) / 1024.0
    assert peak[40] - peak[1] < 60.0, peak  # MB; 480,001 ticks of nine channels, which were 330 MB more
    assert peak[40] < 300.0, peak


@pytest.mark.parametrize('option', ['protocol', 'params'])
def test_a_pipe_that_nobody_writes_to_is_one_line_and_one_that_somebody_does_is_read(
    tmp_path, capsys, option, monkeypatch
):
    monkeypatch.setattr('tcp_muscle_ros.files.inputs._PATIENCE_S', 0.2)
    text = {
        'protocol': 'rate_hz: 5\ninput: current\nsegments: [{duration_s: 1, value: 0}]\n',
        'params': '/**:\n  ros__parameters:\n    hA: 0.02\n',
    }
    paths = {name: tmp_path / f'{name}.yaml' for name in text}
    for name, path in paths.items():
        path.write_text(text[name])
    paths[option] = tmp_path / 'pipe'
    os.mkfifo(paths[option])
    words = ['simulate', str(paths['protocol']), '--params', str(paths['params']), '--output', str(tmp_path / 'bag')]
    assert main(words) == 2
    assert 'pipe: ' in (said := capsys.readouterr().err) and 'a pipe that nothing comes through' in said
    writer = threading.Thread(target=paths[option].write_text, args=[text[option]])
    writer.start()
    monkeypatch.setattr('tcp_muscle_ros.files.inputs._PATIENCE_S', 10.0)
    assert main(words) == 0, capsys.readouterr().err
    writer.join()


def test_a_full_disk_leaves_the_old_bag(run, tmp_path):
    assert run('[{duration_s: 5, value: 0}]')[0] == 0
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
    try:
        code, said = run('[{duration_s: 500, value: 0}]', '--force')
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert code == 2 and 'bag: cannot be written (File too large)' in said
    assert read_bag(tmp_path / 'bag').duration == 5.0
