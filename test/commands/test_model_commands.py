"""simulate, calibrate and replay as a user runs them: what they write, and the one line for what is wrong."""

import json
import resource
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import partial
from io import StringIO

import numpy as np
import pytest
import yaml

from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.tool import main

PROTOCOL = """
rate_hz: 20
input: current
repeat: 2
segments:
  - {duration_s: 25, value: 0.25, load_n: 0.5884}
  - {duration_s: 45, value: 0}
"""
MUSCLE = """
/**:
  ros__parameters:
    hA: 0.022
    R0: 13.0
    B: 1.5
    seed: 3
    temperature_noise_k: 0.2
    resistance_noise_ohm: 0.02
    displacement_noise_m: 5.0e-5
    min_sense_current_a: 0.01
"""


def tool(*arguments):
    """Exit code and what was said, in this process: a start of Python costs more than most of these commands."""
    with redirect_stdout(StringIO()) as out, redirect_stderr(StringIO()) as errors:
        code = main([str(word) for word in arguments])
    return code, out.getvalue(), errors.getvalue()


def process(*arguments, disk=None):
    """The same as a process of its own. ``disk``: bytes beyond which no file grows."""
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    done = subprocess.run(
        [sys.executable, '-m', 'tcp_muscle_ros.tool', *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=disk and (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (disk, hard))),
    )
    return done.returncode, done.stdout, done.stderr


def refused(*arguments, printed='', run=tool):
    """The one line against it; nothing was printed before, unless the mistake shows itself only after the work."""
    code, out, errors = run(*arguments)
    assert code == 2, errors
    assert out.startswith(printed) and (printed or not out), out
    lines = errors.strip().splitlines()
    assert len(lines) == 1, errors
    assert 'Traceback' not in errors
    return lines[0]


@pytest.fixture(scope='module')
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp('made')
    (folder / 'protocol.yaml').write_text(PROTOCOL)
    (folder / 'muscle.yaml').write_text(MUSCLE)
    code, _, errors = process('simulate', folder / 'protocol.yaml', '--output', folder / 'plain')
    assert code == 0, errors
    code, _, errors = tool(
        'simulate', folder / 'protocol.yaml', '--params', folder / 'muscle.yaml', '--output', folder / 'noisy'
    )
    assert code == 0, errors
    return folder


def test_a_simulated_bag_replays_to_nothing(made):
    code, printed, _ = tool('replay', made / 'plain', '--params', 'karami_tadesse_2017')
    assert code == 0
    for line in printed.splitlines()[2:]:
        channel, _, rmse, *_ = line.split()
        assert float(rmse) < 1e-9, channel


def test_simulated_sensors_are_seeded_and_resistance_needs_current(made):
    bag = read_bag(made / 'noisy')
    assert len(bag['resistance']) < 0.4 * len(bag['temperature'])
    assert 0.1 < np.std(np.diff(bag['temperature'].value[:100])) < 0.6
    again = made / 'again'
    assert tool('simulate', made / 'protocol.yaml', '--params', made / 'muscle.yaml', '--output', again)[0] == 0
    assert np.array_equal(read_bag(again)['temperature'].value, bag['temperature'].value)


