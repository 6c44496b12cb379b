import re

import numpy as np
import pandas as pd
import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.frames import of_frame, to_frame
from tcp_muscle_ros.recording.recording import CHANNELS, Channel, Recording


def test_a_recording_comes_back_from_its_frame():
    time = np.arange(5) / 10
    recording = Recording(
        'run',
        {
            'temperature': Channel('temperature', time, 293.15 + time, '/temperature'),
            'current_command': Channel('current_command', time[::2], time[::2], '/current_command'),
        },
        0,
        {'end': 'load'},
    )
    frame = to_frame(recording)
    assert list(frame.columns) == ['temperature_degC', 'current_command_A']
    assert frame.index.name == 'time_s' and frame.attrs == {'end': 'load'}
    assert frame['current_command_A'].isna().sum() == 2
    again = of_frame(frame)
    assert list(again) == list(recording) and again.known == {'end': 'load'}
    for name in recording:
        np.testing.assert_allclose(again[name].time, recording[name].time)
        np.testing.assert_allclose(again[name].value, recording[name].value)


def test_a_column_in_no_unit_of_its_channel_is_left_out():
    frame = pd.DataFrame(
        {'T (C)': [23.0, 24], 'Power (%)': [0.0, 40], 'Laser displacement (V)': [1.0, 2]}, index=[0.0, 1]
    )
    assert list(of_frame(frame)) == ['temperature']


def test_columns_as_a_lab_names_them_and_stamps():
    stamps = pd.to_datetime('2025-03-12') + pd.to_timedelta([0.0, 0.5, 1.5], unit='s')
    frame = pd.DataFrame(
        {'I (mA)': [0, 100, 200], 'Länge [mm]': [150.0, 149, 148], 'note': ['a', 'b', 'c']}, index=stamps
    )
    recording = of_frame(frame)
    np.testing.assert_allclose(recording['current'].value, [0, 0.1, 0.2])
    np.testing.assert_allclose(recording['displacement'].value, [0, 1e-3, 2e-3], atol=1e-12)
    np.testing.assert_allclose(recording['current'].time, [0, 0.5, 1.5])


RUN = pd.DataFrame({'T (C)': [23.0, 24, 26], 'I (A)': [0.0, 0.2, 0.2]}, index=[0.0, 0.5, 2.0])
STAMPS = pd.to_datetime('2025-03-12', utc=True) + pd.to_timedelta(RUN.index, unit='s')


@pytest.mark.parametrize(
    'frame',
    [
        RUN.set_axis(RUN.index * 1000).rename_axis('time_ms'),
        RUN.set_axis(RUN.index * 1000).rename_axis('t (ms)'),
        RUN.set_axis(RUN.index / 60).rename_axis('time_min'),
        RUN.rename_axis('sample'),
        RUN.set_axis(STAMPS),
        RUN.set_axis(STAMPS.tz_convert('Europe/Berlin')),
        RUN.set_axis(STAMPS.tz_localize(None)).rename_axis('time (ms)'),
        RUN.set_axis(STAMPS).rename_axis('time').reset_index(),
        RUN.set_axis(STAMPS.tz_convert('Europe/Berlin')).rename_axis('time (ms)').reset_index(),
    ],
    ids=lambda frame: f'{frame.index.name} {frame.index.dtype} {frame.columns[0]}',
)
def test_an_index_has_the_unit_of_its_name_and_stamps_may_have_a_zone(frame):
    np.testing.assert_allclose(of_frame(frame)['temperature'].time, RUN.index, rtol=1e-12)


VARIES = 0.5 + 0.1 * np.sin(np.arange(300) / 30)
STAYS = np.full(300, 0.5)


@pytest.mark.parametrize(
    ('columns', 'expected'),
    [
        ({'Load (N)': VARIES}, ['temperature', 'force']),
        ({'Load (N)': VARIES, 'Force (counts)': VARIES}, ['temperature', 'force']),
        ({'Load (N)': STAYS}, ['temperature', 'load']),
        ({'Load (N)': VARIES, 'Force (N)': VARIES}, ['temperature', 'load', 'force']),
        ({'load_N': VARIES}, ['temperature', 'load']),
        ({'load': VARIES}, ['temperature', 'load']),
    ],
)
def test_a_load_that_varies_is_a_force_unless_its_column_is_named_as_ours(columns, expected):
    recording = of_frame(pd.DataFrame({'T (C)': 23 + VARIES, **columns}))
    assert list(recording) == expected
    taken = "'Load (N)' varies: taken as a force that was measured" in ' '.join(recording.notes)
    assert taken is ('Load (N)' in columns and 'load' not in expected)
    assert {name: recording.unit(name) for name in recording} == {n: CHANNELS[n].unit for n in expected}


def test_a_load_that_is_said_to_be_one_is_one():
    frame = pd.DataFrame({'T (C)': 23 + VARIES, 'Load (N)': VARIES})
    assert list(of_frame(frame, channels={'load': 'Load (N)'})) == ['temperature', 'load']


def test_a_length_shrinks_from_its_first_number():
    frame = pd.DataFrame({'length_mm': [np.nan, 100.0, 99.0, np.nan, 98.0]}, index=[0.0, 1, 2, 3, 4])
    displacement = of_frame(frame)['displacement']
    np.testing.assert_allclose(displacement.value, [0, 1e-3, 2e-3], atol=1e-12)
    np.testing.assert_allclose(displacement.time, [1, 2, 4])


