"""Reading and writing a bag, beside rosbags and mcap-ros2-support.

    python benchmarks/bags.py [--seconds 3600]      # six topics at 100 Hz: 2.2 million messages

Reading: every message becomes numbers in arrays. The least work reads the file. Writing: the arrays become a bag; the
least work writes as many bytes. The bag of `write_recording` is read; what each reader found is compared.
"""

import argparse
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from side_by_side import Contender, in_turns, show

from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.recording import CHANNELS, Channel, Recording
from tcp_muscle_ros.recording.units import UNITS

try:
    from mcap_ros2.decoder import DecoderFactory
except ImportError:
    DecoderFactory = None

NAMES = ('current', 'voltage', 'temperature', 'resistance', 'displacement', 'force')
START = 1_700_000_000 * 10**9  # ns
Columns = dict[str, list[float]]


def made(seconds: float) -> Recording:
    """A recording of so many seconds."""
    ticks = np.arange(int(seconds * 100)) / 100.0
    rng = np.random.default_rng(1)
    channels = {name: Channel(name, ticks, rng.uniform(1.0, 400.0, ticks.size), name) for name in NAMES}
    return Recording('', channels, START)


def with_rosbags(bag: Path) -> Columns:
    """Each message an object of rosbags."""
    columns: Columns = defaultdict(list)
    with AnyReader([bag], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            value = message.temperature if connection.topic == '/temperature' else message.data
            columns[connection.topic].append(value)
    return columns


def with_mcap_ros2(file: Path) -> Columns:
    """Each message an object of mcap-ros2-support."""
    columns: Columns = defaultdict(list)
    with file.open('rb') as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            value = message.temperature if channel.topic == '/temperature' else message.data
            columns[channel.topic].append(value)
    return columns


def ours(bag: Path) -> Columns:
    """The package; numbers as they are on the topics."""
    channels = read_bag(bag).channels
    return {f'/{name}': UNITS[CHANNELS[name].unit].from_si(channel.value) for name, channel in channels.items()}


def write_with_rosbags(bag: Path, recording: Recording) -> Path:
    """One message after the other, in the order of time, as a user of rosbags would; returns ``bag``."""
    store = get_typestore(Stores.ROS2_JAZZY)
    float64, temperature = store.types['std_msgs/msg/Float64'], store.types['sensor_msgs/msg/Temperature']
    header, stamp = store.types['std_msgs/msg/Header'], store.types['builtin_interfaces/msg/Time']
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = []
        for name in NAMES:
            kind = CHANNELS[name]
            values = UNITS[kind.unit].from_si(recording[name].value).tolist()
            topics.append((writer.add_connection(f'/{name}', kind.message_type, typestore=store), kind, values))
        for k, t in enumerate(np.round(recording['force'].time * 1e9).astype(np.int64).tolist()):
            now = START + t
            for connection, kind, values in topics:
                if kind.stamped:
                    message = temperature(header(stamp(now // 10**9, now % 10**9), ''), values[k], 0.0)
                else:
                    message = float64(values[k])
                writer.write(connection, now, store.serialize_cdr(message, kind.message_type))
    return bag


def main() -> None:
    """Write the bag both ways, read it all ways, print both tables."""
    parser = argparse.ArgumentParser(description='Reading and writing a bag, beside the alternatives.')
    parser.add_argument('--seconds', type=float, default=3600.0)
    seconds = parser.parse_args().seconds
    recording = made(seconds)
    with tempfile.TemporaryDirectory(prefix='bags_') as name:
        folder = Path(name)
        count = iter(range(100))

        def fresh() -> Path:
            return folder / f'bag_{next(count)}'

        bag, tenth = fresh(), fresh()
        write_recording(bag, recording)
        write_recording(tenth, made(seconds / 10))
        file, short_file = (next(each.glob('*.mcap')) for each in (bag, tenth))
        content = file.read_bytes()
        writing = in_turns(
            [
                Contender('least: as many bytes written', lambda: fresh().write_bytes(content), repeats=3),
                Contender('ours: `write_recording`', lambda: write_recording(fresh(), recording), repeats=3),
                Contender("rosbags' writer", lambda: write_with_rosbags(fresh(), recording), repeats=1),
            ],
            time.perf_counter,
        )
        reading = in_turns(
            [
                Contender('least: the file read', file.read_bytes, repeats=3),
                Contender('ours: `read_bag`', lambda: ours(bag), repeats=3),
                Contender("rosbags' reader", lambda: with_rosbags(bag), repeats=1),
                Contender(
                    'mcap-ros2-support', (lambda: with_mcap_ros2(short_file)) if DecoderFactory else None, 0.1, 1,
                    'not installed (requirements/bench.txt)',
                ),
            ],
            time.perf_counter,
        )  # fmt: skip
        found, of_tenth = reading[1].result, ours(tenth)
        for other in reading[2:]:
            for topic, values in (found if other.contender.share == 1.0 else of_tenth).items():
                np.testing.assert_allclose(other.result[topic], values, rtol=1e-14)
        for topic, values in ours(writing[-1].result).items():
            np.testing.assert_array_equal(found[topic], values)
    messages = len(NAMES) * len(recording['force'])
    for verb, rows in (('Writing', writing), ('Reading', reading)):
        show(
            f'{verb} {messages / 1e6:.1f} million messages, {len(content) / 1e6:.0f} MB',
            ('', 's', 'us a message', 'time over ours'),
            [
                (row.name, f'{row.seconds:.2f}', f'{1e6 * row.seconds / messages:.2f}',
                 f'{row.seconds / rows[1].seconds:.1f}')
                for row in rows
            ],
        )  # fmt: skip


if __name__ == '__main__':
    main()
