import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from recording.bags import START, STORE, float64, temperature
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import BagWriter, write_recording
from tcp_muscle_ros.recording.mcap_writer import McapWriter
from tcp_muscle_ros.recording.recording import CHANNELS, Channel, Recording


def everything(n=500):
    """A recording of every channel there is, on a clock of its own."""
    rng = np.random.default_rng(2)
    time = np.arange(n) / 100
    return Recording(
        '',
        {name: Channel(name, time, 300 + rng.normal(size=n), f'/m1/{kind.topic}') for name, kind in CHANNELS.items()},
        START,
        {'load_n': 0.588},
    )


def test_a_recording_survives_being_written_and_read(tmp_path):
    recording = everything()
    write_recording(tmp_path / 'bag', recording, namespace='m1')
    back = read_bag(tmp_path / 'bag')
    assert back.notes == ()
    assert back.start_ns == START
    assert back.known == recording.known
    assert set(back.channels) == set(CHANNELS)
    for name, channel in recording.channels.items():
        np.testing.assert_array_equal(back[name].time, channel.time)
        np.testing.assert_allclose(back[name].value, channel.value, rtol=1e-15, atol=0)
        assert back[name].topic == channel.topic


def test_rosbags_reads_it_with_an_empty_typestore(tmp_path):
    recording = everything()
    write_recording(tmp_path / 'bag', recording, namespace='m1')
    with AnyReader([tmp_path / 'bag'], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        assert reader.message_count == 500 * len(CHANNELS)
        assert reader.start_time == START
        assert {c.topic: c.msgtype for c in reader.connections} == {
            f'/m1/{kind.topic}': kind.message_type for kind in CHANNELS.values()
        }
        reliable = {c.ext.offered_qos_profiles[0].reliability.name for c in reader.connections}
        assert reliable == {'RELIABLE'}
        seen = dict.fromkeys(CHANNELS, 0)
        for connection, log_time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            name = next(n for n, kind in CHANNELS.items() if kind.topic == connection.topic.split('/')[-1])
            value = recording[name].value[seen[name]]
            if CHANNELS[name].stamped:
                assert message.temperature == pytest.approx(value - 273.15, rel=1e-12)
                assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == log_time
                assert (message.header.frame_id, message.variance) == ('', 0.0)
            else:
                assert message.data == value
            seen[name] += 1


def test_the_mcap_library_finds_a_summary_and_sound_checksums(tmp_path):
    write_recording(tmp_path / 'bag', everything())
    with next((tmp_path / 'bag').glob('*.mcap')).open('rb') as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary.statistics.message_count == 500 * len(CHANNELS)
        assert sum(1 for _ in reader.iter_messages()) == 500 * len(CHANNELS)
        assert {schema.encoding for schema in summary.schemas.values()} == {'ros2msg'}


def test_metadata_is_version_9_from_the_first_moment_and_complete_at_the_end(tmp_path):
    def metadata():
        return yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())['rosbag2_bagfile_information']

    with BagWriter(tmp_path / 'bag') as writer:
        assert (metadata()['version'], metadata()['storage_identifier']) == (9, 'mcap')
        writer.add_topic('/force', 'std_msgs/msg/Float64')
        for k in (3, 1, 2):
            writer.write('/force', float64(k)[1], START + k)
    done = metadata()
    assert done['message_count'] == 3
    assert done['starting_time']['nanoseconds_since_epoch'] == START + 1
    assert done['duration']['nanoseconds'] == 2
    topic = done['topics_with_message_count'][0]['topic_metadata']
    assert topic['type_description_hash'] == STORE.hash_rihs01('std_msgs/msg/Float64')
    assert topic['offered_qos_profiles'][0]['reliability'] == 'reliable'
    assert (tmp_path / 'bag' / done['relative_file_paths'][0]).is_file()
    assert '&' not in (tmp_path / 'bag' / 'metadata.yaml').read_text()  # no anchors


def test_messages_given_as_objects_and_as_bytes_are_the_same(tmp_path):
    kind, message = temperature(21.0, START)
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/temperature', kind)
        writer.write('/temperature', message, START)
        _, message = temperature(22.0, START + 10**9)
        writer.write_serialized('/temperature', bytes(STORE.serialize_cdr(message, kind)), START + 10**9)
    assert read_bag(tmp_path / 'bag')['temperature'].value.tolist() == [294.15, 295.15]


