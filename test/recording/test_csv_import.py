import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files, unclaimed
from tcp_muscle_ros.recording.import_map import read_import_map

REPOSITORY = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get('TCP_MUSCLE_SHARED', REPOSITORY.parent / 'shared')) / 'data'
real_data = pytest.mark.skipif(
    not DATA.is_dir(), reason='the recordings of other labs are not part of this repository (TCP_MUSCLE_SHARED)'
)


@pytest.fixture
def imported(tmp_path):
    """Import one CSV text with one map text; returns the runs by name."""

    def run(csv, import_map, name='run_1.csv'):
        (tmp_path / name).write_text(csv)
        (tmp_path / 'map.yaml').write_text(import_map)
        runs = import_runs(read_import_map(tmp_path / 'map.yaml'), [tmp_path / name])
        return {run.name: run.recording for run in runs}

    return run


STROKE = """
time: {column: t, unit: ms}
columns: {displacement: {column: x, unit: mm}}
runs: [{file: 'run_*.csv'}]
"""


def test_units_signs_scales_offsets_and_time_from_the_first_row(imported):
    recording = imported(
        't,x,f,T\n100,1.5,10,32\n350,2,20,212\n',
        """
        time: {column: t, unit: ms}
        columns:
          displacement: {column: x, unit: cm, sign: -1, offset: first}
          force: {column: 2, unit: g, scale: 10, offset: -100}
          temperature: {column: T, unit: degF}
          load: {value: 40, unit: g}
        known: {rest_length_m: 0.2, trial: '1-1'}
        end: blocked
        runs: [{file: 'run_*.csv'}]
        """,
    )['run_1']
    np.testing.assert_allclose(recording['displacement'].time, [0, 0.25])
    np.testing.assert_allclose(recording['displacement'].value, [0, -0.005], atol=1e-15)
    np.testing.assert_allclose(recording['force'].value, [0, 0.980665], atol=1e-15)
    np.testing.assert_allclose(recording['temperature'].value, [273.15, 373.15])
    np.testing.assert_allclose(recording['load'].value, [0.392266, 0.392266])
    assert recording.known == {'rest_length_m': 0.2, 'trial': '1-1', 'end': 'blocked', 'source_file': 'run_1.csv'}


def test_stamps_beside_seconds_begin_with_the_run_and_seconds_beside_stamps_count_on(imported):
    channel = 'columns: {displacement: {column: x, unit: mm, time: {column: 1, unit: %s}}}'
    keys = 'time: {column: 0, unit: %s}\n' + channel + "\nruns: [{file: 'run_*.csv'}]\n"
    (recording,) = imported('a,b,x\n5,10:00:00,1\n6,10:00:02,2\n', keys % ('s', 'clock')).values()
    np.testing.assert_allclose(recording['displacement'].time, [0, 2])
    (recording,) = imported('a,b,x\n10:00:00,5,1\n10:00:02,6,2\n', keys % ('clock', 's')).values()
    np.testing.assert_allclose(recording['displacement'].time, [5, 6])


def test_what_is_no_column_has_no_sample_in_rows_without_a_time(imported):
    (recording,) = imported(
        't,x,other\n0,1,4\n1,2,5\n,,6\n2,3,7\n,,8\n',
        """
        table: {headings: [1]}
        time: {column: t}
        columns: {displacement: {column: x, unit: mm}, load: {value: 60, unit: g}}
        input: {power: {schedule: [{duration_s: 1.5, value: 0}, {duration_s: 1, value: 3}]}}
        runs: [{file: 'run_*.csv'}]
        """,
    ).values()
    np.testing.assert_allclose(recording['load'].time, [0, 1, 2])
    np.testing.assert_allclose(recording['power'].time, [0, 1, 1.5, 2])
    np.testing.assert_allclose(recording['power'].value, [0, 0, 3, 3])


def test_a_schedule_switches_at_its_own_times_between_the_rows(imported):
    recording = imported(
        'x\n' + '0\n' * 11,
        """
        dt_s: 1
        columns: {displacement: {column: x, unit: mm}}
        input: {power: {unit: mW, repeat: 2, schedule: [{duration_s: 2.5, value: 500}, {duration_s: 2, value: 0}]}}
        runs: [{file: run_1.csv}]
        """,
    )['run_1']
    power = recording['power']
    at = {2.0: 0.5, 2.5: 0.0, 4.0: 0.0, 4.5: 0.5, 6.0: 0.5, 7.0: 0.0, 9.0: 0.0, 10.0: 0.0}
    for time, value in at.items():
        assert power.value[np.searchsorted(power.time, time, side='right') - 1] == value
    assert {2.5, 4.5} <= set(power.time)