def test_a_calibrated_file_loads_replays_to_the_noise_and_carries_its_intervals(made):
    out = made / 'mine.yaml'
    code, printed, errors = tool('calibrate', made / 'noisy', '--output', out)
    assert code == 0, errors
    assert 'B c1 and B c2' in printed  # three symbols of which recordings see two
    values = yaml.safe_load(out.read_text())['/**']['ros__parameters']
    assert values['hA'] == pytest.approx(0.022, rel=0.01)
    intervals = {p['name']: p for p in json.loads((made / 'mine.intervals.json').read_text())['parameters']}
    assert intervals['R0']['low'] < 13.0 < intervals['R0']['high']
    figure, bag = made / 'mine.png', made / 'replayed'
    code, printed, _ = tool('replay', made / 'noisy', '--params', out, '--figure', figure, '--output', bag)
    assert code == 0
    rmse = {line.split()[0]: float(line.split()[2]) for line in printed.splitlines()[2:5]}
    assert rmse['temperature'] == pytest.approx(0.2, rel=0.1)
    assert rmse['displacement'] == pytest.approx(0.05, rel=0.15)  # mm
    assert figure.read_bytes().startswith(b'\x89PNG')
    predicted = read_bag(bag, namespace='predicted')
    recorded = read_bag(bag, namespace='recorded')
    assert np.std(predicted['temperature'].value - recorded['temperature'].value) < 0.25
    low, high = (read_bag(bag, namespace=f'predicted_{side}')['temperature'].value for side in ('low', 'high'))
    assert np.all(low <= high) and np.any(low < predicted['temperature'].value)


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('/**:\n  ros__parameters:\n    ha: 0.02\n', "'hA'"),
        ('/**:\n  ros__parameters:\n    H0: 150\n', '0.001 to 10 m'),
        ('/**:\n  ros__parameters:\n    hA: .nan\n', 'finite number in W/K'),
        ('/**:\n  ros__parameters:\n    T0: 296.15\n', 'degC'),
        ('/**:\n  ros__parameters:\n    hA: 20 mW/K\n', 'expected a number in W/K'),
        ('/**:\n  ros__parameters:\n    effects: [crep]\n', "did you mean 'creep'"),
        ('/**:\n  ros__parameters:\n    effects: creep\n', 'expected a list of names'),
        ('/**:\n  ros__parameters:\n   hA: [\n', 'does not parse as YAML in line'),
        ('/**:\n  ros__parameters:\n    ambient_temperature_c: 296.15\n', 'is 296.15; expected -40 to 100 degC'),
        ('hA: 0.02\n', 'ros__parameters'),
        ('', 'no parameters'),
    ],
)
def test_a_wrong_parameter_file_is_one_line(made, tmp_path, text, line):
    file = tmp_path / 'wrong.yaml'
    file.write_text(text)
    said = refused('replay', made / 'plain', '--params', file)
    assert line in said
    assert 'wrong.yaml' in said


def test_missing_and_existing_files_are_one_line(made, tmp_path):
    assert 'nothere' in refused('replay', tmp_path / 'nothere', '--params', 'karami_tadesse_2017', run=process)
    assert 'nothere.yaml' in refused('replay', made / 'plain', '--params', tmp_path / 'nothere.yaml')
    assert 'plain' in refused('simulate', made / 'protocol.yaml', '--output', made / 'plain')
    assert 'folder' in refused('calibrate', made / 'plain', '--output', tmp_path / 'no' / 'mine.yaml')
    for command in ('calibrate', 'diagnose'):
        assert 'expected one of' in refused(command, made / 'plain', '--output', tmp_path / 'mine', '--separate', 'b')
    (tmp_path / 'empty.mcap').write_bytes(b'')
    assert 'empty.mcap' in refused('replay', tmp_path / 'empty.mcap', '--params', 'karami_tadesse_2017')


@pytest.mark.parametrize(
    ('option', 'line'),
    [
        (['calibrate', '--output', '.'], '.: is a folder; expected the name of a file'),
        (['calibrate', '--output', 'taken.yaml'], 'taken.intervals.json: is a folder; expected the name of a file'),
        (
            ['calibrate', '--output', 'run.mcap', 'run.mcap'],
            'run.mcap: is read, and nothing that is read is overwritten',
        ),
        (['replay', '--figure', 'nowhere/x.png'], 'nowhere/x.png: its folder does not exist'),
        (['replay', '--figure', 'x.foo'], 'x.foo: no kind of picture; expected x.png, or .pdf'),
        (['replay', '--figure', 'x'], 'x: no kind of picture; expected x.png, or .pdf'),
        (['replay', '--output', 'run.mcap/bag'], 'run.mcap is a file; expected a folder'),
    ],
    ids=lambda words: ' '.join(words) if isinstance(words, list) else '',
)
def test_where_nothing_can_be_written_is_said_before_the_work(made, tmp_path, monkeypatch, option, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'taken.intervals.json').mkdir()
    (tmp_path / 'run.mcap').write_bytes(next((made / 'plain').glob('*.mcap')).read_bytes())
    command, *more = option
    params = ['--params', 'karami_tadesse_2017']
    assert line in refused(command, *([] if 'run.mcap' in more[2:] else [made / 'plain']), *more, *params)


def test_a_disk_that_is_full_at_the_end_is_one_line_and_leaves_the_old_file_whole(made, tmp_path):
    old = {name: tmp_path / name for name in ('full.yaml', 'full.intervals.json', 'full.png')}
    for file in old.values():
        file.write_text('old')
    bag, force = made / 'noisy', ['--force', '--params', 'karami_tadesse_2017']
    full = partial(process, disk=1000)
    said = refused('calibrate', bag, '--output', old['full.yaml'], *force, printed='parameter', run=full)
    assert said.endswith('full.yaml: cannot be written (File too large)')
    said = refused('replay', bag, '--figure', old['full.png'], *force, printed='channel', run=full)
    assert 'full.png: cannot be written (' in said
    assert {file.read_text() for file in tmp_path.iterdir()} == {'old'}
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(old)