def test_whole_topics_at_once_make_the_same_bag_as_message_by_message(tmp_path):
    rng = np.random.default_rng(5)
    topics = {}
    for name, n, size in (('/a', 30_000, 12), ('/b', 9_000, 36), ('/c', 0, 12), ('/d', 1, 12)):
        log_time = START + np.sort(rng.integers(0, 10**9, n))
        payload = rng.integers(0, 256, (n, size), dtype=np.uint8)
        payload[:, :4] = (0, 1, 0, 0)
        topics[name] = log_time, payload
    types = {12: 'std_msgs/msg/Float64', 36: 'sensor_msgs/msg/Temperature'}
    for name in ('at_once', 'one_by_one'):
        with BagWriter(tmp_path / name) as writer:
            for topic, (_, payload) in topics.items():
                writer.add_topic(topic, types[payload.shape[1]])
            writer.write_serialized('/d', bytes(12), START + 5)  # before, and in the same chunk
            if name == 'at_once':
                writer.write_many(topics)
            else:
                rows = [(t, topic, row) for topic, group in topics.items() for t, row in zip(*group, strict=True)]
                for log_time, topic, row in sorted(rows, key=lambda row: row[0]):
                    writer.write_serialized(topic, row.tobytes(), int(log_time))
    found = {}
    for name in ('at_once', 'one_by_one'):
        with AnyReader([tmp_path / name], default_typestore=get_typestore(Stores.EMPTY)) as reader:
            found[name] = [(c.topic, log_time, bytes(raw)) for c, log_time, raw in reader.messages()]
        with (tmp_path / name / f'{name}_0.mcap').open('rb') as file:
            reader = make_reader(file, validate_crcs=True)
            found[name].append([(message.sequence, message.channel_id) for _, _, message in reader.iter_messages()])
            statistics = reader.get_summary().statistics
            assert statistics.chunk_count > 1
            found[name].append((statistics.message_count, statistics.message_start_time, statistics.message_end_time))
            found[name].append(statistics.channel_message_counts)
    assert found['at_once'] == found['one_by_one']
    assert found['at_once'][-2][0] == 39_002


@pytest.mark.parametrize('lasts', [2.0**31 - START / 1e9, 1e10, 1e30])
def test_times_that_no_stamp_can_say_are_refused(tmp_path, lasts):
    channel = Channel('temperature', np.array([0.0, lasts]), np.array([293.0, 294.0]), '/temperature')
    with pytest.raises(BadInput, match=r'temperature lasts until .* stamps of ROS messages end in January 2038'):
        write_recording(tmp_path / 'bag', Recording('run.csv', {'temperature': channel}, START))
    assert not (tmp_path / 'bag').exists()


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / 'there').mkdir()
    with pytest.raises(BadInput, match='exists already and is not overwritten'):
        BagWriter(tmp_path / 'there')
    assert list((tmp_path / 'there').iterdir()) == []


