"""``tcp_muscle info``, ``plot`` and ``export``."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.inputs import hold
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.report.recording_figure import draw_recordings
from tcp_muscle_ros.tool import main

TIME = np.arange(200) / 20


@pytest.fixture
def bag(tmp_path):
    """A bag of 10 s with seven channels, the resistance at half the rate."""
    warm = 20 * (1 - np.exp(-TIME / 4))
    values = {
        'current': np.where(TIME < 2, 0.0, 0.25),
        'current_command': np.where(TIME < 2, 0.0, 0.26),
        'load': np.where(TIME < 5, 0.6, 0.9),
        'ambient': 296.15 + 0.001 * TIME,
        'temperature': 296.15 + warm,
        'displacement': 1e-4 * warm,
        'force': 0.6 + 1e-3 * warm,
    }
    channels = {name: Channel(name, TIME, value, f'/{name}') for name, value in values.items()}
    channels['resistance'] = Channel('resistance', TIME[::2], 7.8 + 0.01 * warm[::2], '/resistance')
    path = tmp_path / 'run'
    write_recording(path, Recording(str(path), channels, 10**18, {'rest_length_m': 0.15}))
    return path


def test_info_says_what_is_in_it(bag, capsys):
    assert main(['info', str(bag)]) == 0
    shown = capsys.readouterr().out
    assert f'{bag}: 9.95 s, 8 channels' in shown
    assert 'known: rest_length_m = 0.15' in shown
    row = next(line.split() for line in shown.splitlines() if line.strip().startswith('resistance'))
    assert row == ['resistance', '/resistance', '100', '10', 'Hz', '7.8', '7.983', 'ohm', 'output']


@pytest.mark.parametrize('kind', ['csv', 'parquet'])
def test_what_is_exported_is_imported_again_without_a_map(bag, tmp_path, kind):
    table = tmp_path / f'out.{kind}'
    assert main(['export', str(bag), f'--{kind}', str(table)]) == 0
    assert main(['import', str(table), '--output', str(tmp_path / 'again')]) == 0
    first, second = read_bag(bag), read_bag(tmp_path / 'again' / 'out')
    assert set(first) == set(second)
    for name in first:
        np.testing.assert_allclose(second[name].time, first[name].time, atol=1e-9)
        np.testing.assert_allclose(second[name].value, first[name].value, rtol=1e-7)
    assert main(['export', str(bag), f'--{kind}', str(table)]) == 2  # nothing is overwritten


def test_the_times_of_a_long_recording_come_back_to_the_nanosecond(tmp_path):
    """Topics without stamps, each a few microseconds after the other: after 1000 s their rows shared a time."""
    hours = np.arange(0.0, 36_000.0, 20.0)
    late = {'current': 0.0, 'temperature': 3e-6, 'displacement': 5e-6}
    channels = {name: Channel(name, hours + by, np.sin(hours), f'/{name}') for name, by in late.items()}
    write_recording(tmp_path / 'run', Recording('run', channels, 10**18))
    assert main(['export', str(tmp_path / 'run'), '--csv', str(tmp_path / 'out.csv')]) == 0
    assert main(['import', str(tmp_path / 'out.csv'), '--output', str(tmp_path / 'again')]) == 0
    first, second = read_bag(tmp_path / 'run'), read_bag(tmp_path / 'again' / 'out')
    for name in ('temperature', 'displacement'):
        np.testing.assert_allclose(second[name].time, first[name].time, rtol=0, atol=2e-9)
    lines = (tmp_path / 'out.csv').read_text().splitlines()
    assert [line.partition(',')[0] for line in lines[1:6]] == ['0', '0.000003', '0.000005', '20', '20.000003']


def test_a_load_that_is_stated_in_words_is_exported_and_what_is_odd_is_said_at_import(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = ''.join(f'{t / 10},{250 * (t > 20)},{23 + t / 20},{t / 100}\n' for t in range(100))
    Path('run.csv').write_text('Weight: 60 g\n\ntime_s,current (A),temperature_c,displacement_mm\n' + rows)
    assert main(['import', 'run.csv', '--output', 'lab']) == 0
    assert '  check: current is about 250 A, which is no plausible value' in capsys.readouterr().out
    assert main(['export', 'lab/run', '--csv', 'again.csv']) == 0
    assert main(['import', 'again.csv', '--output', 'again']) == 0
    np.testing.assert_allclose(read_bag('again/again')['load'].value, 0.588399)


def write_lab_file(folder, column, value):
    """A file ``h.csv`` of ten seconds, with a current and what a column shows at each tenth of a second."""
    rows = ''.join(f'{t / 10},{0.25 * (t > 20)},{value(t)}\n' for t in range(100))
    (folder / 'h.csv').write_text(f'time_s,current_A,{column}\n{rows}')


def test_a_unit_that_import_asks_for_is_one_that_it_takes(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_lab_file(tmp_path, 'displacement_m', lambda t: min(t, 60) / 5)
    assert main(['import', 'h.csv', '--output', 'lab']) == 0
    shown = capsys.readouterr().out
    assert 'say --unit displacement=mm; if it is something else' in shown
    assert 'name the right column in lab/import_map.yaml (--map)' in shown and '--channel' not in shown
    assert main(['import', 'h.csv', '--output', 'right', '--unit', 'displacement=mm']) == 0
    assert 'no plausible value' not in capsys.readouterr().out
    np.testing.assert_allclose(read_bag('right/h')['displacement'].value[-1], 12e-3)
    assert main(['import', 'h.csv', '--output', 'again', '--map', 'right/import_map.yaml']) == 0
    np.testing.assert_allclose(read_bag('again/h')['displacement'].value[-1], 12e-3)
    assert main(['import', 'h.csv', '--output', 'third', '--map', 'lab/import_map.yaml']) == 0
    assert 'say so in lab/import_map.yaml, unit: mm; if it is' in capsys.readouterr().out


def test_each_unit_that_may_be_meant_is_said_as_the_map_takes_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_lab_file(tmp_path, 'force_N', lambda t: 500 + min(t, 60))
    assert main(['import', 'h.csv', '--output', 'lab']) == 0
    assert 'say --unit force=mN or --unit force=g; if it is' in capsys.readouterr().out
    assert main(['import', 'h.csv', '--output', 'again', '--map', 'lab/import_map.yaml']) == 0
    assert 'say so in lab/import_map.yaml, unit: mN or g; if it is' in capsys.readouterr().out


@pytest.mark.parametrize(
    ('options', 'says'),
    [
        (['--unit', 'force=g'], '--unit force: no column is a channel of this name; known: current, displacement'),
        (['--unit', 'displacement=A'], "--unit displacement: 'A' is a unit of current, expected one of length: m"),
        (
            ['--unit', 'displacement=mm', '--map', 'm.yaml'],
            'change it there: m.yaml',
        ),
        (['--unti', 'displacement=mm'], "unrecognized argument: --unti; did you mean '--unit'?; see tcp_muscle import"),
    ],
)
def test_an_import_of_another_unit_that_cannot_be_is_refused(tmp_path, capsys, monkeypatch, options, says):
    monkeypatch.chdir(tmp_path)
    Path('h.csv').write_text('time_s,current_A,displacement_m\n' + ''.join(f'{t},0.1,{t}\n' for t in range(50)))
    try:
        code = main(['import', 'h.csv', '--output', 'lab', *options])
    except SystemExit as leave:
        code = leave.code
    assert code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert not Path('lab').exists()


def test_what_is_said_only_when_it_changes_is_exported_and_imported_again(tmp_path):
    path = tmp_path / 'run'
    seldom = {'load': ([0.0, 5.0, 7.0], [0.6, 0.9, 0.6]), 'current_command': ([0.1, 2.0], [0.0, 0.25])}
    channels = {name: Channel(name, np.array(t), np.array(v), f'/{name}') for name, (t, v) in seldom.items()}
    channels['current'] = Channel('current', TIME, np.where(TIME < 2, 0.0, 0.25), '/current')
    channels['temperature'] = Channel('temperature', TIME[::2], 296.15 + TIME[::2], '/temperature')
    write_recording(path, Recording(str(path), channels, 10**18))
    table = tmp_path / 'out.csv'
    assert main(['export', str(path), '--csv', str(table)]) == 0
    assert main(['import', str(table), '--output', str(tmp_path / 'again')]) == 0
    first, second = read_bag(path), read_bag(tmp_path / 'again' / 'out')
    assert set(first) == set(second)
    for name, sparse in (('load', True), ('current_command', True), ('temperature', False)):
        assert len(second[name]) > len(first[name]) if sparse else len(second[name]) == len(first[name])
        np.testing.assert_allclose(hold(second[name], first[name].time), first[name].value, rtol=1e-7)
    assert second['current_command'].time[0] == pytest.approx(0.1)  # nothing was said before


@pytest.mark.parametrize('options', [['--csv', '--output', 'F.csv'], ['--output', 'F.csv'], ['--csv', 'F.csv']])
def test_export_writes_where_it_is_told(bag, tmp_path, monkeypatch, options):
    monkeypatch.chdir(tmp_path)
    assert main(['export', str(bag), *options]) == 0
    assert Path('F.csv').read_text().startswith('time_s,')


@pytest.mark.parametrize(
    ('options', 'says'),
    [
        ([], 'which table? expected --csv, --parquet, or --output FILE.csv'),
        (['--output', 'F.xlsx'], 'F.xlsx: which table? expected --csv, --parquet, or --output FILE.csv'),
        (['--csv', 'F.csv', '--output', 'G.csv'], '--csv F.csv --output G.csv: two names for one table; expected one'),
    ],
)
def test_export_asks_which_table(bag, capsys, options, says):
    assert main(['export', str(bag), *options]) == 2
    assert capsys.readouterr().err.endswith(says + '\n')


def test_export_is_named_after_the_bag(bag, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(['export', str(bag), '--csv']) == 0
    assert (tmp_path / 'run.csv').read_text().startswith('time_s,')


def test_plot_draws_a_panel_a_channel(bag, tmp_path, capsys):
    picture = tmp_path / 'run.png'
    assert main(['plot', str(bag), str(bag), '--output', str(picture)]) == 0
    with Image.open(picture) as image:
        assert image.size == (990, 7 * 242)  # the commanded current is drawn with the current
        assert len(image.convert('RGB').getcolors(1 << 20)) > 10
    assert main(['plot', str(bag), '--output', str(picture)]) == 2


def test_recordings_of_one_name_and_of_strange_ones_are_told_apart_in_a_plot(bag, tmp_path):
    def named(*paths):
        recordings = [replace(read_bag(bag), path=path) for path in paths]
        drawn = draw_recordings(recordings)
        legend = drawn.axes[0].get_legend()
        colours = {line.get_color() for axis in drawn.axes for line in axis.get_lines()}
        assert colours == {line.get_color() for line in legend.get_lines()}
        return [text.get_text() for text in legend.get_texts()]

    assert named('lab/a/run', 'lab/b/run') == ['a/run', 'b/run']
    assert named('frame', 'frame') == ['frame (1)', 'frame (2)']
    assert named(*(f'{k}/x' for k in range(9))) == [f'{k}/x' for k in range(9)]
    assert named('_first', 'price $a^$ 2') == ['_first', r'price \$a^\$ 2']
    strange = tmp_path / 'price $a^$ 2'
    shutil.copytree(bag, strange)
    assert main(['plot', str(strange), str(bag), '--output', str(tmp_path / 'strange.png')]) == 0


def test_an_export_is_named_after_a_bag_with_a_dot_in_its_name(bag, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(bag, tmp_path / 'run_0.5A')
    assert main(['export', 'run_0.5A', '--csv']) == 0
    assert (tmp_path / 'run_0.5A.csv').is_file()


def test_plot_without_a_display_says_so(bag, monkeypatch, capsys):
    monkeypatch.delenv('DISPLAY', raising=False)
    monkeypatch.delenv('WAYLAND_DISPLAY', raising=False)
    assert main(['plot', str(bag)]) == 2
    assert 'no display for a window; draw to a file with --output' in capsys.readouterr().err


def test_a_folder_that_import_made_stands_for_the_bags_in_it(tmp_path, capsys, monkeypatch):
    """As does all that is in it: the map beside the bags is no bag."""
    monkeypatch.chdir(tmp_path)
    rows = ''.join(f'{t / 10},0.2,{23 + t / 20},{t / 100}\n' for t in range(100))
    for name in ('run_2', 'run_10'):
        Path(f'{name}.csv').write_text('time_s,current_a,temperature_c,displacement_mm\n' + rows)
    assert main(['import', 'run_10.csv', 'run_2.csv', '--output', 'lab']) == 0
    capsys.readouterr()
    for named in (['lab'], ['lab/import_map.yaml', 'lab/run_2', 'lab/run_10']):
        assert main(['info', *named]) == 0
        shown = capsys.readouterr().out
        assert 0 <= shown.index('lab/run_2: 9.9 s') < shown.index('lab/run_10: 9.9 s')
    assert main(['replay', 'lab', '--params', 'karami_tadesse_2017']) == 2
    assert 'bags in it: lab/run_10, lab/run_2' in capsys.readouterr().err
    assert main(['info', 'lab/import_map.yaml']) == 2


def test_a_recording_that_is_named_twice_counts_once(tmp_path, monkeypatch, capsys):
    """Else it would show how well the muscle repeats itself, and narrow the intervals."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'p.yaml').write_text(
        '{rate_hz: 5, input: current, repeat: 2, segments: [{duration_s: 5, value: 0}, {duration_s: 30, value: 0.2}]}'
    )
    for name in ('a', 'b'):
        assert main(['simulate', 'p.yaml', '--output', name]) == 0
    capsys.readouterr()
    assert main(['plot', 'b', 'a', './b', f'{tmp_path}/a/', '--output', 'x.png']) == 0
    assert capsys.readouterr().out == 'x.png: 2 recording(s)\n'
    assert main(['calibrate', 'a', 'a', '--output', 'muscle.yaml']) == 0
    assert 'ambient [1]' in (told := capsys.readouterr().out) and 'ambient [2]' not in told


def test_a_bag_that_is_imported_is_said_to_be_one_already(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'p.yaml').write_text('{rate_hz: 5, input: current, segments: [{duration_s: 1, value: 0}]}')
    assert main(['simulate', 'p.yaml', '--output', 'a']) == 0
    for bag in ('a', 'a/a_0.mcap'):
        capsys.readouterr()
        assert main(['import', bag, '--output', 'lab']) == 2
        assert 'a bag already' in (said := capsys.readouterr().err) and said.count('\n') == 1
