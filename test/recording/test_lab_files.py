"""Odd files as labs write them are understood without a map, or refused in one line that says what is missing."""

import json
import re
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import recording.labs.first_forty
import recording.labs.further  # noqa: F401  enters its files
from recording.labs import by_another
from recording.labs.bench import FILES
from recording.labs.check import LEFT_OUT, UNKNOWN, imported, wrong, wrong_by_another
from scipy.io import savemat

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.csv_import import import_runs
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.recording.lab.cells import clock, decimal_of, number, stamp
from tcp_muscle_ros.recording.lab.draft_map import map_text
from tcp_muscle_ros.recording.lab.grid import Row
from tcp_muscle_ros.recording.lab.guess import guess
from tcp_muscle_ros.recording.lab.headings import Meaning, meaning
from tcp_muscle_ros.recording.lab.preamble import sampled_every
from tcp_muscle_ros.tool import main

DOCUMENT = Path(__file__).resolve().parents[2] / 'docs' / 'lab_files.md'


@pytest.mark.parametrize('file', FILES.values(), ids=list(FILES))
def test_it_is_read_as_it_was_written_or_what_is_missing_is_said(file, tmp_path):
    assert wrong(file, tmp_path) == ''


@pytest.fixture(scope='module')
def by_another_author(tmp_path_factory):
    """The folder of the files by an author who had not seen the importer, and what is in each."""
    folder = tmp_path_factory.mktemp('by_another')
    return folder, by_another.write(folder)


@pytest.mark.parametrize('name', by_another.NAMES)
def test_what_another_author_wrote_is_read_as_its_author_reads_it(name, by_another_author, tmp_path):
    folder, expected = by_another_author
    assert wrong_by_another(folder / name, expected[name], tmp_path) == ''


def test_what_is_left_out_of_a_file_is_said(by_another_author):
    folder, expected = by_another_author
    assert sorted(expected) == sorted(by_another.NAMES) and len(expected) - len(UNKNOWN) >= 50
    for name in LEFT_OUT:
        (run,) = guess(folder / name)
        assert run.left_out
    assert "'LASER CH2' is left out: a displacement in V" in guess(folder / 'tek0004ALL.csv')[0].notes[0]


def test_there_are_enough_of_them_and_the_document_lists_each_with_its_first_try():
    assert len(FILES) >= 60
    assert sum(not file.missing for file in FILES.values()) >= 55
    table = DOCUMENT.read_text(encoding='utf-8')
    assert [name for name in FILES if f'| `{name}` |' not in table] == []
    assert [name for name in by_another.NAMES if f'| `{name}` |' not in table] == []
    ours, theirs = table.split('## By another author')
    for part, files in ((ours, FILES), (theirs, by_another.NAMES)):
        right = len(re.findall(r'^\| `.*\| right[^|]*\|$', part, re.M))
        assert f'{right} of {len(files)}' in part


@pytest.mark.parametrize(
    ('heading', 'unit_cell', 'expected'),
    [
        ('Weg/mm', '', Meaning('displacement', 'mm')),
        ('I (mA)', '', Meaning('current', 'mA')),
        ('Temp [°C]', '', Meaning('temperature', 'degC')),
        ('T', '°C', Meaning('temperature', 'degC')),
        ('t', 'ms', Meaning('time', 'ms')),
        ('T_min', '', Meaning('temperature', None)),  # a minimum, no minutes
        ('t_temp_s', '', Meaning('time', 's')),  # when it was read
        ('Temps (s)', '', Meaning('time', 's')),  # French; no temperature
        ('Raumtemperatur (°C)', '', Meaning('ambient', 'degC')),
        ('T_env (C)', '', Meaning('ambient', 'degC')),
        ('Tenv (C)', '', Meaning('ambient', 'degC')),
        ('T_inf', '°C', Meaning('ambient', 'degC')),
        ('Tinfinity (K)', '', Meaning('ambient', 'K')),
        ('T∞ [°C]', '', Meaning('ambient', 'degC')),
        ('T_surr (C)', '', Meaning('ambient', 'degC')),
        ('Bath temp (C)', '', Meaning('ambient', 'degC')),
        ('Temperature of the environment (°C)', '', Meaning('ambient', 'degC')),
        ('Envelope (V)', '', Meaning('voltage', 'V')),
        ('Info', '', Meaning('', None)),
        ('I_set (A)', '', Meaning('current', 'A', commanded=True)),
        ('Humidity (%)', '', Meaning('', None)),
        ('Preload (g)', '', Meaning('load', 'g')),
        ('Pre-load', 'g', Meaning('load', 'g')),
        ('pretension_N', '', Meaning('load', 'N')),
        ('Pre-tension (N)', '', Meaning('load', 'N')),
        ('Preload force [N]', '', Meaning('load', 'N')),
        ('Vorspannkraft in N', '', Meaning('load', 'N')),
        ('Preload time (s)', '', Meaning('time', 's')),
        ('40g_forced_air', '', Meaning('ambient', None)),  # no force
        ('Перемещение, мм', '', Meaning('displacement', 'mm')),
        ('Ток, мА', '', Meaning('current', 'mA')),
        ('位移(毫米)', '', Meaning('displacement', 'mm')),
    ],
)
def test_a_heading_means(heading, unit_cell, expected):
    assert meaning(heading, unit_cell=unit_cell) == expected


def test_cells():
    assert [number(cell) for cell in ('1,234.5', '-3e-2', '0.5 sec', '+  23.4', '12.3.2025', 'OL', '1,5')] == [
        1234.5, -0.03, 0.5, 23.4, None, None, None,
    ]  # fmt: skip
    assert number('1.234,5', ',') == 1234.5
    assert number('0,500', ',') == 0.5
    assert clock('2:03:22.5 PM') == 14 * 3600 + 3 * 60 + 22.5
    assert stamp('2025-03-12T14:20:11+01:00', 'dmy') == stamp('12.03.2025 13:20:11', 'dmy')


def test_the_command_shows_what_it_understood_and_writes_the_map_that_imports_the_same_again(tmp_path, capsys):
    content, _ = FILES['messprotokoll.csv'].make()
    file = tmp_path / 'messprotokoll.csv'
    file.write_bytes(content)
    assert main(['import', str(file), '--output', str(tmp_path / 'bags')]) == 0
    shown = capsys.readouterr().out
    for words in ("temperature   'Temp. [°C]' in degC", "cp1252, separated by ';', decimal commas, headings in row 7"):
        assert words in shown
    assert re.search(r'^ +0 +23\.42 +8e-06 +0$', shown, re.M), shown
    written = tmp_path / 'bags' / 'import_map.yaml'
    assert main(['import', str(file), '--map', str(written), '--output', str(tmp_path / 'again')]) == 0
    assert (tmp_path / 'again' / 'import_map.yaml').read_bytes() == written.read_bytes()
    first, second = (read_bag(tmp_path / name / 'messprotokoll') for name in ('bags', 'again'))
    assert {name: list(first[name].value) for name in first} == {name: list(second[name].value) for name in second}
    assert main(['import', str(file), '--output', str(tmp_path / 'bags')]) == 2  # nothing is overwritten ...
    assert main(['import', str(file), '--output', str(tmp_path / 'bags'), '--force']) == 0  # ... unless it is said