def test_an_input_that_switches_between_two_rows_does_so_in_the_bag_too(imported, tmp_path):
    """5 ms before a row as well as 45 ms, of rows that are 100 ms apart."""
    rows = [(k / 10, 20 + k, k > 4) for k in range(10)] + [(0.395, '', 1), (0.755, '', 0)]
    recording = imported(
        't,T,i\n' + ''.join(f'{t},{T},{int(i)}\n' for t, T, i in sorted(rows, key=lambda row: row[0])),
        """
        time: {column: t, unit: s}
        columns: {temperature: {column: T, unit: degC}}
        input: {current: {column: i, unit: A}}
        runs: [{file: run_1.csv}]
        """,
    )['run_1']
    write_recording(tmp_path / 'bag', recording)
    current = read_bag(tmp_path / 'bag')['current']
    np.testing.assert_array_equal(current.time, recording['current'].time)
    assert {0.395, 0.755} <= set(current.time)


def test_a_channel_may_be_called_as_its_topic(imported):
    csv_map = 'dt_s: 1\ncolumns: {ambient_temperature: {column: t}}\nruns: [{file: run_1.csv}]'
    recording = imported('t\n20\n21\n', csv_map)['run_1']
    assert recording['ambient'].value.tolist() == [293.15, 294.15]


def test_repeated_headings_are_told_apart_by_occurrence_or_index(imported):
    runs = imported(
        't,x,x\n0,1,5\n1,2,6\n',
        """
        time: {column: t}
        runs:
          - {file: run_1.csv, name: a, columns: {force: {column: x, occurrence: 2}}}
          - {file: run_1.csv, name: b, columns: {force: {column: 1}}}
        """,
    )
    assert runs['a']['force'].value.tolist() == [5, 6]
    assert runs['b']['force'].value.tolist() == [1, 2]
    with pytest.raises(BadInput, match=r"'x' stands over columns 1, 2; say which with occurrence: 1 to 2"):
        imported('t,x,x\n0,1,5\n1,2,6\n', STROKE)


def test_groups_are_overridden_by_runs_and_known_facts_are_joined(imported):
    runs = imported(
        't,x\n0,1\n1,2\n',
        """
        time: {column: t}
        known: {rig: r, air: still}
        columns: {displacement: {column: x, unit: mm}}
        groups:
          fast: {dt_s: 0.1, known: {air: forced}}
        runs:
          - {file: run_1.csv, group: fast, known: {trial: 3}}
          - {file: run_1.csv, group: fast, name: other, time: {column: t, unit: min}}
        """,
    )
    assert runs['fast_run_1'].known | {'source_file': ''} == {
        'rig': 'r', 'air': 'forced', 'trial': 3, 'group': 'fast', 'source_file': '',
    }  # fmt: skip
    assert runs['fast_run_1'].duration == 0.1
    assert runs['other'].duration == 60.0


def test_empty_cells_are_missing_samples_and_blank_lines_are_nothing(imported):
    recording = imported('t,x\n0,1\n\n1,\n2,3\n,\n', STROKE)['run_1']
    assert recording['displacement'].time.tolist() == [0, 0.002]
    assert recording.notes == ('displacement: 1 of 3 rows have no number',)


def test_rows_that_a_logger_wrote_twice_count_once(imported):
    recording = imported('t,x\n0,1\n1,2\n1,2\n2,3\n', STROKE)['run_1']
    assert recording['displacement'].time.tolist() == [0, 0.001, 0.002]
    assert recording.notes == ('1 row(s) that repeat the one before, time and all, are left out',)


def test_other_separators_and_a_byte_order_mark(imported, tmp_path):
    (tmp_path / 'run_1.csv').write_bytes('\ufefft;x\r\n0;1\r\n1;2\r\n'.encode())
    (tmp_path / 'map.yaml').write_text(STROKE + "delimiter: ';'\n")
    (run,) = import_runs(read_import_map(tmp_path / 'map.yaml'), [tmp_path / 'run_1.csv'])
    np.testing.assert_allclose(run.recording['displacement'].value, [0.001, 0.002])


