import json
import re
import shutil
import sqlite3
from contextlib import closing

import mcap.writer
import numpy as np
import pytest
from recording.bags import START, STORE, float64, joint_states, temperature, write_foreign
from rosbags.rosbag2 import StoragePlugin, Writer

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording import mcap_file, sqlite_file
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import BagWriter, write_recording
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.recording.tick_times import Ticks

MS = 1_000_000


def ticks(n=100, ns='/m1', period_ms=10):
    """What a muscle publishes: a stamped temperature, and unstamped messages that arrive a little later."""
    rows = []
    for k in range(n):
        stamp = START + k * period_ms * MS
        rows.append((f'{ns}/temperature', stamp + 1 * MS, temperature(20.0 + k, stamp)))
        rows.append((f'{ns}/displacement', stamp + 2 * MS, float64(k * 1e-3)))
        rows.append((f'{ns}/current', stamp + 3 * MS, float64(0.1)))
    return rows


@pytest.mark.parametrize('storage', list(StoragePlugin))
def test_channels_are_found_on_the_stamps_of_their_ticks_in_si(tmp_path, storage):
    recording = read_bag(write_foreign(tmp_path / 'bag', ticks(), storage))
    assert set(recording) == set(recording.channels) == {'temperature', 'displacement', 'current'}
    assert recording.start_ns == START
    np.testing.assert_array_equal(recording['temperature'].value, 293.15 + np.arange(100))
    for channel in recording.channels.values():
        np.testing.assert_array_equal(channel.time, np.arange(100) / 100)
    assert recording['displacement'].topic == '/m1/displacement'
    assert recording.duration == 0.99
    assert recording.notes == ()


@pytest.mark.parametrize('storage', list(StoragePlugin))
def test_what_is_read_some_at_a_time_is_what_is_read_at_once(tmp_path, storage, monkeypatch):
    bag = write_foreign(tmp_path / 'bag', ticks(400), storage)
    at_once = read_bag(bag)
    monkeypatch.setattr(mcap_file, 'BATCH', 1000)
    monkeypatch.setattr(sqlite_file, '_ROWS', 7)
    by_and_by = read_bag(bag)
    assert by_and_by.start_ns == at_once.start_ns
    for name, channel in at_once.channels.items():
        assert len(channel) == 400
        np.testing.assert_array_equal(by_and_by[name].time, channel.time)
        np.testing.assert_array_equal(by_and_by[name].value, channel.value)


def test_one_field_can_be_two_channels(tmp_path):
    bag = write_foreign(tmp_path / 'bag', ticks())
    for name in ('ambient', 'ambient_temperature'):  # of the channel, or of its topic
        recording = read_bag(bag, channels={name: 'temperature'})
        np.testing.assert_array_equal(recording['ambient'].value, recording['temperature'].value)


def test_order_in_the_file_is_not_time_order(tmp_path):
    rows = ticks()
    shuffled = [rows[k] for k in np.random.default_rng(0).permutation(len(rows))]
    mixed, sorted_ = (read_bag(write_foreign(tmp_path / n, r)) for n, r in (('a', shuffled), ('b', rows)))
    for name in sorted_.channels:
        np.testing.assert_array_equal(mixed[name].time, sorted_[name].time)
        np.testing.assert_array_equal(mixed[name].value, sorted_[name].value)


def test_a_message_further_than_half_a_period_from_any_tick_keeps_its_log_time(tmp_path):
    rows = ticks()
    late = START + 99 * 10 * MS + 50 * MS
    rows.append(('/m1/load', late, float64(1.0)))
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording['load'].time.tolist() == [(late - START) / 1e9]


def test_without_stamped_messages_log_times_are_the_times(tmp_path):
    rows = [row for row in ticks() if row[0] != '/m1/temperature']
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    np.testing.assert_allclose(recording['current'].time[0], 0.001, atol=1e-12)


def test_messages_stay_with_their_ticks_when_several_ticks_arrive_at_once(tmp_path):
    """A stall of reception: five ticks of 1 ms arrive within 0.2 ms, every message with its own delay."""
    rng, rows = np.random.default_rng(4), []
    for k in range(2000):
        stamp = START + k * MS
        arrival = START + (k + 5 - k % 5) * MS + (k % 5) * 40_000
        rows.append(('/temperature', arrival, temperature(k, stamp)))
        rows.append(('/displacement', arrival + int(rng.integers(5_000, 26_000)), float64(k)))
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    np.testing.assert_allclose(recording['temperature'].value - 273.15, recording['displacement'].value, atol=1e-9)
    np.testing.assert_array_equal(recording['temperature'].time, recording['displacement'].time)