@pytest.mark.parametrize(
    ('columns', 'said'),
    [
        ({'t': [0, 1], 'note': ['a', 'b']}, 'no column is a channel'),
        ({'t': [0, 0], 'T (C)': [1, 2]}, 'does not increase'),
        ({'t': [0, 1], 'T (C)': [1, 2], 'temp_degC': [1, 2]}, 'two columns are temperature'),
        ({'t': [0, 1], 'T (C)': [1, 2], 'I (A)': [None, None]}, "no number in column 'I \\(A\\)'"),
        ({'t': [0, 1], 'T (C)': [1, 2], 'L (mm)': [np.nan, np.inf]}, "no number in column 'L \\(mm\\)'"),
        ({'t': [0, 1], 'T (C)': [1, 2], 'I (A)': [0.2, 'OL']}, "column 'I \\(A\\)' is not all numbers .*'OL'"),
        ({'t': [0, 1], 'T (C)': [1, [2]]}, "column 'T \\(C\\)' is not all numbers"),
        ({'t': ['x', 'y'], 'T (C)': [1, 2]}, 'expected seconds'),
    ],
)
def test_what_is_no_recording_is_refused(columns, said):
    with pytest.raises(BadInput, match=said):
        of_frame(pd.DataFrame(columns))


@pytest.mark.parametrize('twice', ['t', 'T (C)'])
def test_two_columns_of_one_name_are_refused_where_they_are_read(twice):
    frame = pd.DataFrame({'t': [0, 1], 'T (C)': [1, 2], 'note': ['a', 'b']})
    with pytest.raises(BadInput, match=f"2 columns are named '{re.escape(twice)}'; expected one"):
        of_frame(pd.concat([frame, frame[[twice]]], axis=1))
    assert list(of_frame(pd.concat([frame, frame[['note']]], axis=1))) == ['temperature']


WARM = 23 + 20 * np.sin(np.arange(400) / 60) ** 2


@pytest.mark.parametrize('dtype', ['f4', 'f8', object])
@pytest.mark.parametrize('none', [-999.9, 9.9e37, -9999.0, -273.2, 1e31, np.inf, np.nan])
def test_what_stands_for_no_number_is_left_out_of_a_frame(none, dtype):
    temperature = WARM.astype(dtype)
    temperature[100:103] = none
    recording = of_frame(pd.DataFrame({'T (C)': temperature, 'I (A)': WARM}))
    np.testing.assert_allclose(recording['temperature'].value - 273.15, np.delete(WARM, [100, 101, 102]), rtol=1e-5)
    assert len(recording['current']) == 400
    assert ("'T (C)': 3 of 400 values are " in ' '.join(recording.notes)) is not np.isnan(none)


def test_a_length_that_begins_with_no_number_shrinks_from_its_first():
    frame = pd.DataFrame({'length (mm)': np.concatenate([[-999.9], 100 - WARM / 10])})
    displacement = of_frame(frame)['displacement']
    assert displacement.value[0] == 0.0 and np.abs(displacement.value).max() < 3e-3


def test_numbers_that_are_high_but_not_far_from_the_others_are_kept():
    frame = pd.DataFrame({'R (mohm)': 999.0 + np.arange(100) % 30, 'I (mA)': 9990.0 + np.arange(100) % 10})
    recording = of_frame(frame)
    assert len(recording['resistance']) == len(recording['current']) == 100 and not recording.notes


@pytest.mark.parametrize('sign', [1, -1])
@pytest.mark.parametrize('heading', ['distance (mm)', 'gap (mm)'])
@pytest.mark.parametrize('by', ['T (C)', 'I (A)'])
def test_a_distance_is_the_contraction_whichever_way_it_goes(heading, sign, by):
    warm = {'T (C)': WARM, 'I (A)': (WARM - 23) ** 0.5}
    frame = pd.DataFrame({by: warm[by], heading: 30 + sign * (WARM - 23) / 10}, index=np.arange(400) * 30.0)
    recording = of_frame(frame)
    np.testing.assert_allclose(recording['displacement'].value, (WARM - 23) / 1e4, atol=1e-9)
    assert ('its sign is turned' in ' '.join(recording.notes)) is (sign < 0)


def test_a_distance_of_which_nothing_tells_the_sign_is_refused_unless_it_is_said():
    frame = pd.DataFrame({'T (C)': WARM, 'gap (mm)': np.cos(np.arange(400))})
    with pytest.raises(BadInput, match=r"'gap \(mm\)' is a distance that grows or falls .* in it tells which"):
        of_frame(frame)
    said = of_frame(frame, channels={'displacement': 'gap (mm)'})['displacement'].value
    np.testing.assert_allclose(said, 1e-3 * (np.cos(np.arange(400)) - 1.0))


def test_a_distance_beside_a_displacement_is_not_asked():
    frame = pd.DataFrame({'T (C)': WARM, 'gap (mm)': np.cos(np.arange(400)), 'stroke (mm)': WARM})
    assert of_frame(frame)['displacement'].topic == 'stroke (mm)'


def test_columns_of_several_levels_are_refused():
    with pytest.raises(BadInput, match='columns have 2 levels; expected one'):
        of_frame(pd.concat({'a': RUN, 'b': RUN}, axis=1))