@pytest.mark.parametrize(
    ('csv', 'says'),
    [
        ('t,x\n0,1\n1,high\n', r"run_1.csv: row 3, column 'x': 'high' is not a number"),
        ('t,x\n0,1\n\n2,3\n1,2\n', r"run_1.csv: row 5, column 't': time runs backwards, 0.001 s after 0.002 s"),
        (
            't,x\n0,1\n0,2\n',
            r"run_1.csv: row 3, column 't': time stands still at 0 s; where rows come evenly, say dt_s",
        ),
        ('t,x\n0,1\n,2\n', r"run_1.csv: row 3, column 't': no time"),
        ('t,X\n0,1\n', r"run_1.csv: no column 'x'; did you mean 'X'.*see .*map.yaml: runs 1"),
        ('t,x\n0,\n1,\n', r"no number for channel 'displacement'"),
        ('t,x\n', 'no data: expected a row of headings and rows of numbers'),
        ('', 'no data'),
    ],
)
def test_a_file_that_is_not_what_the_map_says_is_answered_with_file_row_and_column(imported, csv, says):
    with pytest.raises(BadInput, match=says) as caught:
        imported(csv, STROKE)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('change', 'says'),
    [
        (('columns', 'colums'), "unknown key 'colums'; did you mean 'columns'"),
        (('displacement', 'displacment'), "unknown channel 'displacment'; did you mean 'displacement'"),
        (('unit: mm', 'unit: mmm'), "unknown unit 'mmm'; did you mean 'mm'"),
        (('unit: mm', 'unit: N'), "'N' is a unit of force, expected one of length"),
        (('unit: mm', 'sing: -1'), "unknown key 'sing'; did you mean 'sign'"),
        (('unit: mm', 'sign: 2'), 'sign is 2, expected 1 or -1'),
        (('unit: mm', 'offset: last'), "offset is 'last', expected a number"),
        (('column: x', 'column: 7'), 'no column 7, it has 2'),
        (('column: x', 'column: x, occurrence: 2'), "the heading 'x' occurs 1 time"),
        (('column: x,', ''), "the key 'column' is missing"),
        (('time: {column: t, unit: ms}', ''), "neither 'time' .* nor 'dt_s'"),
        (('time:', 'dt_s: 0.1\ntime:'), 'both time and dt_s are given'),
        (("file: 'run_*.csv'", "file: 'run_*.csv', group: a"), 'group'),
        (("file: 'run_*.csv'", 'file: other.csv'), 'none of the 1 file.* is a run of this map'),
        (("file: 'run_*.csv'", "file: 'run_*.csv', name: '{trial}'"), r'expected a text with \{stem\} or \{parent\}'),
        (("file: 'run_*.csv'", "file: 'run_*.csv', name: '{stem.foo}'"), 'expected a text with'),
        (("file: 'run_*.csv'", "file: 'run_*.csv', name: '{stem[a]}'"), 'expected a text with'),
        (('runs:', "ignore: ['']\nruns:"), "ignore: '' is no file pattern, expected such as"),
        (('runs:', 'ignore: [a.csv, 3]\nruns:'), 'ignore: 3 is no file pattern'),
        (('unit: mm', f'scale: 1{"0" * 400}'), 'scale is inf, expected a finite number'),
        (
            ("runs: [{file: 'run_*.csv'}]", "runs: [{file: 'run_*.csv'}, {file: run_1.csv}]"),
            "two runs are named 'run_1'",
        ),
        (('runs:', 'input: {force: {column: x}}\nruns:'), "input: unknown key 'force'"),
        (('runs:', 'input: {power: {schedule: [{duration_s: 1}]}}\nruns:'), "schedule 1: the key 'value' is missing"),
    ],
)
def test_a_mistake_in_the_map_is_answered_with_the_key_and_the_nearest_valid_one(imported, change, says):
    with pytest.raises(BadInput, match=says) as caught:
        imported('t,x\n0,1\n1,2\n', STROKE.replace(*change))
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('rows', 'unit', 'says'),
    [
        (
            50_000_000 * np.arange(200),
            's',
            r"row 201, column 't': the run lasts 9.95e\+09 s, its time being in 's'.*unit: ns",
        ),
        (50 * np.arange(20_000), 'min', 'did you mean unit: ms'),
        (0.05 * np.arange(200_000), 'h', r'did you mean unit: s\?'),
        (
            np.append(np.arange(100), 1.6e9 + np.arange(50)),
            's',
            r"row 102, column 't': time jumps by 1.6e\+09 s, where",
        ),
        (1e5 * np.arange(2000), 's', 'no run lasts a year; did you mean unit: us'),
        (1e30 * np.arange(5), 's', 'no run lasts a year; see time in'),
    ],
)
def test_a_time_that_cannot_be_in_its_unit_is_answered_with_the_nearest_that_it_can(imported, rows, unit, says):
    with pytest.raises(BadInput, match=says):
        imported(
            't,x\n' + ''.join(f'{t!r},1\n' for t in rows.tolist()),
            STROKE.replace('column: t, unit: ms', f'column: t, unit: {unit}'),
        )


