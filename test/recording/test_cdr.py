"""The bulk reader of serialised messages against rosbags' deserialiser, message by message."""

from zlib import crc32

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.recording.cdr import Payloads, decode, field_path

STORE = get_typestore(Stores.ROS2_JAZZY)
CUSTOM = get_types_from_msg(
    """
string label
bool[3] flags
uint8 small
geometry_msgs/Point[] points
string[] names
float32[2] pair
int16 last
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
""",
    'lab_msgs/msg/Odd',
)
STORE.register(CUSTOM)
T = STORE.types


def payloads(messages, kind, *, little_endian=True):
    raw = [bytes(STORE.serialize_cdr(m, kind, little_endian=little_endian)) for m in messages]
    length = np.array([len(r) for r in raw], dtype=np.int64)
    return Payloads(np.frombuffer(b''.join(raw), np.uint8), np.cumsum(length) - length, length)


def header(sec, frame):
    return T['std_msgs/msg/Header'](T['builtin_interfaces/msg/Time'](sec, 5), frame)


numbers = st.floats(allow_nan=False, width=64)
texts = st.text('abc', max_size=9)


@given(st.lists(st.tuples(texts, st.lists(texts, max_size=3), st.lists(numbers, max_size=3)), min_size=1, max_size=40))
@settings(max_examples=60, deadline=None)
@pytest.mark.parametrize('little_endian', [True, False])
def test_joint_states_of_any_mixture_of_layouts(little_endian, rows):
    kind = 'sensor_msgs/msg/JointState'
    messages = [
        T[kind](header(7, frame), names, np.array(p), np.array([]), np.array(p[:1])) for frame, names, p in rows
    ]
    paths = [('position', 1), ('effort', 0), ('header', 'stamp', 'sec'), ('name', 0)]
    found = decode(STORE.fielddefs, kind, payloads(messages, kind, little_endian=little_endian), paths)
    assert found.broken == 0
    for k, (_, names, p) in enumerate(rows):
        assert found.present[3][k] == bool(names)
        if names:
            assert found.values[3][k] == crc32(names[0].encode())
        assert found.present[0][k] == (len(p) > 1)
        assert found.present[1][k] == (len(p) > 0)
        assert found.values[2][k] == 7
        if len(p) > 1:
            assert found.values[0][k] == p[1]
        if p:
            assert found.values[1][k] == p[0]


@given(
    st.lists(
        st.tuples(texts, st.lists(numbers, max_size=3), st.lists(texts, max_size=3), st.integers(-(2**15), 2**15 - 1)),
        min_size=1,
        max_size=20,
    )
)
@settings(max_examples=60, deadline=None)
def test_a_type_of_ones_own_with_nested_sequences(rows):
    kind, point = 'lab_msgs/msg/Odd', T['geometry_msgs/msg/Point']
    messages = [
        T[kind](
            label,
            np.array([True, False, True]),
            9,
            [point(x, -x, 0.5) for x in xs],
            names,
            np.array([1.5, -2.5], np.float32),
            last,
        )
        for label, xs, names, last in rows
    ]
    paths = [field_path(CUSTOM, kind, text, '') for text in ('points[1].y', 'pair[1]', 'last', 'flags[2]', 'small')]
    found = decode(STORE.fielddefs, kind, payloads(messages, kind), paths)
    for k, (_, xs, _, last) in enumerate(rows):
        assert found.present[0][k] == (len(xs) > 1)
        if len(xs) > 1:
            assert found.values[0][k] == -xs[1]
        assert [found.values[f][k] for f in range(1, 5)] == [-2.5, last, 1, 9]


def test_broken_messages_are_counted_and_the_others_read():
    kind = 'sensor_msgs/msg/Temperature'
    whole = payloads([T[kind](header(k, 'x'), 20.0 + k, 0.0) for k in range(5)], kind)
    length = whole.length.copy()
    length[2] = 11  # ends inside its header
    buffer = whole.buffer.copy()
    buffer[whole.start[4]] = 9  # no such encapsulation
    found = decode(STORE.fielddefs, kind, Payloads(buffer, whole.start, length), [('temperature',)])
    assert found.broken == 2
    assert found.present[0].tolist() == [True, True, False, True, False]
    assert found.values[0][[0, 1, 3]].tolist() == [20.0, 21.0, 23.0]


@pytest.mark.parametrize(
    ('kind', 'text', 'says'),
    [
        ('sensor_msgs/msg/JointState', 'positon[0]', "has no field 'positon'; did you mean 'position'"),
        ('sensor_msgs/msg/JointState', 'position', "is a sequence, say which element, for example 'position\\[0\\]'"),
        ('sensor_msgs/msg/JointState', 'header', 'is no number, its fields are: stamp, frame_id'),
        ('sensor_msgs/msg/JointState', 'header.frame_id', 'is a string, expected a number'),
        ('sensor_msgs/msg/JointState', 'position[0].x', 'has no fields'),
        ('std_msgs/msg/Float64', 'data[0]', 'indexes nothing'),
    ],
)
def test_a_wrong_field_is_answered_with_what_there_is(kind, text, says):
    with pytest.raises(BadInput, match=f'^--channel force: .*{says}'):
        field_path(STORE.fielddefs, kind, text, '--channel force')
