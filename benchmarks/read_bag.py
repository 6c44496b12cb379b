"""How much faster read_bag is than rosbags' reader with its deserialiser, on the same bag.

    python benchmarks/read_bag.py [SECONDS]      # default 3600 s of six topics at 100 Hz: 2.2 million messages

Both read every message of the bag once; the figure printed is the ratio of the two times.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.bag_writer import write_recording
from tcp_muscle_ros.recording.recording import Channel, Recording

NAMES = ('current', 'voltage', 'temperature', 'resistance', 'displacement', 'force')


def main() -> None:
    """Write a bag, read it both ways, print the times."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 3600.0
    ticks = np.arange(int(seconds * 100)) / 100.0
    values = 300.0 + np.random.default_rng(1).normal(size=len(ticks))
    recording = Recording('', {name: Channel(name, ticks, values, name) for name in NAMES}, 1_700_000_000 * 10**9)
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'bag'
        write_time = _timed(lambda: write_recording(bag, recording))
        ours = _timed(lambda: read_bag(bag))
        theirs = _timed(lambda: _read_with_rosbags(bag))
        messages = len(ticks) * len(NAMES)
        print(f'{messages} messages, {sum(f.stat().st_size for f in bag.iterdir()) / 1e6:.0f} MB')
        print(f'write_recording {write_time:7.2f} s')
        print(f'read_bag        {ours:7.2f} s')
        print(f'rosbags         {theirs:7.2f} s')
        print(f'ratio           {theirs / ours:7.1f}')


def _read_with_rosbags(bag: Path) -> None:
    with AnyReader([bag], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


if __name__ == '__main__':
    main()
