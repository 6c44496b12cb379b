"""Bags for tests, written by rosbags' or mcap's own writers where another program's bag is meant."""

from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
START = 1_700_000_000_000_000_000


def float64(x):
    return 'std_msgs/msg/Float64', STORE.types['std_msgs/msg/Float64'](float(x))


def header(stamp_ns, frame=''):
    time = STORE.types['builtin_interfaces/msg/Time'](stamp_ns // 10**9, stamp_ns % 10**9)
    return STORE.types['std_msgs/msg/Header'](time, frame)


def temperature(x, stamp_ns):
    kind = 'sensor_msgs/msg/Temperature'
    return kind, STORE.types[kind](header(stamp_ns), float(x), 0.0)


def joint_states(stamp_ns, position, effort, names=('muscle',)):
    kind = 'sensor_msgs/msg/JointState'
    arrays = (np.array(values, dtype=float) for values in (position, [0.0] * len(position), effort))
    return kind, STORE.types[kind](header(stamp_ns), list(names), *arrays)


def write_foreign(path: Path, rows, storage=StoragePlugin.MCAP) -> Path:
    """A bag by rosbags' writer; rows of (topic, log time ns, (type, message)), in any order."""
    with Writer(path, version=9, storage_plugin=storage) as writer:
        connections = {}
        for topic, log_time, (kind, message) in rows:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], log_time, STORE.serialize_cdr(message, kind))
    return path