def test_a_topic_published_every_tenth_tick_meets_its_ticks(tmp_path):
    rows = [row for k, row in enumerate(ticks(1000)) if row[0] != '/m1/displacement' or (k // 3) % 10 == 3]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    np.testing.assert_array_equal(recording['displacement'].time, np.arange(3, 1000, 10) / 100)


@pytest.mark.parametrize('period', [20 * MS, 35 * MS, 130 * MS], ids=['laser', 'camera', 'meter'])
def test_a_topic_that_keeps_a_rhythm_of_its_own_stays_at_its_log_times(tmp_path, period):
    """Beside a thermometer at 10 Hz, whose stamps are no ticks of theirs: a laser was 40 ms late on average."""
    rows = [('/temperature', START + k * 100 * MS + 2 * MS, temperature(20, START + k * 100 * MS)) for k in range(200)]
    logged = START + np.arange(20_000 * MS // period) * period + 1 * MS
    rows += [('/displacement', int(log), float64(k)) for k, log in enumerate(logged)]
    recording = read_bag(write_foreign(tmp_path / 'bag', sorted(rows, key=lambda row: row[1])))
    np.testing.assert_allclose(recording['displacement'].time, (logged - START) / 1e9, atol=1e-12)


@pytest.mark.parametrize('messages', [1198, 1199, 41_000])
@pytest.mark.parametrize('ratio', [(2, 1), (2, 3), (3, 1)], ids=['twice', 'two thirds', 'three times'])
@pytest.mark.parametrize('aside', [0.0, 0.15])
def test_a_topic_of_which_only_some_messages_lie_on_ticks_stays_at_its_log_times(messages, ratio, aside):
    """At twice the rate half of the messages lie on a tick: those between were moved onto one, 50 ms away."""
    rng = np.random.default_rng(0)
    stamp = START + np.arange(messages * ratio[1] // ratio[0] + 2) * 100 * MS
    published = START + ((np.arange(messages) * ratio[1] / ratio[0] + aside) * 100 * MS).astype(np.int64)
    ticks = Ticks(stamp + 2 * MS + rng.exponential(MS / 2, len(stamp)).astype(np.int64), stamp)
    log = published + 2 * MS + rng.exponential(MS / 2, messages).astype(np.int64)
    np.testing.assert_array_equal(ticks.of(log), log)


def test_while_a_muscle_is_silent_for_long_what_is_said_to_it_still_meets_its_ticks(tmp_path):
    said = [START + k * 10 * MS for k in range(1000)]
    rows = [('/m1/temperature', stamp + 2 * MS, temperature(20.0, stamp)) for k, stamp in enumerate(said) if k < 400]
    rows += [('/m1/current_command', stamp + 3 * MS, float64(0.1)) for stamp in said]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    np.testing.assert_array_equal(recording['current_command'].time[:400], np.arange(400) / 100)


def test_the_order_of_a_topics_messages_is_never_changed(tmp_path):
    rng, rows = np.random.default_rng(5), []
    arrival = START
    for k in range(3000):
        arrival = max(arrival, START + k * MS) + int(rng.exponential(0.3 * MS))
        rows.append(('/temperature', arrival, temperature(k, START + k * MS)))
        rows.append(('/displacement', arrival + int(rng.exponential(0.5 * MS)), float64(k)))
    rows.sort(key=lambda row: row[1])
    published = [m.data for topic, _, (_, m) in rows if topic == '/displacement']
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording['displacement'].value.tolist() == published
    assert np.all(np.diff(recording['displacement'].time) > 0)


def test_while_a_muscle_is_silent_what_is_said_to_it_keeps_its_log_times(tmp_path):
    """Killed for two seconds, in the middle and at the end: one message beside a tick moves none of those far from it.

    Each tick is stamped 3 ms after it was logged, so that a second message near the last of them comes before it.
    """
    logged = [START + k * 10 * MS for k in (*range(1000), *range(1200, 1500))]
    commands = [*(START + k * 10 * MS for k in range(1700)), START + 999 * 10 * MS + MS, START + 1499 * 10 * MS + MS]
    rows = [('/m1/temperature', log, temperature(20.0, log + 3 * MS)) for log in logged]
    rows += [('/m1/current_command', log, float64(0.1)) for log in commands]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    times = recording.start_ns - START + np.round(recording['current_command'].time * 1e9)
    assert np.abs(times - (np.sort(commands) - START)).max() < 10 * MS  # a period
    assert len(times) == len(commands)


def test_stamps_of_another_clock_carry_the_unstamped_messages_along(tmp_path):
    """Simulated time in the stamps, wall time in the log: every channel is on the stamps' clock."""
    rows = []
    for k in range(50):
        rows.append(('/temperature', START + k * 10 * MS, temperature(20, 5_000_000_000 + k * 10 * MS)))
        rows.append(('/displacement', START + k * 10 * MS, float64(k)))
    rows.append(('/load', START - 40 * MS, float64(1.0)))
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording.start_ns == 5_000_000_000 - 40 * MS
    np.testing.assert_allclose(recording['displacement'].time, 0.04 + np.arange(50) / 100, atol=1e-12)


def test_stamps_of_zero_are_no_stamps(tmp_path):
    rows = [('/temperature', START + k * 10 * MS, temperature(20, 0)) for k in range(50)]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    np.testing.assert_array_equal(recording['temperature'].time, np.arange(50) / 100)
    assert any('stamped 0' in note for note in recording.notes)


def test_single_stamps_of_zero_among_others_are_no_stamps(tmp_path):
    rows = [('/temperature', START + k * 10 * MS, temperature(20 + k, START + k * 10 * MS)) for k in range(50)]
    for k in (0, 20, 49):
        rows[k] = ('/temperature', START + k * 10 * MS, temperature(20 + k, 0))
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording.start_ns == START
    np.testing.assert_array_equal(recording['temperature'].time, np.arange(50) / 100)
    np.testing.assert_array_equal(recording['temperature'].value, 293.15 + np.arange(50))
    assert recording.notes == ('/temperature: 3 of 50 messages are stamped 0, their log time is used',)


def test_a_stamp_of_zero_in_simulated_time_is_put_on_the_clock_of_the_others(tmp_path):
    stamps = [100 * 10**9 + k * 10 * MS if k else 0 for k in range(50)]
    rows = [('/temperature', START + k * 10 * MS, temperature(20, stamp)) for k, stamp in enumerate(stamps)]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording.start_ns == 100 * 10**9
    np.testing.assert_array_equal(recording['temperature'].time, np.arange(50) / 100)


@pytest.mark.parametrize(('period_ms', 'log'), [(10, START), (20_000, 0)])
def test_a_clock_that_begins_at_zero_is_a_clock(tmp_path, period_ms, log):
    rows = [
        ('/temperature', log + k * period_ms * MS // (3 if log else 1), temperature(20, k * period_ms * MS))
        for k in range(50)
    ]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert (recording.start_ns, recording.notes) == (0, ())
    np.testing.assert_allclose(recording['temperature'].time, np.arange(50) * period_ms / 1000)


@pytest.mark.parametrize('early', [5, 70])
def test_a_recording_whose_clock_leaps_is_read_up_to_the_leap_or_from_it(tmp_path, early):
    """A board wakes in 1970 and NTP sets its clock; the load was said before."""
    stamps = [60 * 10**9 + k * 10 * MS for k in range(early)]
    stamps += [START + k * 10 * MS for k in range(early, 100)]
    rows = [('/load', stamps[0] - 5 * MS, float64(0.6))]
    for k, stamp in enumerate(stamps):
        rows.append(('/temperature', stamp, temperature(20.0 + k, stamp)))
        rows.append(('/displacement', stamp + MS, float64(k)))
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    kept = np.arange(early) if early > 50 else np.arange(early, 100)
    np.testing.assert_array_equal(recording['displacement'].value, kept)
    np.testing.assert_array_equal(recording['temperature'].value, 293.15 + kept)
    np.testing.assert_array_equal(recording['temperature'].time[1:] - recording['temperature'].time[0] > 0, True)
    assert recording.duration < 1.0
    assert recording['load'].value.tolist() == [0.6]
    assert recording['load'].time[0] == 0.0
    beyond = 2 * (100 - len(kept)) + (early < 50)
    assert any('the clock jumps by up to 1.968e+04 days' in note for note in recording.notes)
    assert any(f'{beyond} of 201 samples lie beyond' in note for note in recording.notes)


def test_a_damaged_stamp_among_good_ones_costs_its_own_sample(tmp_path):
    rows = [('/temperature', START + k * 10 * MS, temperature(20 + k, START + k * 10 * MS)) for k in range(50)]
    rows[7] = ('/temperature', START + 70 * MS, temperature(27, (2**31 - 1) * 10**9))
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    np.testing.assert_array_equal(recording['temperature'].value, 293.15 + np.delete(np.arange(50), 7))
    assert any('1 of 50 samples lie beyond a jump' in note for note in recording.notes)


def test_a_clock_that_was_set_back_is_noted(tmp_path):
    stamps = [START + (k if k < 50 else k - 20) * 10 * MS for k in range(100)]
    rows = [('/temperature', START + k * 10 * MS, temperature(20 + k, stamp)) for k, stamp in enumerate(stamps)]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert any('backwards 1 time(s), by up to 0.19 s' in note for note in recording.notes)
    assert any('share a stamp' in note for note in recording.notes)
    assert np.all(np.diff(recording['temperature'].time) > 0)


def test_values_that_are_not_finite_are_left_out_with_a_note(tmp_path):
    rows = [('/force', START + k, float64(x)) for k, x in enumerate((1.0, np.nan, 2.0, np.inf, -np.inf))]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording['force'].value.tolist() == [1.0, 2.0]
    assert recording.notes == ('force: 3 of 5 values are not finite and were left out',)


def test_what_no_instrument_measures_is_no_value(tmp_path):
    rows = [('/force', START + k, float64(x)) for k, x in enumerate((1.0, 1e197, 2.0))]
    recording = read_bag(write_foreign(tmp_path / 'bag', rows))
    assert recording['force'].value.tolist() == [1.0, 2.0]
    assert recording.notes == ('force: 1 of 3 values are not finite or above 1e+30 and were left out',)


def test_joint_states_stand_in_for_missing_plain_topics_only(tmp_path):
    stamps = [START + k * 10 * MS for k in range(9)]
    rows = [('/joint_states', t + MS // 5, joint_states(t, [k], [9.0])) for k, t in enumerate(stamps)]
    recording = read_bag(write_foreign(tmp_path / 'a', rows))
    assert recording['displacement'].value.tolist() == list(range(9))
    assert recording['force'].value.tolist() == [9.0] * 9
    rows += [('/force', START + k * 10 * MS + MS, float64(0.5)) for k in range(9)]
    recording = read_bag(write_foreign(tmp_path / 'b', rows))
    assert recording['force'].value.tolist() == [0.5] * 9
    assert recording['displacement'].topic == '/joint_states'
    np.testing.assert_array_equal(recording['force'].time, recording['displacement'].time)


def test_an_effort_of_0_throughout_is_no_force(tmp_path):
    """As many drivers leave it: it would be the load, and set the stated one aside."""
    rows = [('/joint_states', t, joint_states(t, [k], [0.0])) for k, t in enumerate(range(START, START + 9 * MS, MS))]
    bag = write_foreign(tmp_path / 'bag', rows)
    recording = read_bag(bag)
    assert list(recording.channels) == ['displacement']
    assert recording.notes == ('/joint_states: its effort is 0 throughout, as where none is measured: left out',)
    asked = read_bag(bag, channels={'force': 'joint_states.effort[0]'})
    assert asked['force'].value.tolist() == [0.0] * 9 and asked.notes == ()


SEVERAL = (
    "/joint_states: has several joints, left out; say which is the muscle's, for example "
    '--channel displacement=/joint_states.position[0]'
)
CHANGING = '/joint_states: not every message has the same joint at position[0]'


@pytest.mark.parametrize('little_endian', [True, False])
@pytest.mark.parametrize(
    ('names', 'note', 'when_asked'),
    [
        (lambda k: ['tcp_muscle'], None, ()),
        (lambda k: [], None, ()),
        (lambda k: ['shoulder', 'muscle'], SEVERAL, ()),
        (lambda k: ['', ''], SEVERAL, ()),
        (lambda k: ['a', 'b'] if k == 5 else ['a'], SEVERAL, ()),
        (lambda k: ['left', 'right'][:: 1 if k % 2 else -1], f'{CHANGING}: left out', (CHANGING,)),
        (lambda k: ['gripper' if k == 5 else 'muscle'], f'{CHANGING}: left out', (CHANGING,)),
    ],
    ids=['one', 'nameless', 'several', 'several nameless', 'once several', 'swapped', 'one and another'],
)
def test_joint_states_are_taken_by_themselves_only_where_they_are_of_one_joint(
    tmp_path, names, note, when_asked, little_endian
):
    rows = ticks(9, '')
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        add = {
            topic: writer.add_connection(topic, kind, typestore=STORE)
            for topic, kind in [('/temperature', rows[0][2][0]), ('/joint_states', 'sensor_msgs/msg/JointState')]
        }
        for k, (_, log, (kind, message)) in enumerate(row for row in rows if row[0] == '/temperature'):
            writer.write(add['/temperature'], log, STORE.serialize_cdr(message, kind))
            kind, message = joint_states(log, [1e-3 * k] * max(1, len(names(k))), [], names(k))
            writer.write(add['/joint_states'], log, STORE.serialize_cdr(message, kind, little_endian=little_endian))
    recording = read_bag(tmp_path / 'bag')
    assert ('displacement' in recording) == (note is None)
    assert recording.notes == (() if note is None else (note,))
    asked = read_bag(tmp_path / 'bag', channels={'displacement': 'joint_states.position[0]'})
    np.testing.assert_allclose(asked['displacement'].value, 1e-3 * np.arange(9))
    assert asked.notes == when_asked


def test_a_bag_of_several_joints_alone_says_how_to_choose(tmp_path):
    rows = [('/joint_states', START, joint_states(START, [0.0, 1.0], [1.0, 2.0], ['thumb', 'index']))]
    bag = write_foreign(tmp_path / 'bag', rows)
    with pytest.raises(BadInput, match=re.escape(SEVERAL)):
        read_bag(bag)
    assert read_bag(bag, channels={'displacement': 'joint_states.position[1]'})['displacement'].value.tolist() == [1.0]


def test_any_numeric_field_of_any_type_can_be_a_channel_in_any_unit(tmp_path):
    rows = ticks() + [
        ('/laser', START + k * 10 * MS, joint_states(START + k * 10 * MS, [0, 25.4 * k], [])) for k in range(100)
    ]
    bag = write_foreign(tmp_path / 'bag', rows)
    for topic in ('/laser', 'laser'):
        recording = read_bag(bag, channels={'displacement': f'{topic}.position[1]'}, units={'displacement': 'mm'})
        np.testing.assert_allclose(recording['displacement'].value, 0.0254 * np.arange(100), rtol=1e-15)
    recording = read_bag(bag, channels={'force': 'displacement'}, units={'temperature': 'degF', 'force': 'g'})
    assert recording['temperature'].value[12] == pytest.approx(273.15, abs=1e-9)  # 32 of the recorded numbers
    assert recording['force'].value[-1] == pytest.approx(99e-3 * 9.80665e-3)


def test_the_bags_own_definitions_are_used_not_those_of_a_distribution(tmp_path):
    """A type that no distribution has, and a Temperature whose fields differ from the known one."""
    path = tmp_path / 'own.mcap'
    with path.open('wb') as file:
        writer = mcap.writer.Writer(file)
        writer.start('ros2', 'another program')
        definition = b'float32 celsius\nstd_msgs/Header header\n' + b'=' * 80 + b'\nMSG: std_msgs/Header\n'
        definition += b'builtin_interfaces/Time stamp\nstring frame_id\n'
        schema = writer.register_schema('sensor_msgs/msg/Temperature', 'ros2msg', definition)
        channel = writer.register_channel('/t', 'cdr', schema)
        payload = b'\0\1\0\0' + np.float32(21.5).tobytes() + b'\x05\0\0\0\0\0\0\0\1\0\0\0\0'
        writer.add_message(channel, START, payload, START)
        writer.finish()
    recording = read_bag(path, channels={'temperature': '/t'})
    assert recording['temperature'].value.tolist() == [294.65]


def test_a_bag_without_definitions_is_read_with_those_of_jazzy(tmp_path):
    path = tmp_path / 'bare.mcap'
    with path.open('wb') as file:
        writer = mcap.writer.Writer(file)
        writer.start('ros2', 'another program')
        schema = writer.register_schema('std_msgs/msg/Float64', '', b'')
        channel = writer.register_channel('/force', 'cdr', schema)
        writer.add_message(channel, START, b'\0\1\0\0' + np.float64(2.5).tobytes(), START)
        writer.finish()
    assert read_bag(path)['force'].value.tolist() == [2.5]


LAYOUTS = ['chunks', 'no chunks', 'no indexes', 'no summary']


def write_layout(path, layout, compression, rows):
    """A file by mcap's own writer."""
    with path.open('wb') as file:
        writer = mcap.writer.Writer(
            file,
            chunk_size=700,
            compression=compression,
            use_chunking=layout != 'no chunks',
            index_types=mcap.writer.IndexType.NONE if layout != 'chunks' else mcap.writer.IndexType.ALL,
            repeat_channels=layout != 'no summary',
            repeat_schemas=layout != 'no summary',
        )
        writer.start('ros2', '')
        channels = {}
        for topic, log_time, (kind, message) in rows:
            if topic not in channels:
                definition, _ = STORE.generate_msgdef(kind, ros_version=2)
                schema = writer.register_schema(kind, 'ros2msg', definition.encode())
                channels[topic] = writer.register_channel(topic, 'cdr', schema)
            writer.add_message(channels[topic], log_time, bytes(STORE.serialize_cdr(message, kind)), log_time)
        writer.finish()


@pytest.mark.parametrize('compression', list(mcap.writer.CompressionType))
@pytest.mark.parametrize('layout', LAYOUTS)
def test_every_layout_that_mcap_allows(tmp_path, compression, layout):
    path = tmp_path / 'x.mcap'
    write_layout(path, layout, compression, ticks(50))
    recording = read_bag(path)
    assert recording['displacement'].value.tolist() == [k * 1e-3 for k in range(50)]
    assert recording.notes == ()


@pytest.mark.parametrize('layout', LAYOUTS)
def test_a_damaged_file_is_read_as_far_as_it_goes_or_refused(tmp_path, layout):
    path = tmp_path / 'x.mcap'
    write_layout(path, layout, mcap.writer.CompressionType.NONE, ticks(30))
    whole, rng = path.read_bytes(), np.random.default_rng(3)
    outcomes = []
    for _ in range(200):
        data = bytearray(whole)
        if rng.random() < 0.2:
            del data[int(rng.integers(100, len(data))) :]
        for at in rng.integers(len(mcap_file.MAGIC), len(data), rng.integers(1, 9)):
            data[at] = rng.choice([0, 255, rng.integers(256)])
        path.write_bytes(data)
        try:
            outcomes.append(read_bag(path))
        except BadInput as refused:
            assert '\n' not in str(refused)  # noqa: PT017
    assert 80 < len(outcomes) < 200


@pytest.mark.parametrize('layout', LAYOUTS)
def test_a_log_time_beyond_that_of_ros_is_damage(tmp_path, layout):
    rows = ticks(50)
    topic, _, message = rows[60]
    rows[60] = topic, 2**64 - 1, message
    write_layout(tmp_path / 'x.mcap', layout, mcap.writer.CompressionType.NONE, rows)
    recording = read_bag(tmp_path / 'x.mcap')
    assert any('damaged' in note for note in recording.notes)
    assert len(recording['displacement']) > 20
    assert recording.duration < 1.0


@pytest.mark.parametrize('record', [b'\x03', b'\x04'])  # a type, a topic
def test_a_declaration_that_does_not_parse_ends_its_chunk(tmp_path, record):
    write_layout(tmp_path / 'x.mcap', 'chunks', mcap.writer.CompressionType.NONE, ticks(50))
    data = bytearray((tmp_path / 'x.mcap').read_bytes())
    name = {b'\x03': b'std_msgs/msg/Float64', b'\x04': b'/m1/current'}[record]
    at = data.index(name)
    data[at : at + 2] = b'\xff\xff'  # no UTF-8
    (tmp_path / 'x.mcap').write_bytes(data)
    recording = read_bag(tmp_path / 'x.mcap')
    assert any('damaged' in note for note in recording.notes)
    assert len(recording['displacement']) > 40  # of the other chunks


@pytest.mark.parametrize('compression', list(mcap.writer.CompressionType))
def test_a_file_cut_anywhere_is_read_up_to_its_last_whole_message(tmp_path, compression):
    rows = ticks(300)
    whole = tmp_path / 'whole.mcap'
    with whole.open('wb') as file:
        writer = mcap.writer.Writer(file, chunk_size=4000, compression=compression)
        writer.start('ros2', '')
        channels = {}
        for topic, log_time, (kind, message) in rows:
            if topic not in channels:
                definition, _ = STORE.generate_msgdef(kind, ros_version=2)
                channels[topic] = writer.register_channel(
                    topic, 'cdr', writer.register_schema(kind, 'ros2msg', definition.encode())
                )
            writer.add_message(channels[topic], log_time, bytes(STORE.serialize_cdr(message, kind)), log_time)
        writer.finish()
    data = whole.read_bytes()
    cut = tmp_path / 'cut.mcap'
    counts = []
    for size in np.linspace(len(data) * 0.2, len(data) - 1, 40).astype(int):
        cut.write_bytes(data[:size])
        recording = read_bag(cut)
        assert any('not closed' in note for note in recording.notes)
        n = len(recording['temperature'])
        np.testing.assert_array_equal(recording['temperature'].value, 293.15 + np.arange(n))
        np.testing.assert_array_equal(recording['displacement'].time, np.arange(len(recording['displacement'])) / 100)
        counts.append(n)
    assert counts == sorted(counts)
    assert counts[-1] == 300
    if compression == mcap.writer.CompressionType.NONE:  # a chunk that was cut gives the messages it has
        assert len(set(counts)) > 25


def test_a_damaged_chunk_is_noted(tmp_path):
    bag = write_foreign(tmp_path / 'bag', ticks())
    with BagWriter(tmp_path / 'ours') as writer:  # rosbags writes no checksums
        writer.add_topic('/force', 'std_msgs/msg/Float64')
        for k in range(100):
            writer.write('/force', float64(k)[1], START + k)
    file = next((tmp_path / 'ours').glob('*.mcap'))
    data = bytearray(file.read_bytes())
    at = data.index(np.float64(50.0).tobytes())
    data[at : at + 8] = np.float64(1e30).tobytes()
    file.write_bytes(data)
    assert any('is damaged' in note for note in read_bag(tmp_path / 'ours').notes)
    assert read_bag(bag).notes == ()


def damaged_sqlite(path, rows, changes):
    """A bag whose table of messages lost its constraints, and then some values: (row, column, SQL)."""
    bag = write_foreign(path, rows, StoragePlugin.SQLITE3)
    with closing(sqlite3.connect(next(bag.glob('*.db3')))) as database:
        database.execute('CREATE TABLE loose AS SELECT * FROM messages')
        database.execute('DROP TABLE messages')
        database.execute('ALTER TABLE loose RENAME TO messages')
        for row, column, value in changes:
            database.execute(f'UPDATE messages SET {column} = {value} WHERE rowid = {row}')
        database.commit()
    return bag


def test_damaged_rows_of_a_sqlite_bag_are_left_out_whole(tmp_path):
    changes = [(3, 'data', 'NULL'), (5, 'data', "'a text'"), (6, 'data', "CAST(X'FF00' AS TEXT)")]
    changes += [(8, 'timestamp', "X'00'"), (9, 'timestamp', 'NULL')]
    rows = [('/force', START + k * MS, float64(k)) for k in range(50)]
    recording = read_bag(damaged_sqlite(tmp_path / 'bag', rows, changes))
    expected = np.delete(np.arange(50), [2, 4, 5, 7, 8])
    np.testing.assert_array_equal(recording['force'].value, expected)
    np.testing.assert_allclose(recording['force'].time, expected / 1000, atol=1e-12)
    assert any('/force: 5 row(s) without time or message were left out' in note for note in recording.notes)


def test_a_sqlite_bag_without_a_whole_row_is_empty(tmp_path):
    bag = damaged_sqlite(tmp_path / 'bag', [('/force', START, float64(1))], [(1, 'data', 'NULL')])
    with pytest.raises(BadInput, match='empty bag: no readable message on /force'):
        read_bag(bag)


def test_a_bag_without_its_metadata_file_is_read_with_a_note(tmp_path):
    bag = write_foreign(tmp_path / 'bag', ticks())
    for content in ('', '\0' * 100):
        (bag / 'metadata.yaml').write_text(content)
        assert any('metadata.yaml is missing or empty' in note for note in read_bag(bag).notes)
    (bag / 'metadata.yaml').unlink()
    assert len(read_bag(bag)['current']) == 100


def test_a_bag_in_several_files_is_one_recording(tmp_path):
    rows = ticks()
    whole = tmp_path / 'whole'
    whole.mkdir()
    for k, part in enumerate((rows[150:], rows[:150])):
        shutil.copy(next(write_foreign(tmp_path / f'p{k}', part).glob('*.mcap')), whole / f'bag_{k}.mcap')
    assert read_bag(whole)['temperature'].value.tolist() == (293.15 + np.arange(100)).tolist()


@pytest.mark.parametrize('emptied', [False, True], ids=['not copied', 'empty'])
def test_files_of_a_bag_that_are_missing_are_noted(tmp_path, emptied):
    rows, bag = ticks(), tmp_path / 'bag'
    bag.mkdir()
    for k, part in enumerate((rows[:100], rows[100:200], rows[200:])):
        shutil.copy(next(write_foreign(tmp_path / f'p{k}', part).glob('*.mcap')), bag / f'bag_{k}.mcap')
    listed = [f'bag_{k}.mcap' for k in range(3)]
    (bag / 'metadata.yaml').write_text(json.dumps({'rosbag2_bagfile_information': {'relative_file_paths': listed}}))
    assert read_bag(bag).notes == ()
    (bag / 'bag_1.mcap').rename(bag / 'bag_1_of_monday.mcap')
    assert read_bag(bag).notes == ()
    (bag / 'bag_1_of_monday.mcap').unlink()
    if emptied:
        (bag / 'bag_1.mcap').touch()
    lacking = f'{bag}: 1 of its 3 files are missing or empty: bag_1.mcap'
    assert read_bag(bag).notes == (lacking,)
    (bag / 'metadata.yaml').write_text('relative_file_paths: 7')
    assert read_bag(bag).notes == ()


def test_several_muscles_are_told_apart_by_namespace(tmp_path):
    bag = write_foreign(tmp_path / 'bag', ticks(ns='/left') + ticks(ns='/right/arm') + ticks(9, ns=''))
    with pytest.raises(BadInput, match=r'several namespaces: /, /left, /right/arm; .*--namespace'):
        read_bag(bag)
    assert len(read_bag(bag, namespace='/left')['current']) == 100
    assert len(read_bag(bag, namespace='right/arm/')['current']) == 100
    assert len(read_bag(bag, namespace='/')['current']) == 9
    with pytest.raises(BadInput, match=r"--namespace rigth: .*; did you mean '/right/arm'|known: "):
        read_bag(bag, namespace='rigth')


@pytest.mark.parametrize(
    ('options', 'says'),
    [
        (
            {'channels': {'displacment': '/laser'}},
            "--channel: unknown channel 'displacment'; did you mean 'displacement'",
        ),
        ({'channels': {'force': '/lasr'}}, "--channel force: .* has no topic '/lasr'; did you mean '/laser'"),
        ({'channels': {'force': '/laser'}}, 'JointState has no single number; say which field'),
        ({'channels': {'force': '/laser.effort'}}, 'is a sequence, say which element'),
        (
            {'channels': {'displacement': '/laser.position[2]'}},
            r"^--channel displacement: /laser has no position\[2\]: 'position' has 1 element\(s\), counted from 0$",
        ),
        ({'channels': {'force': '/laser.effort[0]'}}, r"'effort' has 0 element\(s\)"),
        ({'units': {'force': 'N'}}, '--unit force: .* no channel of this name'),
        ({'units': {'temperature': 'mm'}}, "--unit temperature: 'mm' is a unit of length, expected one of temperature"),
    ],
)
def test_a_wrong_option_is_answered_with_the_nearest_right_one(tmp_path, options, says):
    rows = [*ticks(), ('/laser', START, joint_states(START, [0.0], []))]
    with pytest.raises(BadInput, match=says):
        read_bag(write_foreign(tmp_path / 'bag', rows), **options)


def test_bags_that_cannot_be_read_say_why_in_one_line(tmp_path):
    write_foreign(tmp_path / 'other', [('/scan', START, float64(1)), ('/odom', START, float64(1))])
    write_foreign(tmp_path / 'no_messages', [])
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'folder_of_bags').mkdir()
    write_foreign(tmp_path / 'folder_of_bags' / 'a', [])
    (tmp_path / 'text.mcap').write_text('this is no bag')
    (tmp_path / 'log.csv').write_text('time,temperature')
    (tmp_path / 'text.db3').write_text('this is no bag, and long enough to be taken for a header of sqlite')
    (tmp_path / 'zero.mcap').touch()
    (tmp_path / 'zero').mkdir()
    (tmp_path / 'zero' / 'zero_0.mcap').touch()
    for name, says in {
        'other': r'no known topic; it has /odom, /scan; say which is which with --channel NAME=TOPIC\[.FIELD\]',
        'no_messages': 'empty bag',
        'folder': 'no bag: the directory has no .mcap or .db3 file$',
        'folder_of_bags': 'no .mcap or .db3 file; bags in it: .*folder_of_bags/a$',
        'text.mcap': 'not an MCAP file',
        'log.csv': "expected a rosbag2; 'tcp_muscle import' makes bags of CSV files",
        'text.db3': 'not a readable rosbag2 sqlite3 file',
        'zero.mcap': 'empty file',
        'zero': 'empty bag',
        'othr': "no such bag; did you mean 'other'",
        'other/metadata.yaml': 'give its directory',
    }.items():
        with pytest.raises(BadInput, match=says) as caught:
            read_bag(tmp_path / name)
        assert '\n' not in str(caught.value)


def test_what_was_known_travels_with_the_bag_and_with_the_bare_file(tmp_path):
    known = {'load_n': 0.5, 'trial': '1-1', 'outlier': True, 'group': 'ä'}
    channel = Channel('force', np.arange(3.0), np.ones(3), '/force')
    write_recording(tmp_path / 'bag', Recording('', {'force': channel}, START, known))
    assert read_bag(tmp_path / 'bag').known == known
    assert read_bag(next((tmp_path / 'bag').glob('*.mcap'))).known == known
    assert json.dumps(known)  # what custom_data can hold