def test_an_unwritable_place_is_bad_input(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(BadInput, match='cannot write there'):
        BagWriter(tmp_path / 'file' / 'bag')


def interrupt_chunk(monkeypatch, number):
    """Ctrl-C while a chunk is written: its head and half of its content are in the file."""
    whole, seen = McapWriter._write_chunk, []

    def write_chunk(self, content, indexes):
        seen.append(content)
        if len(seen) == number:
            stream = self._stream

            def write(part):
                stream.write(part[: len(part) // 2 if len(part) > 1000 else None])
                if len(part) > 1000:
                    signal.raise_signal(signal.SIGINT)

            self._stream = type('Stream', (), {'write': staticmethod(write), 'tell': stream.tell})()
            try:
                whole(self, content, indexes)
            finally:
                self._stream = stream
        else:
            whole(self, content, indexes)

    monkeypatch.setattr(McapWriter, '_write_chunk', write_chunk)


@pytest.mark.parametrize('chunk', [1, 2])
def test_an_interrupted_write_of_a_recording_leaves_nothing(tmp_path, monkeypatch, chunk):
    (tmp_path / 'mine').mkdir()
    interrupt_chunk(monkeypatch, chunk)
    with pytest.raises(KeyboardInterrupt):
        write_recording(tmp_path / 'mine' / 'new' / 'bag', everything(3000))
    assert [path.name for path in tmp_path.iterdir()] == ['mine']  # not of its making
    assert list((tmp_path / 'mine').iterdir()) == []


@pytest.mark.parametrize('size', [100, 400_000])  # of the first metadata.yaml a part; of the data a part
def test_a_full_disk_is_told_in_one_line_and_leaves_nothing(tmp_path, size):
    resource = pytest.importorskip('resource')
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        with pytest.raises(BadInput, match=r'bag: cannot .* \(File too large\)'):
            write_recording(tmp_path / 'bag', everything(3000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('context', [True, False])
def test_whole_topics_that_are_interrupted_do_not_pass_for_a_complete_bag(tmp_path, monkeypatch, context):
    def write():
        if context:
            with writer:
                writer.write_many({'/force': (log_time, payload)})
        else:
            writer.write_many({'/force': (log_time, payload)})

    interrupt_chunk(monkeypatch, 2)
    log_time = START + 1000 * np.arange(60_000)
    payload = np.tile(np.frombuffer(b'\0\1\0\0' + np.float64(0.5).tobytes(), np.uint8), (60_000, 1))
    writer = BagWriter(tmp_path / 'bag')
    writer.add_topic('/force', 'std_msgs/msg/Float64')
    with pytest.raises(KeyboardInterrupt):
        write()
    writer.close()
    assert writer.counts == {'/force': 0}
    metadata = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())['rosbag2_bagfile_information']
    assert metadata['message_count'] == 0
    back = read_bag(tmp_path / 'bag')
    assert any('was not closed' in note for note in back.notes)
    assert 20_000 < len(back['force']) < 60_000
    assert set(back['force'].value) == {0.5}


def test_a_bag_that_an_exception_ends_keeps_its_messages_and_says_that_it_is_unfinished(tmp_path):
    def half_a_run():
        with BagWriter(tmp_path / 'bag') as writer:
            writer.add_topic('/force', 'std_msgs/msg/Float64')
            for k in range(100):
                writer.write('/force', float64(k)[1], START + k)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        half_a_run()
    back = read_bag(tmp_path / 'bag')
    assert back['force'].value.tolist() == list(range(100))
    assert any('was not closed' in note for note in back.notes)


def test_an_unknown_type_and_a_topic_of_two_types_are_refused(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        with pytest.raises(BadInput, match="unknown message type 'std_msgs/msg/Float46'; did you mean"):
            writer.add_topic('/x', 'std_msgs/msg/Float46')
        writer.add_topic('/x', 'std_msgs/msg/Float64')
        with pytest.raises(BadInput, match='cannot also be std_msgs/msg/Float32'):
            writer.add_topic('/x', 'std_msgs/msg/Float32')


# What is written is told to a second file, which no buffer holds back.
WRITE_FOR_EVER = """
import os, sys, time
import numpy as np
from tcp_muscle_ros.recording.bag_writer import BagWriter
writer = BagWriter(sys.argv[1])
writer.add_topic('/force', 'std_msgs/msg/Float64')
told = os.open(sys.argv[2], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
while True:
    now = time.time_ns()
    writer.write_serialized('/force', b'\\0\\1\\0\\0' + np.float64(now * 1e-9).tobytes(), now)
    os.write(told, now.to_bytes(8, 'little'))
    time.sleep(0.002)
"""


def test_a_writer_killed_with_minus_nine_loses_at_most_its_last_second(tmp_path):
    def told():
        path = tmp_path / 'told'
        return np.frombuffer(path.read_bytes() if path.exists() else b'', '<i8')

    process = subprocess.Popen([sys.executable, '-c', WRITE_FOR_EVER, str(tmp_path / 'bag'), str(tmp_path / 'told')])
    try:
        deadline = time.monotonic() + 60
        while (seconds := np.ptp(told()) * 1e-9 if told().size else 0.0) < 1.9:
            assert time.monotonic() < deadline, f'within a minute it wrote {seconds:.1f} s'
            time.sleep(0.02)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    recording, written = read_bag(tmp_path / 'bag'), told()
    assert any('not closed' in note for note in recording.notes)
    kept = len(recording['force'])  # the very last may have been written and not told
    times = recording.start_ns + np.round(recording['force'].time * 1e9).astype(np.int64)
    np.testing.assert_array_equal(times[: written.size], written[:kept])
    np.testing.assert_allclose(recording['force'].value, times * 1e-9, rtol=0, atol=1e-5)
    lost = written[kept:]
    assert lost.size == 0 or (lost[-1] - lost[0]) * 1e-9 < 1.0