def test_what_cannot_be_understood_is_one_line_and_nothing_is_left(tmp_path, capsys):
    content, _ = FILES['three_thermocouples.csv'].make()
    file = tmp_path / 'three_thermocouples.csv'
    file.write_bytes(content)
    assert main(['import', str(file), '--output', str(tmp_path / 'bags')]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1 and 'temperature: 3 columns could be it' in said
    assert [path.name for path in tmp_path.iterdir()] == ['three_thermocouples.csv']


def test_all_files_of_a_folder_that_cannot_be_read_are_named_at_once(tmp_path, capsys):
    for name in ('a', 'b', 'd'):
        (tmp_path / f'{name}.csv').write_text('remember,this\nhello,there\n')
    (tmp_path / 'c.csv').write_text('time [s],current [A],temperature [degC]\n0,0,25\n1,0.2,25\n2,0.2,26\n')
    assert main(['import', str(tmp_path), '--output', str(tmp_path / 'bags')]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1 and f'import: {tmp_path / "a.csv"}: no table of numbers in it' in said
    assert f'; nor can {tmp_path / "b.csv"}, {tmp_path / "d.csv"} be read' in said


def test_files_of_one_name_are_told_apart_by_their_folders_or_their_kind(tmp_path):
    for k, name in enumerate(['a/run.csv', 'b/run.csv', 'b/run.txt', 'b/other.csv']):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text('t (s),T (degC)\n' + ''.join(f'{j},{20 + k + j / 10}\n' for j in range(9)))
    files = [str(tmp_path / name) for name in ('a', 'b', 'b/run.txt')]
    assert main(['import', *files, '--output', str(tmp_path / 'bags')]) == 0
    first = {
        path.name: read_bag(path)['temperature'].value[0] for path in (tmp_path / 'bags').iterdir() if path.is_dir()
    }
    assert {name: round(value - 273.15) for name, value in first.items()} == {
        'a_run': 20, 'b_run': 21, 'run_txt': 22, 'other': 23
    }  # fmt: skip


def test_a_name_that_yaml_takes_for_something_else_stays_a_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'on.csv').write_text('t (s),on [degC]\n' + ''.join(f'{k},{20 + k}\n' for k in range(9)))
    assert main(['import', 'on.csv']) == 0
    assert read_import_map(tmp_path / 'on' / 'import_map.yaml').runs[0].channels['temperature'].column == 'on [degC]'


@pytest.mark.parametrize('name', ['dates.xlsx', 'run7.mat', 'frame.parquet', 'cycles.dat', 'test_12.lvm'])
def test_a_damaged_file_is_read_or_refused_in_one_line(name, tmp_path):
    """Whatever a library stumbles over; scipy's reader of .mat does not even survive some."""
    content, _ = FILES[name].make()
    path, said = tmp_path / name, []
    for seed in range(3 if name == 'run7.mat' else 12):
        rng = np.random.default_rng(seed)
        damaged = bytearray(content[: rng.integers(len(content) // 2, len(content))] if seed % 2 else content)
        for at in rng.integers(0, len(damaged), 20):
            damaged[at] = rng.integers(256)
        path.write_bytes(bytes(damaged))
        try:
            guess(path)
        except BadInput as error:
            said.append(str(error))
    assert said and not any('\n' in line for line in said)


def test_a_binary_file_that_is_none_of_the_known_kinds_is_refused(tmp_path):
    (tmp_path / 'run.bin').write_bytes(bytes(range(256)) * 9)
    with pytest.raises(BadInput, match=r'is no text, no \.xlsx'):
        guess(tmp_path / 'run.bin')


@pytest.mark.parametrize(
    ('heading', 'expected'),
    [
        ('Laser displacement (V)', Meaning('displacement', raw='V')),
        ('Force_counts', Meaning('force', raw='counts')),
        ('Power (%)', Meaning('power', raw='%')),
        ('I_shunt (V)', Meaning('current', raw='V')),
        ('Heater (V)', Meaning('voltage', 'V')),
        ('Strain [%]', Meaning('strain', raw='%')),
        ('Disp Digits', Meaning('')),
        ('displacement (x10 um)', Meaning('displacement', raw='x10 um')),
        ('T [0.1 degC]', Meaning('temperature', raw='0.1 degC')),
        ('Weg (1/100 mm)', Meaning('displacement', raw='1/100 mm')),
        ('displacement (mil)', Meaning('displacement', raw='mil')),
        ('force_cN', Meaning('force', raw='cN')),
        ('power (kW)', Meaning('power', raw='kW')),
        ('Laser displacement (mm/s)', Meaning('displacement', raw='mm/s')),
        ('encoder position (deg)', Meaning('displacement', raw='deg')),
        ('Winkel [Grad]', Meaning('')),
        ('angle_deg', Meaning('')),
        ('Troom_C', Meaning('ambient', 'degC')),
    ],
)
def test_what_is_in_no_unit_of_its_channel_is_not_taken_for_it(heading, expected):
    assert meaning(heading) == expected


@pytest.mark.parametrize(
    ('heading', 'kind'),
    [
        ('Temp (core)', 'temperature'),
        ('T (deg)', 'temperature'),
        ('T (K-type)', 'temperature'),
        ('Temp (10k NTC)', 'temperature'),
        ('T (TC 1)', 'temperature'),
        ('T (uC)', 'temperature'),
        ('ch1 displacement (raw mm)', 'displacement'),
        ('displacement (laser)', 'displacement'),
        ('displacement (Keyence LK-G10)', 'displacement'),
        ('Stroke (100 mm)', 'displacement'),
        ('R (4W)', 'resistance'),
        ('R (10 mA)', 'resistance'),
        ('Force (10 N)', 'force'),
        ('Force (50 N load cell)', 'force'),
        ('current (INA219)', 'current'),
        ('time (hh:mm:ss)', 'time'),
        ('Time (pm)', 'time'),
    ],
)
def test_what_else_stands_in_brackets_is_no_unit(heading, kind):
    assert (meaning(heading).kind, meaning(heading).raw) == (kind, '')


def lab_text(tmp_path, *lines, rows):
    (tmp_path / 'run.csv').write_text('\n'.join([*lines, *rows]) + '\n')
    return guess(tmp_path / 'run.csv')


def heated(sign, current=True):
    """A distance that follows heating by 0.2 A behind a lag, in mm, at 1 Hz."""
    warm, rows = 0.0, []
    for k in range(60):
        on = 10 <= k < 30
        warm += (on - warm) / 8.0
        rows.append(f'{k},{0.2 * on if current else 1},{30 + sign * 3 * warm:.3f}')
    return rows


def written(tmp_path, heads, rows):
    """The recording of a file without a map, by the map that is written for it."""
    drafts = lab_text(tmp_path, heads, rows=rows)
    (tmp_path / 'map.yaml').write_text(map_text({tmp_path / 'run.csv': drafts}, tmp_path / 'map.yaml'))
    (run,) = import_runs(read_import_map(tmp_path / 'map.yaml'), [tmp_path / 'run.csv'])
    return run.recording


def channel(run, name):
    (found,) = [column for column in run.columns if column.channel == name]
    return found


def test_a_second_column_of_times_that_goes_another_way_is_of_the_columns_after_it(tmp_path):
    heads = 't_daq (s),T (degC),t_cam (s),Stroke (mm)'
    rows = [
        f'{k / 10:.1f},{23 + k / 10:.1f},' + (f'{0.3 * k + 0.02:.2f},{k / 50}' if k < 20 else ',') for k in range(60)
    ]
    (run,) = lab_text(tmp_path, heads, rows=rows)
    assert channel(run, 'displacement').time.ref.column == 't_cam (s)' and channel(run, 'temperature').time is None
    rows = [f'{k / 10:.1f},{23 + k / 10:.1f},{k // 10},{k / 50}' for k in range(60)]  # the same time, and of less
    (run,) = lab_text(tmp_path, heads, rows=rows)
    assert channel(run, 'displacement').time is None


def of_a_day(seconds, date=''):
    minutes, second = divmod(seconds, 60.0)
    hour, minute = divmod(int(minutes), 60)
    return f'{date}{hour % 24:02d}:{minute:02d}:{second:06.3f}'


@pytest.mark.parametrize(
    ('heads', 'shown'),
    [
        ('Time,I (A),Time,T (degC)', lambda at: of_a_day(at, '2024-03-14 ')),
        ('Time,I (A),Time,T (degC)', lambda at: of_a_day(at, '03/14/2024 ')),
        ('Time,I (A),Time,T (degC)', of_a_day),
        ('Date,Time,I (A),Date,Time,T (degC)', lambda at: f'03/14/2024,{of_a_day(at)}'),
        ('Time,ms,I (A),Time,ms,T (degC)', lambda at: f'{of_a_day(at)[:-4]},{of_a_day(at)[-3:]}'),
    ],
    ids=['years first', 'months first', 'times of day', 'dates apart', 'milliseconds apart'],
)
@pytest.mark.parametrize('later', [3.5, -6.0])
def test_two_loggers_side_by_side_keep_what_one_began_after_the_other(tmp_path, heads, shown, later):
    at = 10 * 3600.0 + np.arange(90) / 10
    rows = [f'{shown(at[k])},{0.2 * (k > 20)},{shown(at[k] + later)},{23 + k / 10}' for k in range(90)]
    recording = written(tmp_path, heads, rows)
    assert recording['current'].time[0] == 0.0
    np.testing.assert_allclose(recording['temperature'].time, np.arange(90) / 10 + later, atol=1e-6)


def test_two_loggers_may_begin_on_either_side_of_midnight_or_count_from_their_own_start(tmp_path):
    for began, other, first in ((86399.0, 86401.0, 2.0), (86401.0, 86399.0, -2.0), (36000.0, 0.0, 0.0)):
        rows = [f'{of_a_day(began + k / 10)},{k % 7},{of_a_day(other + k / 10)},{23 + k / 10}' for k in range(90)]
        recording = written(tmp_path, 'Time,I (mA),Time,T (degC)', rows)
        np.testing.assert_allclose(recording['temperature'].time, np.arange(90) / 10 + first, atol=1e-6)
        assert [note for note in recording.notes if 'taken to begin with it' in note] or other


def test_a_counter_of_its_own_may_begin_anew(tmp_path):
    rows = [f'{k / 10},{k % 7},{(65000 + 100 * k) % 65536},{23 + k / 10}' for k in range(90)]
    (run,) = lab_text(tmp_path, 't (s),I (mA),t (ms),T (degC)', rows=rows)
    assert channel(run, 'temperature').time is None  # it is not said to be another clock
    rows = [f'{100 * k},{k % 7},{(65000 + 100 * k) % 65536},{23 + k / 10}' for k in range(90)]
    (run,) = lab_text(tmp_path, 't (ms),I (mA),t (ms),T (degC)', rows=rows)
    assert channel(run, 'temperature').time.wraps == 65536


@pytest.mark.parametrize(
    ('above', 'period'),
    [
        (['Heating frequency: 0.05 Hz', 'Sample rate: 10 Hz'], 0.1),
        (['Period: 20 s', 'Sample rate: 10 Hz'], 0.1),
        (['Interval: 20 s', 'dt = 0.1 s'], 0.1),
        (['Frequency: 0.05 Hz (square wave)', 'Interval: 100 ms'], 0.1),
        (['Heating: 0.25 A, period 20 s, sample rate 10 Hz'], 0.1),
        (['Sample rate: 10 Hz Heating frequency: 0.05 Hz'], 0.1),
        (['Heater: MX100; Sampling rate: 10 Hz'], 0.1),
        (['Sample rate: 10 Hz (heater by PWM)', 'PWM frequency: 1 kHz'], 0.1),
        (['Sample rate: 10 Hz', 'Scan interval: 100 ms'], 0.1),
        (['Frequency: 10 Hz'], 0.1),
        (['Signal sampling rate: 10 Hz'], 0.1),
        (['Heating test sampling rate: 10 Hz'], 0.1),
        (['Pulse test - sampling interval: 100 ms'], 0.1),
        (['Heating frequency: 0.05 Hz'], None),
        (['Drive cycle period: 20 s'], None),
        (['Period: 20 s', 'Interval: 100 ms'], None),
        (['Sample rate: 1000 Hz', 'Logging interval: 100 ms'], None),
    ],
)
def test_the_rate_of_the_samples_is_not_that_of_the_heating(above, period):
    found = sampled_every([Row(k + 1, (line,)) for k, line in enumerate(above)])
    assert found == (None if period is None else pytest.approx(period))


def test_a_line_of_words_among_the_rows_parts_no_run_unless_it_names_one(tmp_path):
    rows = [f'{k},{23 + k / 10}' for k in range(40)]
    for line, runs in (('WARN: buffer overrun', 1), ('*** sync ***', 1), ('Run 2', 2)):
        assert len(lab_text(tmp_path, 't (s),T (degC)', rows=[*rows[:20], line, *rows[20:]])) == runs
    assert len(lab_text(tmp_path, 't (s),T (degC)', rows=[*rows, 'reset', *rows])) == 2


def gapped(lines, rows, word, keep):
    """Lines with a word in place of the numbers of some rows, but for the first ``keep`` of each."""
    cells = [line.split(',') for line in lines]
    return [','.join(c[:keep] + [word] * (len(c) - keep)) if k in rows else ','.join(c) for k, c in enumerate(cells)]


@pytest.mark.parametrize('keep', [1, 2])
@pytest.mark.parametrize('word', ['NaN', 'ERR', '#DIV/0!', ''])
@pytest.mark.parametrize(
    'rows', [{54}, {30}, {30, 31, 32, 33}, {0, 1}, {k for k in range(60) if k % 5 < 4}], ids=lambda rows: str(len(rows))
)
def test_rows_without_numbers_are_gaps_in_a_run_and_end_none(tmp_path, rows, word, keep):
    whole = [f'{k / 2:.1f},{k % 7 / 10},{23 + k / 10:.1f},{k / 50},{14 + k / 100:.2f}' for k in range(60)]
    heads = 't (s),I (A),T (degC),Stroke (mm),R (ohm)'
    (recording,) = imported_text(tmp_path, heads, gapped(whole, rows, word, keep))
    has = [k for k in range(60) if k not in rows]
    np.testing.assert_allclose(recording['resistance'].time, np.array(has) / 2)
    np.testing.assert_allclose(recording['resistance'].value, 14 + np.array(has) / 100)
    assert f'resistance: {len(rows)} of 60 rows have no number' in recording.notes
    assert len(recording['current']) == (60 if keep > 1 else len(has))


def test_rows_with_one_of_two_loggers_each_are_a_table_whatever_stands_for_nothing(tmp_path):
    rows = [f'{k / 2:.1f},{k % 7 / 10},nan,nan' if k % 2 else f'{k / 2:.1f},nan,{23 + k},{14 + k}' for k in range(60)]
    (recording,) = imported_text(tmp_path, 't (s),I (A),T (degC),R (ohm)', rows)
    assert len(recording['current']) == len(recording['temperature']) == 30


def imported_text(tmp_path, heads, rows):
    """The recordings of a file without a map."""
    (tmp_path / 'run.csv').write_text('\n'.join([heads, *rows]) + '\n')
    return imported(tmp_path / 'run.csv', tmp_path)


@pytest.mark.parametrize('remark', ['"fan off', '"'])
@pytest.mark.parametrize(
    ('at', 'count'), [({20}, 60), ({20, 30}, 60), ({20, 59}, 60), (set(range(20, 40)), 60), ({20}, 6000)]
)
def test_a_quotation_mark_that_nobody_closes_swallows_no_rows(tmp_path, at, count, remark):
    rows = [f'{k / 10:.1f},{k % 7 / 10},{23 + k / 1000:.3f},' + remark * (k in at) for k in range(count)]
    (recording,) = imported_text(tmp_path, 't (s),I (A),T (degC),remark', rows)
    assert len(recording['temperature']) == count
    assert recording['temperature'].value[-1] == pytest.approx(296.15 + (count - 1) / 1000)


def test_a_quotation_mark_that_nobody_closes_may_stand_in_any_column(tmp_path):
    rows = [f'{k / 10:.1f},{chr(34) if k == 20 else ""}on,{k % 7 / 10},{23 + k / 10:.1f}' for k in range(60)]
    (recording,) = imported_text(tmp_path, 't (s),fan,I (A),T (degC)', rows)
    assert len(recording['temperature']) == 60


def test_a_remark_in_quotes_may_have_several_lines(tmp_path):
    rows = [f'{k / 10:.1f},{k % 7 / 10},{23 + k / 10:.1f},' + '"fan off,\n3 of 4,\n5"' * (k == 20) for k in range(60)]
    heads = '"t\n(s)","I\n(A)","T\n(degC)",remark'
    (recording,) = imported_text(tmp_path, heads, rows)
    assert len(recording['temperature']) == 60


@pytest.mark.parametrize('line', ['17,', '0,Run 2'])
def test_what_numbers_or_names_the_second_of_two_runs_is_no_row_of_either(tmp_path, line):
    rows = [f'{k / 2:.1f},{23 + k / 10:.1f}' for k in range(60)]
    first, second = imported_text(tmp_path, 't (s),T (degC)', [*rows, line, *rows])
    assert first.duration == second.duration == 29.5


def test_a_run_that_is_left_out_since_it_is_short_is_said_to_be(tmp_path):
    heads, rows = 't (s),I (A),T (degC)', [f'{k / 2:.1f},{k % 7 / 10},{23 + k / 10:.1f}' for k in range(60)]
    for lines in ([*rows[:5], '', heads, *rows], [*rows, '', heads, *rows[:5]]):
        (run,) = lab_text(tmp_path, heads, rows=lines)
        assert [note for note in run.notes if 'are left out: a run that is far shorter' in note]


def test_where_the_newest_row_stands_first_the_rows_are_turned(tmp_path):
    rows = [f'2024-03-14 09:{k // 60:02d}:{k % 60:02d},{23 + k / 10},{0.27 * (k > 20)}' for k in range(90)]
    path = tmp_path / 'run.csv'
    path.write_text('\n'.join(['Timestamp,T (degC),I (A)', *rows[::-1]]) + '\n')
    (recording,) = imported(path, tmp_path)
    assert list(recording['temperature'].time[[0, -1]]) == [0.0, 89.0]
    assert recording['temperature'].value[0] == pytest.approx(296.15)


@pytest.mark.parametrize('columns', [False, True])
def test_one_piece_of_json_is_a_table(tmp_path, columns):
    rows = [{'time_s': k / 2, 'temp_degC': 23 + k / 10, 'current_A': 0.2, 'note': None} for k in range(20)]
    path = tmp_path / 'run.json'
    path.write_text(json.dumps({name: [row[name] for row in rows] for name in rows[0]} if columns else rows, indent=1))
    (recording,) = imported(path, tmp_path)
    assert len(recording['current']) == 20 and recording['temperature'].time[-1] == 9.5


def test_numbers_that_a_spreadsheet_keeps_as_text_may_have_decimal_commas(tmp_path):
    openpyxl = pytest.importorskip('openpyxl', reason="needs the extra 'labs'")
    book = openpyxl.Workbook()
    for row in (['Zeit [s]', 'T [°C]'], *([f'{k},5', f'{23 + k},25'] for k in range(20))):
        book.active.append(row)
    book.save(tmp_path / 'text.xlsx')
    (recording,) = imported(tmp_path / 'text.xlsx', tmp_path)
    assert recording['temperature'].value[0] == pytest.approx(273.15 + 23.25)


@pytest.mark.parametrize(
    ('begin', 'told'),
    [
        (b'\x1f\x8b\x08', 'compressed; unpack it first'),
        (b'PK\x03\x04', 'compressed; unpack it first'),
        (b'\xd0\xcf\x11\xe0\xa1', r'old Excel \(\.xls\); save it as'),
    ],
)
def test_a_file_that_has_to_be_unpacked_or_saved_anew_is_said_to_be(tmp_path, begin, told):
    (tmp_path / 'run').write_bytes(begin + bytes(200))
    with pytest.raises(BadInput, match=told):
        guess(tmp_path / 'run')


def test_a_unit_in_brackets_makes_a_heading(tmp_path):
    (run,) = lab_text(tmp_path, 'Time (s),101 (C),102 (ADC),103 (mm)', rows=[f'{k},{23 + k},0.2,{k}' for k in range(9)])
    assert [column.channel for column in run.columns] == ['temperature', 'current', 'displacement']


def test_utf_16_without_a_mark_of_either_order_is_text(tmp_path):
    text = 't (s);T (°C)\n' + ''.join(f'{k};{23 + k}\n' for k in range(9))
    for encoding in ('utf-16-le', 'utf-16-be'):
        (tmp_path / 'run.csv').write_bytes(text.encode(encoding))
        assert guess(tmp_path / 'run.csv')[0].layout.encoding == encoding


def test_dates_as_a_spreadsheet_keeps_them_are_days(tmp_path):
    rows = [f'{45365.375 + k / 86400:.8f},{23 + k / 10}' for k in range(40)]
    (run,) = lab_text(tmp_path, 'Date/Time,T (degC)', rows=rows)
    assert run.time.unit == 'd'
    (run,) = lab_text(tmp_path, 'Time,T (degC)', rows=rows)
    assert run.time.unit == 'd'  # no logger writes 86400 rows in a second
    (run,) = lab_text(tmp_path, 'Time,T (degC)', rows=[f'{45365 + k},{23 + k / 10}' for k in range(40)])
    assert run.time.unit == 's'


@pytest.mark.parametrize(
    ('first', 'step', 'unit', 'told'),
    [
        (0, 0.00167, 's', "'Time' has no unit; taken as s, with a row every 0.00167 s"),
        (0, 1, 's', "'Time' has no unit; taken as s, with a row every 1 s"),
        (0, 20, 'ms', "'Time' has no unit; taken as ms, with a row every 0.02 s"),
        (0, 100000, 'us', "'Time' has no unit; taken as us, with a row every 0.1 s"),
        (739589.5, 1 / 864000, 'd', None),  # as MATLAB counts
    ],
)
def test_the_unit_of_a_time_is_taken_from_its_steps_and_said(tmp_path, first, step, unit, told):
    rows = [f'{first + k * step:.12g},{23 + k / 100}' for k in range(1200)]
    (run,) = lab_text(tmp_path, 'Time,T (degC)', rows=rows)
    assert run.time.unit == unit
    assert [note for note in run.notes if 'Time' in note] == ([told] if told else [])


@pytest.mark.parametrize(('written', 'order'), [('%d/%m/%Y', 'dmy'), ('%m/%d/%Y', 'mdy'), ('%d-%m-%y', 'dmy')])
@pytest.mark.parametrize('heads', ['Date Time', 'Date,Time'])
def test_a_run_that_passes_midnight_goes_on_by_a_day_and_by_no_month(tmp_path, written, order, heads):
    began = datetime(2024, 5, 3, 23, 58)
    stamps = [f'{began + timedelta(seconds=k):{written}{heads[4]}%H:%M:%S}' for k in range(300)]
    rows = [f'{stamp},{23 + k / 10:.1f}' for k, stamp in enumerate(stamps)]
    (run,) = lab_text(tmp_path, f'{heads},T (degC)', rows=rows)
    assert run.time.order == order


@pytest.mark.parametrize(
    ('written', 'unit'),
    [('%H%M%S.%f', 'clock'), ('%H%M%S', 'clock'), ('%Y%m%d%H%M%S.%f', 'stamp'), ('%y%m%d%H%M%S', 'stamp')],
)
def test_a_time_that_is_written_as_one_number_is_parted(tmp_path, written, unit):
    began = datetime(2024, 5, 3, 23, 58)
    step = 0.5 if '.' in written else 2.0
    stamps = [f'{began + timedelta(seconds=step * k):{written}}' for k in range(300)]
    (tmp_path / 'run.csv').write_text('\n'.join(['time,T (degC)', *(f'{s},{23 + k}' for k, s in enumerate(stamps))]))
    (run,) = guess(tmp_path / 'run.csv')
    assert (run.time.unit, run.time.note) == (unit, '')
    (recording,) = imported(tmp_path / 'run.csv', tmp_path)
    assert np.allclose(recording['temperature'].time, step * np.arange(300))


@pytest.mark.parametrize('step', [1, 20, 50, 60, 100, 600])
def test_numbers_that_go_on_evenly_are_counted_though_each_could_be_a_time_of_day(tmp_path, step):
    (run,) = lab_text(tmp_path, 'time,T (degC)', rows=[f'{10000 + k * step},{23 + k / 10}' for k in range(55)])
    assert run.time.unit in ('s', 'ms')


def test_a_number_beyond_all_dates_is_no_time(tmp_path):
    with pytest.raises(BadInput, match="no time: none of the columns 'time'"):
        lab_text(tmp_path, 'time,T (degC)', rows=[f'{20249913140000 + k},{23 + k / 10}' for k in range(30)])


def test_minutes_and_seconds_pass_the_hour_and_two_bytes_begin_anew(tmp_path):
    seconds = [3595 + 0.5 * k for k in range(40)]
    rows = [f'{int(s // 60) % 60:02d}:{s % 60:04.1f},{23 + s / 100}' for s in seconds]
    (run,) = lab_text(tmp_path, 'Time,T (degC)', rows=rows)
    assert run.time.unit == 'clock' and run.layout.last == 41
    (run,) = lab_text(tmp_path, 'ms,T (degC)', rows=[f'{(65000 + 100 * k) % 65536},{23 + k / 10}' for k in range(40)])
    assert run.time.wraps == 65536
    two = [f'{int(s) // 60:02d}:{s % 60:04.1f},{23 + s / 100}' for s in [*range(2400), *range(2400)]]
    assert len(lab_text(tmp_path, 'Time,T (degC)', rows=two)) == 2  # each of 40 minutes


def test_the_end_of_a_thermometers_range_is_no_temperature(tmp_path):
    rows = [f'{k},{"1372.0" if 30 <= k < 34 else 23 + k / 10:.6},{1372.0 if k > 30 else 0.1 * k}' for k in range(60)]
    (run,) = lab_text(tmp_path, 't (s),TC1 (degC),Stroke (mm)', rows=rows)
    assert run.layout.missing == ('1372.0',)
    still = [f'{k},{23.1 if k < 30 else 23.2},{k}' for k in range(60)]
    assert lab_text(tmp_path, 't (s),T (degC),Stroke (mm)', rows=still)[0].layout.missing == ()


@pytest.mark.parametrize('heading', ['AI3 (V)', 'Supply (V)'])
def test_a_voltage_where_no_current_flows_is_not_the_muscles(tmp_path, heading):
    rows = [f'{k},{0.2 * (k > 20)},{4.1 - 0.01 * k},{23 + k / 10}' for k in range(60)]
    (run,) = lab_text(tmp_path, f't (s),I (A),{heading},T (degC)', rows=rows)
    assert [column.channel for column in run.columns] == ['current', 'temperature']
    assert f"'{heading}' is left out: it shows a voltage where no current flows" in run.notes
    rows = [f'{k},{0.2 * (k > 20)},{2.8 * (k > 20)},{23 + k / 10}' for k in range(60)]
    (run,) = lab_text(tmp_path, f't (s),I (A),{heading},T (degC)', rows=rows)
    assert channel(run, 'voltage').ref.column == heading


def test_a_voltmeter_that_shows_nothing_while_a_current_flows_is_left_out_and_said_to_be(tmp_path):
    rows = [f'{k},{0.2 * (k > 20)},{"" if k == 7 else "0.000"},{23 + k / 10}' for k in range(60)]
    (run,) = lab_text(tmp_path, 't (s),I (A),U (V),T (degC)', rows=rows)
    assert [column.channel for column in run.columns] == ['current', 'temperature']
    assert "'U (V)' is left out: it shows no voltage, though a current flows" in run.notes


@pytest.mark.parametrize('heading', ['Pot (V)', 'Vout LVDT (V)', 'Potentiometer (mV)'])
def test_what_a_displacement_sensor_puts_out_is_no_voltage_of_the_muscle(tmp_path, heading):
    rows = [f'{k},{0.2 * (k > 20)},{2.8 * (k > 20)}' for k in range(60)]
    (run,) = lab_text(tmp_path, f't (s),I (A),{heading}', rows=rows)
    assert run.left_out == (heading,) and f"'{heading}' is left out: a displacement in" in run.notes[0]
    assert meaning('Potential (V)') == Meaning('voltage', 'V')


def test_a_load_that_nobody_states_is_said_to_be_missing(tmp_path):
    rows = [f'{k},{0.2},{23 + k / 10}' for k in range(60)]
    (run,) = lab_text(tmp_path, 't (s),I (A),T (degC)', rows=rows)
    assert run.notes == (
        'no load is stated; where one hangs on the muscle, add to columns in the map: load: {value: 60, unit: g}',
    )
    (run,) = lab_text(tmp_path, 'Gewicht: 60 g', '', 't (s),I (A),T (degC)', rows=rows)
    assert run.notes == ('a load of 0.588399 N, as is written above',)


@pytest.mark.parametrize(
    ('load', 'kind'),
    [
        (lambda k: (0.3923, 0.8826, 0.3923)[k // 100], 'load'),  # weights that are changed
        (lambda k: 0.3923 if k % 100 else 0.6, 'load'),  # caught while they were
        (lambda k: 0.3923 + 0.1 * (k // 25 * 5 % 7) if k % 25 else 0.517, 'load'),  # seven of them, and a hand
        (lambda k: round(0.5 + 0.4 * k / 300, 2 if k % 40 else 1), 'force'),  # a coarse cell beside a drift
        (lambda k: 0.5 + 0.05 * (k // 30), 'force'),  # step by step
        (lambda k: 0.39 + round(0.5 * np.sin(k / 40), 2), 'force'),  # a coarse cell that the muscle pulls at
        (lambda k: 0.3923, 'load'),
    ],
)
def test_a_load_that_goes_from_one_weight_to_another_hangs_and_one_that_varies_is_measured(tmp_path, load, kind):
    rows = [f'{k / 10},{0.2 * (k > 20)},{23 + k / 100},{load(k)}' for k in range(300)]
    (run,) = lab_text(tmp_path, 't (s),I (A),T (degC),Load (N)', rows=rows)
    assert kind in [column.channel for column in run.columns]


@pytest.mark.parametrize(
    ('heading', 'cell'), [('Target force (N)', '0.5'), ('Force (counts)', '512'), ('Force (N)', '')]
)
def test_a_force_that_is_left_out_measures_no_load_that_varies(tmp_path, heading, cell):
    rows = [f'{k / 10},{0.2 * (k > 20)},{23 + k / 100},{0.5 + 0.1 * np.sin(k / 40):.3f},{cell}' for k in range(300)]
    (run,) = lab_text(tmp_path, f't (s),I (A),T (degC),Load (N),{heading}', rows=rows)
    assert channel(run, 'force').ref.column == 'Load (N)'


def test_nines_that_stand_for_no_number_are_none(tmp_path):
    rows = [f'{k},{"-999.9" if k % 9 == 4 else 23 + k / 10},{"9.9E+37" if k < 3 else 14}' for k in range(40)]
    (run,) = lab_text(tmp_path, 't (s),T (degC),R (ohm)', rows=rows)
    assert set(run.layout.missing) == {'-999.9', '9.9E+37'}
    (run,) = lab_text(tmp_path, 't (s),F (mN)', rows=[f'{k},{990 + k}' for k in range(40)])  # 999 among its like
    assert run.layout.missing == ()


@pytest.mark.parametrize('nines', ['999', '9999'])
def test_a_drive_that_is_off_or_gives_a_number_of_nines_gives_it(tmp_path, nines):
    rows = [f'{k},{nines if k % 8 > 4 else 0},{23 + k / 10}' for k in range(40)]
    (run,) = lab_text(tmp_path, 't (s),I (mA),T (degC)', rows=rows)
    assert run.layout.missing == ()
    rows[3:5] = ['3,9.9E+37,23.3', '4,-999.9,23.4']  # which no drive gives
    (run,) = lab_text(tmp_path, 't (s),I (mA),T (degC)', rows=[row.replace(f',{nines},', ',0,') for row in rows])
    assert set(run.layout.missing) == {'9.9E+37', '-999.9'}


@pytest.mark.parametrize(('nines', 'without'), [('9999', 8), ('999', 0), ('999.9', 0)])
def test_nines_far_above_a_drive_that_stays_are_no_level_of_it(tmp_path, nines, without):
    rows = [f'{k},{nines if k % 10 == 3 else 250},{23 + k / 10}' for k in range(80)]
    (recording,) = imported_text(tmp_path, 't (s),I (mA),T (degC)', rows)
    assert len(recording['current']) == 80 - without
    assert np.max(recording['current'].value) == (0.25 if without else float(nines) / 1000.0)


@pytest.mark.parametrize(
    ('line', 'load', 'room'),
    [
        ('Belastung: 60 g', 0.588399, None),
        ('Gewicht;60;g', 0.588399, None),
        ('# Run 1  load = 60 g', 0.588399, None),
        ('Muscle weight: 2 g', None, None),
        ('# suspended mass = 50 g', 0.490333, None),
        ('Masa colgada:,50 g', 0.490333, None),
        ('Massa suspensa (g);60', 0.588399, None),
        ('荷重[g],50', 0.490333, None),
        ('% Load: 0.59 N', 0.59, None),
        ('# fs = 10 Hz, weight 100 g', 0.980665, None),
        ('Room temperature: 72.5 F', None, 22.5),
        ('Load cell: 10 N', None, None),
        ('Max load: 5 N', None, None),
        ('Fibre mass: 60 g', None, None),
        ('Load: 60', None, None),
        ('Loaded on 12.3. by K. 5 N', None, None),
    ],
)
def test_what_hangs_on_it_and_the_room_are_taken_from_the_words_above(tmp_path, line, load, room):
    (run,) = lab_text(tmp_path, 'Test 4', line, '', 't (s),I (A),x (mm)', rows=heated(1))
    assert (run.known.get('load_n'), run.known.get('ambient_c')) == (load, room)
    assert any('as is written above' in note for note in run.notes) == (load is not None or room is not None)


def test_what_a_column_has_is_not_taken_from_the_words_above(tmp_path):
    rows = [f'{row},0.3' for row in heated(1)]
    (run,) = lab_text(tmp_path, 'Load: 60 g', 't (s),I (A),x (mm),F (N)', rows=rows)
    assert 'load_n' not in run.known
    assert 'the load of 0.588399 N that is written above is not taken: the force was measured' in run.notes
    (run,) = lab_text(tmp_path, 'Load: 60 g', 't (s),I (A),x (mm),load (N)', rows=rows)
    assert 'load_n' not in run.known


def held_at_its_length():
    """A force that rises from 0.6 N with the heat, in N, at 1 Hz."""
    rows = [row.split(',') for row in heated(1)]
    return [f'{time},{current},{0.6 + (float(x) - 30) / 10:.4f}' for time, current, x in rows]


@pytest.mark.parametrize(
    'line', ['Load: 60 g', 'Preload: 60 g', 'Pre-load = 60 g', 'Vorlast: 60 g', 'pre-tension [g]: 60']
)
def test_a_load_above_a_force_that_varies_is_what_pulled_before_it_was_held(tmp_path, line):
    (run,) = lab_text(tmp_path, 'blocked at constant length', line, 't (s),I (A),F (N)', rows=held_at_its_length())
    assert run.known == {'load_n': 0.588399}
    assert run.notes == ('a load of 0.588399 N at the start, as is written above',)


def test_a_preload_is_nothing_that_hangs_on_a_muscle(tmp_path):
    (run,) = lab_text(tmp_path, 'Preload: 60 g', 't (s),I (A),x (mm)', rows=heated(1))
    assert 'load_n' not in run.known


def test_a_column_of_the_preload_stands_beside_one_of_the_force(tmp_path):
    rows = [f'{row},60' for row in held_at_its_length()]
    (run,) = lab_text(tmp_path, 't (s),I (A),Force (N),Preload (g)', rows=rows)
    assert {column.channel: column.unit for column in run.columns} == {'current': 'A', 'force': 'N', 'load': 'g'}


@pytest.mark.parametrize('line', ['L0 = 150 mm', 'Gauge length (mm):,150', 'Länge: 15 cm'])
def test_a_strain_is_of_the_length_that_is_written_above(tmp_path, line):
    (run,) = lab_text(tmp_path, line, 'Faserlänge: 500 mm', 'Time (s),Current (A),Strain (%)', rows=heated(1))
    assert channel(run, 'displacement').scale == pytest.approx(0.0015)


def test_of_two_columns_the_one_with_a_unit_is_the_channel(tmp_path):
    rows = [f'{row},{k / 10}' for k, row in enumerate(heated(1))]
    (run,) = lab_text(tmp_path, 't (s),I (A),laser (mm),laser_V', rows=rows)
    assert channel(run, 'displacement').ref.column == 'laser (mm)'


@pytest.mark.parametrize('sign', [1, -1])
def test_which_way_a_distance_goes_is_told_by_the_heat(tmp_path, sign):
    (run,) = lab_text(tmp_path, 'Time (s),Current (A),Distance (mm)', rows=heated(sign))
    (distance,) = [column for column in run.columns if column.channel == 'displacement']
    assert (distance.sign, distance.from_first) == (sign, True)


def test_a_distance_of_which_nothing_tells_the_way_is_refused(tmp_path):
    with pytest.raises(BadInput, match=r"'Distance \(mm\)': a distance that grows or falls as the muscle contracts"):
        lab_text(tmp_path, 'Time (s),Humidity,Distance (mm)', rows=heated(1, current=False))


def test_a_strain_without_a_length_is_left_out_and_said_to_be(tmp_path):
    heads = 'Time (s),Current (A),Strain (%)'
    (run,) = lab_text(tmp_path, heads, rows=heated(1))
    assert "'Strain (%)' is left out: a strain in %, and the muscle's length is written nowhere" in run.notes[0]
    for line, unit, scale in (
        ('Length: 120 mm', '%', 1.2e-3),
        ('Muscle length: 120 mm', '%', 1.2e-3),
        ('L0 = 120 mm', 'mm/mm', 0.12),
    ):
        (run,) = lab_text(tmp_path, line, '', f'Time (s),Current (A),Strain ({unit})', rows=heated(1))
        (strain,) = [column for column in run.columns if column.channel == 'displacement']
        assert (strain.unit, strain.scale) == ('m', scale)


def test_milliseconds_that_begin_anew_with_each_second_are_no_runs(tmp_path):
    rows = [f'2024/05/01 10:00:{k // 5:02d},{200 * (k % 5)},{23 + 0.1 * k:.1f}' for k in range(60)]
    (run,) = lab_text(tmp_path, 'Date Time,ms,Temperature (°C)', rows=rows)
    assert run.time.unit == 'stamp' and run.time.fraction.column == 'ms'


@pytest.mark.parametrize(
    ('cells', 'usual', 'decimal'),
    [
        (('0,100', '1,200'), '.', ','),  # no group of thousands begins with a zero
        (('-0,031', '23,035'), '.', ','),
        (('1,200', '23,035'), '.', '.'),
        (('1,200', '23,035'), ',', ','),
        (('1,200', '1,200.5'), ',', '.'),
        (('13.993', '14.004'), ',', '.'),  # no commas in the column
        (('900', '1.000'), ',', ','),  # thousands, for less stands without
        (('0.900', '1.000'), ',', '.'),
        (('14,25', '13.9930', '14.0'), '.', ','),  # such points read beside decimal commas too
        (('14,25', '13.993', '14.0'), '.', '.'),
        (('', 'OL'), ',', ','),
    ],
)
def test_the_decimal_mark_of_a_column_is_that_which_its_cells_show_or_that_of_its_file(cells, usual, decimal):
    assert decimal_of(cells, usual) == decimal


def test_one_value_below_one_makes_the_commas_of_a_file_decimal_ones(tmp_path):
    rows = [f'"{k},000","{0.2 * (k > 20):.3f}","{23 + k / 10:.3f}"'.replace('.', ',') for k in range(1, 40)]
    path = tmp_path / 'run.csv'
    path.write_text('\n'.join(['"Zeit [s]","Strom [A]","Temp [°C]"', *rows]) + '\n', encoding='utf-8')
    (recording,) = imported(path, tmp_path)
    assert recording['temperature'].time[-1] == 38.0
    assert recording['temperature'].value[0] == pytest.approx(273.15 + 23.1)


@pytest.mark.parametrize(
    ('line', 'first'),
    [
        ('{t:.1f}\t{i:,.0f}\t{T:.2f}', 1.25),  # mA, with points beside it
        ('{t:.0f}\t{i:,.0f}\t{T:.0f}', 1.25),  # with smaller ones beside it
        ('{t:.1f};{i:,.0f};{T:.2f}', 1.25),
        ('{t:.0f};{R:.3f};{T:.0f}', 0.014001),  # German, without a sure decimal comma
        ('{t:.0f}\t{R:.3f}\t{R:.3f}', 0.014001),
        ('{t:.1f};{R:.3f};{T:.2f}', 0.014001),
    ],
)
def test_commas_of_thousands_are_no_decimal_ones(tmp_path, line, first):
    german = '{R' in line
    rows = [line.format(t=k, i=1250 if k % 2 == 0 else 995, R=14.001 + k / 1000, T=23 + k) for k in range(40)]
    rows = [row.replace('.', ',') for row in rows] if german else rows
    separator = ';' if ';' in line else '\t'
    (recording,) = imported_text(tmp_path, separator.join(['t (s)', 'I (mA)', 'T (degC)']), rows)
    assert recording['current'].value[0] == pytest.approx(first)


@pytest.mark.parametrize(
    'line',
    [
        '{t:.1f};0;{P};{T}',  # points in another column
        '{t:.0f};1.2;{P};{T}',
        '{t:.0f};0;{P_or_1};{T_or_23}',  # whole numbers between
    ],
)
@pytest.mark.parametrize('heads', ['Zeit (s);Version;P (W);T (°C)', 'Zeit;Version;P;T\ns;;W;°C'])
def test_decimals_that_would_be_beyond_every_muscle_as_thousands_are_decimals(tmp_path, line, heads):
    written = [(f'1,{125 + k}', f'23,{125 + k}') for k in range(58)]
    rows = [
        line.format(
            t=k / 10 if '.1f' in line else k, P=P, T=T, P_or_1=P if k % 2 else '1', T_or_23=T if k % 3 else '23'
        )
        for k, (P, T) in enumerate(written)
    ]
    (recording,) = imported_text(tmp_path, heads, rows)
    assert recording['power'].value[-1] == pytest.approx(1.182)
    assert recording['temperature'].value[1] == pytest.approx(273.15 + 23.126)


def test_thousands_that_a_muscle_may_have_are_thousands_beside_points(tmp_path):
    rows = [f'{k / 10:.1f};{30000 if k < 8 else 1250 + k / 8:,};{1250 + k:,}' for k in range(40)]
    (recording,) = imported_text(tmp_path, 't (s);R (ohm);P (mW)', rows)
    assert recording['resistance'].value[-1] == 1254.875 and recording['power'].value[0] == pytest.approx(1.25)


def long_form(times, devices=('',)):
    """One reading a row: of two names, at each time, of each device."""
    return [
        f'{t},{device},{name},{value + k}'
        for k, t in enumerate(times)
        for device in devices
        for name, value in (('current_A', 0.1), ('temperature_C', len(device) + 23.0))
    ]


@pytest.mark.parametrize(
    ('rows', 'said'),
    [
        (
            long_form([k // 5 for k in range(60)]),
            "rows 2 and 4 both read 'current_A' at '0', 0.1 and 1.1; give the times more digits",
        ),
        (
            long_form(range(60), ['tcp', 'tcp2']),
            "'temperature_C' at '0', 26.0 and 27.0; they differ in 'device' (tcp, tcp2): keep one",
        ),
    ],
)
def test_readings_of_one_time_that_differ_are_refused_and_what_tells_them_apart_is_named(tmp_path, rows, said):
    with pytest.raises(BadInput, match=re.escape(said)):
        lab_text(tmp_path, 'time_s,device,field,value', rows=rows)


@pytest.mark.parametrize(
    'lines',
    [
        ['{k},psu,current_A,0.2', '{k},psu,status,0', '{k},dmm,status,1', '{k},dmm,temperature_C,{T:.1f}'],
        ['{k},psu,current_A,0.2', '{k},psu,state,on', '{k},dmm,state,auto', '{k},dmm,temperature_C,{T:.1f}'],
        ['{k},psu,current_A,0.2', '{k},dmm,temperature_C,{T:.1f}', '{k},dmm,temperature_C,{T:.2f}'],
    ],
    ids=['a number for a state', 'a word for it', 'with more digits'],
)
def test_readings_of_one_time_that_say_the_same_or_are_of_no_channel_are_none_too_many(tmp_path, lines):
    rows = [line.format(k=k, T=23 + k / 10) for k in range(60) for line in lines]
    (recording,) = imported_text(tmp_path, 'time_s,device,name,value', rows)
    assert len(recording['current']) == len(recording['temperature']) == 60
    assert recording['temperature'].value[-1] == pytest.approx(273.15 + 28.9)


def test_readings_with_decimal_commas_that_differ_are_refused_too(tmp_path):
    rows = [
        f'{k};{name};{value}' for k in range(60) for name, value in (('I_A', '0,2'), ('T_C', '23,1'), ('T_C', '23,4'))
    ]
    with pytest.raises(BadInput, match="both read 'T_C' at '0', 23,1 and 23,4"):
        lab_text(tmp_path, 'time_s;name;value', rows=rows)


def test_a_reading_twice_in_one_second_is_left_out_and_one_that_is_repeated_is_none(tmp_path):
    rows = long_form([k - (k == 50) for k in range(120)])
    for repeats, left_out in (([], 2), (rows[:40], 2)):
        (recording,) = imported_text(tmp_path, 'time_s,device,field,value', [*rows, *repeats])
        assert len(recording['current']) == 119 and recording['current'].value[49] == 50.1
        assert [note for note in recording.notes if note.startswith(f'{left_out} reading(s) are left out')]


HEADS = 't (s),I (mA),T (degC),Stroke (mm)'


@pytest.mark.parametrize('separator', [',', ';', '\t'])
def test_fewer_headings_than_columns_of_numbers_are_refused(tmp_path, separator):
    rows = [f'{3 * k},{k / 2},{100 * (k % 7)},{23 + k / 10:.1f},{k / 50}' for k in range(60)]
    with pytest.raises(BadInput, match='4 headings stand over 5 columns'):
        imported_text(tmp_path, HEADS.replace(',', separator), [row.replace(',', separator) for row in rows])


@pytest.mark.parametrize('more', [',', ',ok', ',,', ',"fan, off"'])
@pytest.mark.parametrize('every', [1, 7])
def test_what_is_no_number_may_stand_right_of_the_last_heading(tmp_path, more, every):
    rows = [f'{k / 2},{100 * (k % 7)},{23 + k / 10:.1f},{k / 50}' + more * (k % every == 0) for k in range(60)]
    (recording,) = imported_text(tmp_path, HEADS, rows)
    assert len(recording['current']) == 60 and recording['current'].value[1] == pytest.approx(0.1)


def test_columns_without_a_heading_may_be_of_numbers_where_a_place_is_kept_for_it(tmp_path):
    rows = [f'{k},{k / 2},{100 * (k % 7)},{23 + k / 10:.1f},{k / 50},{k % 2}' for k in range(60)]
    (recording,) = imported_text(tmp_path, f',{HEADS},', rows)
    assert recording['temperature'].time[-1] == 29.5 and recording['temperature'].value[0] == pytest.approx(296.15)


@pytest.mark.parametrize('date', ['2024-05-03 ', '2024-05-03T', ''])
def test_a_comma_before_the_milliseconds_of_a_time_separates_nothing(tmp_path, date):
    rows = [f'{date}14:00:{k:02d},{300 + k},{100 * (k % 7)},{23 + k / 10:.1f},{k / 50}' for k in range(60)]
    (recording,) = imported_text(tmp_path, HEADS.replace('t (s)', 'asctime'), rows)
    assert recording['current'].value[1] == pytest.approx(0.1)
    assert recording['current'].time[-1] == pytest.approx(59.059)


def test_a_comma_of_thousands_separates_nothing_and_a_row_with_a_number_too_many_is_left_out(tmp_path):
    rows = [f'{k / 2},{950 + k:,.1f},{23 + k / 10:.1f},{k / 50}' for k in range(100)]
    rows[5] += ',7'
    (recording,) = imported_text(tmp_path, HEADS, rows)
    np.testing.assert_allclose(1e3 * recording['current'].value, [950 + k for k in range(100) if k != 5])
    assert '1 row(s) with more numbers than headings are left out, the first is row 7' in recording.notes


@pytest.mark.parametrize(
    ('heads', 'line', 'at'),
    [
        ('t (s),Load (g),I (mA),T (degC)', '{t:.2f},60,{I},{T}', (30, 50)),
        ('t (s),R (ohm),I (mA),T (degC)', '{t:.2f},14,{I},{T}', (30, 50)),
        ('t (s),I (mA),U (mV),T (degC)', '{t:.2f},{I},{U},{T}', (10, 30)),
        ('t (s),I (mA),T (degC)', '{k},{I},{T}', (30, 50)),  # whose time would run away
    ],
)
def test_two_whole_numbers_before_one_too_many_are_not_joined(tmp_path, heads, line, at):
    on = [k % 40 >= 20 for k in range(80)]
    rows = [
        line.format(k=k, t=k / 10 + 0.05, I=250 if on[k] else 5, U=999 if on[k] else 150, T=f'{23 + k / 10:.1f}')
        + ',1' * (k in at)
        for k in range(80)
    ]
    (without,) = imported_text(tmp_path, heads, rows)
    for run in (without, written(tmp_path, heads, rows)):
        assert '2 row(s) with more numbers than headings are left out, the first is row' in ' '.join(run.notes)
        np.testing.assert_allclose(run['temperature'].value[-1], 273.15 + 30.9)
        assert len(run['current']) == 78 and np.max(run['current'].value) == 0.25
        if 'Load' in heads:
            np.testing.assert_allclose(run['load'].value, 0.588399)


def test_numbers_with_thousands_throughout_are_to_be_put_in_quotes(tmp_path):
    cells = [f'{1250 + k:,}.0' for k in range(80)]
    heads = 't (s),P (mW),T (degC)'
    with pytest.raises(BadInput, match=re.escape('3 headings stand over 4 columns')) as refused:
        imported_text(tmp_path, heads, [f'{k},{cell},{23 + k / 10}' for k, cell in enumerate(cells)])
    assert 'where a comma parts thousands, put such numbers in quotes, as "1,250.0"; where' in str(refused.value)
    (recording,) = imported_text(tmp_path, heads, [f'{k},"{cell}",{23 + k / 10}' for k, cell in enumerate(cells)])
    assert recording['power'].value[0] == pytest.approx(1.25)
    with pytest.raises(BadInput, match='expected one over each; where the last columns'):
        imported_text(tmp_path, heads, [f'{k},1.5,{k + 0.25},{23 + k / 10}' for k in range(80)])
    with pytest.raises(BadInput, match='expected one over each; where the last columns'):
        imported_text(tmp_path, heads, [f'{k},250,{23 + k / 10:.1f}' + ',1' * (k % 3 == 0) for k in range(80)])


@pytest.mark.parametrize('off', [0, 5, 95])
@pytest.mark.parametrize('heads', [HEADS, HEADS.rpartition(',')[0]])
def test_a_comma_of_thousands_separates_nothing_where_a_drive_is_off_in_all_other_rows(tmp_path, heads, off):
    rows = [f'{k / 2},{12500 if k % 40 > 20 else off:,.1f},{53 + k / 10:.1f},{k / 50}' for k in range(100)]
    rows = rows if heads == HEADS else [row.rpartition(',')[0] for row in rows]
    (recording,) = imported_text(tmp_path, heads, rows)
    assert len(recording['current']) == 100 and np.max(recording['current'].value) == 12.5


def test_columns_with_decimal_commas_stand_beside_such_with_points(tmp_path):
    rows = [f'{k / 10:.1f};{13.993 + k / 1000:.3f};{f"{23 + k / 10:.2f}".replace(".", ",")}' for k in range(40)]
    path = tmp_path / 'run.csv'
    path.write_text('\n'.join(['t (s);R (ohm);T (degC)', *rows]) + '\n')
    (recording,) = imported(path, tmp_path)
    first = [recording[name].value[0] for name in ('resistance', 'temperature')]
    assert first == pytest.approx([13.993, 296.15]) and recording['resistance'].time[-1] == pytest.approx(3.9)


def test_a_number_of_a_spreadsheet_is_one_beside_texts_with_decimal_commas(tmp_path):
    openpyxl = pytest.importorskip('openpyxl', reason="needs the extra 'labs'")
    book = openpyxl.Workbook()
    for row in (['t [s]', 'R [ohm]'], *([k, 13.993 if k % 2 else '14,25'] for k in range(20))):
        book.active.append(row)
    book.save(tmp_path / 'mixed.xlsx')
    (recording,) = imported(tmp_path / 'mixed.xlsx', tmp_path)
    assert list(recording['resistance'].value[:2]) == [14.25, 13.993]


def test_a_column_that_does_not_read_is_left_out_and_said_to_be(tmp_path):
    (run,) = lab_text(tmp_path, 't (s),I (A),T (degC)', rows=[f'{k},0.2,warm' for k in range(20)])
    assert "'T (degC)' is left out: 0 of its 20 cells are numbers, for example 'warm' is none" in run.notes


@pytest.mark.parametrize(
    ('line', 'cell', 'last', 'rows'),
    [
        ('{k},0.2,{T}', '{:.2f}', '30,0.2,3', 30),
        ('{k},0.2,{T}', '{:.2f}', '30,0.2,32.', 30),
        ('{k},0.2,{T}', '{:.2f}', '30,0.2,32.8', 30),
        ('{k},0.2,{T}', '{:.3e}', '30,0.2,3.285e+0', 30),
        ('{k};0,2;{T}', '{:.2f}', '30;0,2;3', 30),
        ('{k} 0.2 {T}', '{:.2f}', '30 0.2 3', 30),
        ('t:{k} I:0.2 T:{T}', '{:.2f}', 't:30 I:0.2 T:3', 30),
        ('{k},0.2,{T}', '{:.2f}', '30,0.2', 30),
        ('{k},0.2,{T}', '{:.2f}', '30,0.2,32.85', 31),  # what is not torn
        ('{k},0.2,{T}', '{:.2f}', '30,0.2,9.85', 31),
        ('{k},0.2,{T}', '{:.3g}', '30,0.2,33', 31),
        ('{k},0.2,{T}', '{:.0f}', '30,0.2,9', 31),
    ],
)
def test_a_last_line_that_ends_within_a_number_is_left_out_and_said_to_be(tmp_path, line, cell, last, rows):
    written = [line.format(k=k, T=cell.format(23.0 + k / 4.0)) for k in range(30)]
    if ';' in line:
        written = [row.replace('.', ',') for row in written]
    heads = [] if ':' in line else [line.format(k='t_s', T='T_degC').replace('0.2', 'I_A').replace('0,2', 'I_A')]
    (tmp_path / 'run.csv').write_text('\n'.join([*heads, *written, last]))
    (recording,) = imported(tmp_path / 'run.csv', tmp_path)
    assert len(recording['temperature']) == rows
    assert ('the last line ends within a number' in ' '.join(recording.notes)) == (rows == 30)


def test_only_the_run_at_the_end_of_a_file_is_said_to_end_within_a_number(tmp_path):
    rows = [f'{k},{23 + k / 4:.2f}' for k in range(30)]
    (tmp_path / 'run.csv').write_text('\n'.join(['t_s,T_degC', *rows, 'reset', 't_s,T_degC', *rows, '30,3']))
    first, second = imported(tmp_path / 'run.csv', tmp_path)
    assert len(first['temperature']) == len(second['temperature']) == 30
    assert first.notes == () and 'ends within a number' in second.notes[0]


@pytest.mark.parametrize(
    ('written', 'unit'),
    [
        *[(megohms, None) for megohms in ('MOhm', 'Mohm', 'MOhms', 'M Ohm', 'MOHM', 'MOHMS', 'MΩ')],
        *[(milliohms, 'mohm') for milliohms in ('mOhm', 'mohms', 'Milliohm', 'MILLIOHM', 'mΩ')],
        *[(kilohms, 'kohm') for kilohms in ('kOhm', 'KOHM', 'KΩ')],
        *[('MA', 'mA'), ('OHMS', 'ohm')],
    ],
)
def test_the_case_of_a_unit_is_forgiven_but_for_megohms_which_are_no_milliohms(written, unit):
    assert meaning(f'resistance ({written})' if written != 'MA' else 'current (MA)').unit == unit


@pytest.mark.parametrize(
    'heads',
    [
        'Time (s)   Current (A)   Temp (C)',
        'Time (s) Current (A) Temp (C)',
        'Time (s) Heater current (A) Coil temp (C)',
        'Time (s)    Heater current    Coil temp (C)',
        '"Time (s)" "Current (A)" "Temp (C)"',
        '% Time_s Current_A Temp_C',
    ],
)
def test_headings_with_spaces_stand_over_their_columns(tmp_path, heads):
    (run,) = lab_text(tmp_path, heads, rows=[f'  {k / 10:.1f}     0.200    {23 + k / 100:.2f}' for k in range(20)])
    assert [(each.channel, each.unit) for each in run.columns] == [('current', 'A'), ('temperature', 'degC')]


def test_headings_that_fit_the_columns_in_no_way_are_refused(tmp_path):
    rows = [f'{k} 0.2 {23 + k / 100:.2f}' for k in range(20)]
    with pytest.raises(BadInput, match='4 headings stand over 3 columns'):
        lab_text(tmp_path, 'Time Heater current Temp', rows=rows)
    keys = {'table': {'delimiter': 'spaces'}, 'time': {'column': 'Time'}}
    with pytest.raises(BadInput, match='4 headings stand over 3 columns'):
        by_map(tmp_path, {**keys, 'columns': {'temperature': {'column': 'Temp'}}})
    keys['time'] = {'column': 0}
    assert len(by_map(tmp_path, {**keys, 'columns': {'temperature': {'column': 2}}})['temperature']) == 20


def by_map(tmp_path, keys):
    """The run.csv there as a map says."""
    path = tmp_path / 'map.yaml'
    path.write_text(json.dumps({**keys, 'runs': [{'file': 'run.csv'}]}))
    (found,) = import_runs(read_import_map(path), [tmp_path / 'run.csv'])
    return found.recording


@pytest.mark.parametrize('separator', [' ', '\t', ','])
def test_a_column_of_row_numbers_may_have_no_heading(tmp_path, separator):
    heads = separator.join(['"time_s"', '"current_A"', '"temp_C"'])
    rows = [separator.join([f'"{k + 1}"', f'{k / 10}', '0.2', f'{23 + k / 100}']) for k in range(20)]
    path = tmp_path / 'run.csv'
    path.write_text('\n'.join([heads, *rows]) + '\n')
    (recording,) = imported(path, tmp_path)
    assert recording['current'].value[0] == 0.2 and recording['temperature'].time[-1] == pytest.approx(1.9)


def test_spaces_in_a_stamp_or_a_heading_separate_nothing_where_tabs_do(tmp_path):
    rows = [f'12/3/2024 11:59:{k:02d}.500 PM\t{73 + k / 10}\t0.2' for k in range(40)]
    path = tmp_path / 'run.csv'
    path.write_text('\n'.join(['Time stamp\tCoil temp (Deg F)\tHeater I (A)', *rows]) + '\n')
    (recording,) = imported(path, tmp_path)
    assert recording['current'].value[0] == 0.2 and recording['temperature'].time[-1] == 39.0


@pytest.mark.parametrize('line', ['% columns: t, I_mA, T_C', '# t_s: t; I_mA; T_C', '% Spalten: t I_mA T_C'])
@pytest.mark.parametrize('separator', ['\t', ',', ' '])
def test_a_comment_may_name_the_columns(tmp_path, line, separator):
    rows = [separator.join([f'{k / 10}', '200', f'{23 + k / 100}']) for k in range(20)]
    path = tmp_path / 'run.csv'
    path.write_text('\n'.join(['% Test 4', line, '', *rows]) + '\n')
    (recording,) = imported(path, tmp_path)
    assert recording['current'].value[0] == 0.2 and recording['temperature'].time[-1] == pytest.approx(1.9)
    path.write_text('\n'.join([line, 't (s),I (A),T (degC)'.replace(',', separator), *rows]) + '\n')
    (recording,) = imported(path, tmp_path)
    assert recording['current'].value[0] == 200.0  # the headings straight above count


def test_the_unit_straight_after_each_number_is_that_of_its_column(tmp_path):
    pairs = [f't={100 * k}ms T={73 + k / 10:.1f}F i=200mA' for k in range(20)]
    table = [f'{100 * k}ms,{73 + k / 10:.1f}F,200mA' for k in range(20)]
    for lines, rows in ((['Booting...'], pairs), (['t,T,i'], table)):
        (run,) = lab_text(tmp_path, *lines, rows=rows)
        assert run.time.unit == 'ms'
        assert {each.channel: each.unit for each in run.columns} == {'temperature': 'degF', 'current': 'mA'}


@pytest.mark.parametrize('none', ['nan', 'inf', '-inf', 'ovf', 'OL', '---'])
def test_a_pair_without_a_number_takes_no_other_with_it(tmp_path, none):
    rows = [f't_ms:{500 * k} I_A:0.2 T_C:{none if k % 10 == 3 else 23 + k / 10} x_mm:{k / 50}' for k in range(60)]
    rows[20] = 'sensor reset, mode: slow'
    (tmp_path / 'run.log').write_text('\n'.join(['Muscle 1.2', *rows]) + '\n')
    (recording,) = imported(tmp_path / 'run.log', tmp_path)
    assert {name: len(channel) for name, channel in recording.channels.items()} == {
        'current': 59, 'displacement': 59, 'temperature': 53,
    }  # fmt: skip
    assert '1 line(s) between the rows are no name:value pairs and are left out, the first is 22' in recording.notes


@pytest.mark.parametrize('other', [2, 10], ids=['half the rate', 'a tenth of it'])
def test_vectors_of_a_matlab_file_at_two_rates_keep_their_own_times(tmp_path, other):
    t = np.arange(3000) / 10.0
    slow = {'T_degC': 23.0 + 0.01 * t[::other], 't_T_s': t[::other] + 0.05}
    fast = {'current_A': 0.2 * (t % 20 > 10), 't_s': t, 'contraction_mm': 0.01 * t}
    fit = {'t_fit_s': t[::4], 'x_fit_mm': 0.01 * t[::4], 'pid': np.arange(3.0)}  # nothing that is not there already
    for vectors in ({**slow, **fast, **fit}, {**fast, **slow, **fit}):
        savemat(tmp_path / 'run.mat', vectors)
        (run,) = imported(tmp_path / 'run.mat', tmp_path)
        assert {name: len(channel) for name, channel in run.channels.items()} == {
            'current': 3000, 'displacement': 3000, 'temperature': 3000 // other,
        }  # fmt: skip
        assert np.allclose(run['temperature'].time, t[::other] + 0.05)
        (note,) = [note for note in run.notes if note.startswith('left out')]
        assert note.endswith('t_fit_s (750), x_fit_mm (750), pid (3)')


def test_vectors_at_a_tenth_of_the_rate_may_be_most_of_a_matlab_file(tmp_path):
    t = np.arange(3000) / 10.0
    slow = {'t_slow_s': t[::10], 'T_degC': 23.0 + 0.01 * t[::10], 'R_ohm': 14.0 + 0.01 * t[::10], 'F_N': t[::10]}
    savemat(tmp_path / 'run.mat', {'t_s': t, 'current_A': 0.2 * (t % 20 > 10), **slow})
    (run,) = imported(tmp_path / 'run.mat', tmp_path)
    assert {name: len(channel) for name, channel in run.channels.items()} == {
        'current': 3000, 'temperature': 300, 'resistance': 300, 'force': 300,
    }  # fmt: skip


@pytest.mark.parametrize(('heading', 'name'), [('R cal (ohm)', 'resistance'), ('Bath (degC)', 'ambient')])
def test_a_calibration_beside_a_run_is_no_channel_of_it(tmp_path, heading, name):
    rows = [f'{k / 10},{0.2 * (k % 40 > 20)},{23 + k / 1000},,{20 + k / 100 if k < 250 else ""}' for k in range(3000)]
    (run,) = lab_text(tmp_path, f't (s),I (A),T (degC),,{heading}', rows=rows)
    assert name not in [column.channel for column in run.columns]
    assert f"'{heading}' is left out: 250 of its 3000 cells are numbers" in run.notes


def test_a_vector_of_a_matlab_file_that_no_time_fits_is_left_out_and_said_to_be(tmp_path):
    t = np.arange(300) / 10.0
    vectors = {'t_s': t, 'current_A': 0.2 * (t % 20 > 10), 'T_degC': 23.0 + 0.01 * np.arange(301)}
    savemat(tmp_path / 'run.mat', vectors)
    (run,) = imported(tmp_path / 'run.mat', tmp_path)
    assert set(run.channels) == {'current'} and len(run['current']) == 300
    assert run.notes == ('left out, being of another length than the times, or there already: T_degC (301)',)


def test_objects_in_json_objects_are_named_after_both(tmp_path):
    rows = [{'t_s': k / 2, 'sensors': {'temp_c': 23 + k / 10}, 'drive': {'i': {'ma': 200}}} for k in range(20)]
    (run,) = lab_text(tmp_path, rows=map(json.dumps, rows))
    assert [str(each.ref) for each in run.columns] == ["'sensors.temp_c'", "'drive.i.ma'"]


def test_a_map_by_index_loses_no_row_of_a_file_without_headings(tmp_path):
    (tmp_path / 'run.csv').write_text(''.join(f'{k},{23 + k}\n' for k in range(9)))
    keys = {'time': {'column': 0}, 'columns': {'temperature': {'column': 1, 'unit': 'degC'}}}
    for table in ({}, {'headings': []}):
        assert list(by_map(tmp_path, {**keys, 'table': table})['temperature'].value[[0, -1]]) == [296.15, 304.15]


def test_a_line_of_dashes_below_the_headings_is_no_part_of_them(tmp_path):
    rows = [f'{k}\t{23 + k / 10}\t0.3\t0.2' for k in range(20)]
    (run,) = lab_text(tmp_path, 'Time\tT\tIset\tImeas', '(s)\t(C)\t(A)\t(A)', '----\t----\t----\t----', rows=rows)
    assert [(each.channel, str(each.ref)) for each in run.columns] == [
        ('temperature', "'T'"), ('current_command', "'Iset'"), ('current', "'Imeas'")
    ]  # fmt: skip


def test_a_temperature_that_was_asked_for_is_none_that_was_measured(tmp_path):
    (run,) = lab_text(tmp_path, 't (s),Tset (C),T (C),Isoll (A)', rows=[f'{k},50,{23 + k},0.2' for k in range(20)])
    assert [str(each.ref) for each in run.columns] == ["'T (C)'", "'Isoll (A)'"] and run.left_out == ('Tset (C)',)


@pytest.mark.parametrize(
    ('times', 'said'),
    [
        (
            [k // 2 for k in range(40)],
            "the time 'time_s' stands still in 20 of 40 rows, first in row 3: 0 after 0; give",
        ),
        (
            [k * 17 % 40 for k in range(40)],
            "the time 'time_s' falls in 16 of 40 rows, first in row 5: 11 after 34; sort",
        ),
    ],
)
def test_a_time_that_is_none_of_each_row_is_said_to_be_so(tmp_path, times, said):
    with pytest.raises(BadInput, match=re.escape(said)) as refused:
        lab_text(tmp_path, 'time_s,I (A),T (degC)', rows=[f'{t},0.1,{23 + k}' for k, t in enumerate(times)])
    assert 'dt_s' in str(refused.value)


@pytest.mark.parametrize(('way', 'sign'), [(1.0, 1), (-1.0, -1)])
def test_a_change_of_length_that_grows_as_the_muscle_warms_is_its_contraction(tmp_path, way, sign):
    warmth = [min(k, 60 - k) for k in range(60)]
    rows = [f'{k},0.1,{23 + w},{way * w / 10:.3f}' for k, w in enumerate(warmth)]
    (run,) = lab_text(tmp_path, 't (s),I (A),T (degC),dL (mm)', rows=rows)
    (column,) = [column for column in run.columns if column.channel == 'displacement']
    assert column.sign == sign
    assert ("'dL (mm)' grows as the muscle warms: taken as its contraction" in run.notes) is (sign > 0)