def test_a_period_with_which_the_rows_last_for_years_is_refused(imported):
    with pytest.raises(
        BadInput, match=r'runs 1: dt_s is 1e\+300 s, with which the 2 rows of .*run_1.csv last 1e\+300 s'
    ):
        imported('t,x\n0,1\n1,2\n', STROKE.replace('time: {column: t, unit: ms}', 'dt_s: 1.0e+300'))


def test_files_are_found_below_directories_and_misspelt_ones_are_named(tmp_path):
    (tmp_path / 'a').mkdir()
    for name in ('a/2.csv', 'a/1.csv', 'a/notes.txt'):
        (tmp_path / name).touch()
    assert [path.name for path in lab_files([tmp_path, tmp_path / 'a' / '1.csv'])] == ['1.csv', '2.csv']
    with pytest.raises(BadInput, match=r"no such file; did you mean '1\.csv'"):
        lab_files([tmp_path / 'a' / '1.cvs'])


def runs_of(rig):
    import_map = read_import_map(REPOSITORY / 'config' / f'import_{rig}.yaml')
    files = lab_files([DATA / rig])
    assert unclaimed(import_map, files) == []
    return {run.name: run.recording for run in import_runs(import_map, files)}


def test_what_is_known_by_dates_and_numbers_goes_into_the_bag(imported, tmp_path):
    given = 'known: {calibrated: {2020-01-01: 3, 2: [{1.5: 2021-01-01}]}}\nruns:'
    (recording,) = imported('t,x\n0,1\n1,2\n', STROKE.replace('runs:', given)).values()
    write_recording(tmp_path / 'bag', recording)
    assert read_bag(tmp_path / 'bag').known['calibrated'] == {'2020-01-01': 3, '2': [{'1.5': '2021-01-01'}]}


@real_data
def test_all_runs_of_the_bench_rig_are_imported():
    runs = runs_of('tca_bench_rig')
    groups = Counter(recording.known['group'] for recording in runs.values())
    assert groups == {'stroke': 24, 'blocked_force': 15, 'blocked_force_trial1': 21}
    assert sum(recording.known.get('outlier', False) for recording in runs.values()) == 2
    assert sum('rest_length_m' in recording.known for recording in runs.values()) == 17
    for name, recording in runs.items():
        watts = recording.known['power_w']
        power = recording['power']
        assert set(power.value) == {0.0, float(watts)}, name
        assert f'_{watts}W_' in name
        assert f'/{watts}W/' in str(recording.known['source_file'])
        on = power.time[power.value > 0]
        assert 20 < on[0] < 32, name  # about 24 to 25 s off, 30 s on
        assert 25 < on[-1] - on[0] < 36, name
        output = recording['displacement' if recording.known['end'] == 'load' else 'force']
        while_on = output.value[(power.value > 0)]
        assert while_on[-20:].mean() > output.value[:50].mean(), name  # contraction and pull are positive
    assert runs['stroke_3W_3a'].known['rest_length_m'] == 0.1519
    assert runs['stroke_1W_1']['load'].value[0] == 0.0980665
    assert runs['force_4W_1']['force'].value[0] == pytest.approx(-0.0024e-3 * 9.80665)


@real_data
def test_all_columns_of_the_video_rig_are_imported():
    runs = runs_of('tca_video_rig')
    assert len(runs) == 13
    columns = sum(
        heading not in ('t', 'actual_vid_time')
        for file in lab_files([DATA / 'tca_video_rig'])
        for heading in file.read_text().splitlines()[0].split(',')
    )
    assert columns == 13
    for name, recording in runs.items():
        displacement, power = recording['displacement'], recording['power']
        assert displacement.value[0] == 0
        assert displacement.value.max() > 0.0008, name  # contraction is positive
        period = 30 if 'step' in name else 10
        off = power.time % (2 * period) >= period
        assert set(power.value[off & (power.time < 60)]) == {0.0}
        assert set(power.value[~off & (power.time < 60)]) == {float(recording.known['power_w'])}
        assert recording['load'].value[0] == pytest.approx(recording.known['load_n'])
    second = runs['mandrel_3W_free_2']['displacement']
    np.testing.assert_allclose(second.value[:4], [0, 0.003, 0.008, 0.012], atol=1e-12)  # 23.1 22.8 22.3 21.9 cm
    assert runs['mandrel_3W_forced_1'].known['air'] == 'forced'


@real_data
def test_an_imported_run_is_the_same_when_read_from_its_bag(tmp_path):
    recording = runs_of('tca_video_rig')['self_coiled_3W_free_2']
    write_recording(tmp_path / 'bag', recording)
    back = read_bag(tmp_path / 'bag')
    assert back.known == recording.known
    for name, channel in recording.channels.items():
        np.testing.assert_array_equal(back[name].time, channel.time)
        np.testing.assert_allclose(back[name].value, channel.value, rtol=1e-15)