@pytest.mark.parametrize(
    'command',
    [
        ['calibrate', 'noisy', '--output', 'there.yaml'],
        ['calibrate', 'noisy', '--output', 'other.yaml'],
        ['replay', 'plain', '--figure', 'there.png'],
        ['replay', 'plain', '--output', 'there'],
        ['simulate', 'protocol.yaml', '--output', 'there'],
        ['diagnose', 'plain', '--output', 'there'],
    ],
    ids=' '.join,
)
def test_no_command_replaces_what_is_there_unless_it_is_told_to(made, tmp_path, command):
    name, given, option, output = command
    (tmp_path / 'there').mkdir()
    old = ['there.yaml', 'other.intervals.json', 'there.png', 'there/mine']
    for file in old:
        (tmp_path / file).write_text('old')
    said = refused(name, made / given, option, tmp_path / output, '--params', 'karami_tadesse_2017')
    assert 'is not overwritten; give another' in said and '--force' in said
    assert {(tmp_path / file).read_text() for file in old} == {'old'}
    assert len(list(tmp_path.iterdir())) == 4


def test_forced_a_bag_and_a_figure_take_the_place_of_the_old(made, tmp_path):
    out, figure = tmp_path / 'bag', tmp_path / 'there.png'
    figure.write_text('old')
    assert tool('simulate', made / 'protocol.yaml', '--output', out)[0] == 0
    params = ['--params', 'karami_tadesse_2017']
    assert tool('replay', made / 'plain', *params, '--output', out, '--figure', figure, '--force')[0] == 0
    assert figure.read_bytes().startswith(b'\x89PNG')
    assert 'temperature' in read_bag(out, namespace='predicted')
    assert sorted(file.name for file in tmp_path.iterdir()) == ['bag', 'there.png']


def test_a_replay_does_not_replace_the_report_whose_rig_it_reads(made, tmp_path, capsys):
    report = tmp_path / 'report'
    report.mkdir()
    (report / 'report.json').write_text('{"schema": "tcp_muscle_ros/diagnosis-2"}')
    (report / 'rig.yaml').write_text('instruments: {temperature: {gain: 0.96}}\n')
    options = ['--params', 'karami_tadesse_2017', '--rig', str(report / 'rig.yaml')]
    assert main(['replay', str(made / 'plain'), *options, '--output', str(report), '--force']) == 2
    assert 'rig.yaml, which is read, and nothing that is read is overwritten' in capsys.readouterr().err
    assert (report / 'rig.yaml').exists()


OURS = '{"schema": "tcp_muscle_ros/calibration-1"'


@pytest.mark.parametrize(
    'text', ['', '{', '[]', '\xff', OURS + '}', OURS + ', "covariance": [["x"]], "coordinates": [{"name": "hA"}]}']
)
def test_damaged_intervals_are_one_line(made, tmp_path, capsys, text):
    (tmp_path / 'mine.yaml').write_text(MUSCLE)
    (tmp_path / 'mine.intervals.json').write_text(text, encoding='latin-1')
    assert main(['replay', str(made / 'plain'), '--params', str(tmp_path / 'mine.yaml')]) == 2
    assert 'mine.intervals.json: damaged; calibrate or diagnose again, or remove it' in capsys.readouterr().err


def test_a_replay_fits_the_zero_of_a_recording_and_says_so(made, tmp_path):
    # The muscle is right; the encoder was set to zero somewhere else.
    recording = read_bag(str(made / 'plain'))
    stroke = recording['displacement']
    channels = {**recording.channels, 'displacement': replace(stroke, value=stroke.value + 3e-3)}
    write_recording(tmp_path / 'moved', replace(recording, channels=channels))
    code, printed, _ = tool('replay', tmp_path / 'moved', '--params', 'karami_tadesse_2017')
    assert code == 0
    assert 'displacement +3 mm where the model has its zero' in printed
    assert 'this need not be an offset of an instrument' in printed
    fitted = next(line for line in printed.splitlines() if line.startswith('displacement')).split()
    assert float(fitted[2]) < 0.01  # mm
    code, printed, _ = tool('replay', tmp_path / 'moved', '--params', 'karami_tadesse_2017', '--as-given')
    assert code == 0
    as_given = next(line for line in printed.splitlines() if line.startswith('displacement')).split()
    assert float(as_given[2]) == pytest.approx(3.0, abs=0.01)
