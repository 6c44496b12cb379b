"""The recorder as users run it: its own process, real publishers, real DDS; stopped in every way there is."""

import os
import re
import signal
import subprocess
import sys
import time

import domains
import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from tcp_muscle_ros.recording.bag import read_bag

pytestmark = pytest.mark.processes

# A muscle's worth of topics whose values count up: publisher.py RATE COUNT NAMESPACE [reliable|best_effort] [clock]
PUBLISHER = """
import sys, time
import rclpy
from builtin_interfaces.msg import Time
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

rate, count, namespace = float(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
reliable = 'best_effort' not in sys.argv
qos = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT)
rclpy.init()
node = rclpy.create_node('muscle', namespace=namespace)
topics = ('displacement', 'current', 'displacement_setpoint')
plain = [node.create_publisher(Float64, topic, qos) for topic in topics]
stamped = node.create_publisher(Temperature, 'temperature', qos)
joints = node.create_publisher(JointState, 'joint_states', qos)
everyone = [*plain, stamped, joints]
clock = None
if 'clock' in sys.argv:
    clock = node.create_publisher(Clock, '/clock', 10)
    everyone.append(clock)
print('there', flush=True)
while not all(publisher.get_subscription_count() for publisher in everyone):
    time.sleep(0.01)
begun = time.monotonic()
for k in range(count):
    now = node.get_clock().now().nanoseconds if clock is None else 1_000_000_000 + round(k * 1e9 / rate)
    stamp = Time(sec=now // 10**9, nanosec=now % 10**9)
    if clock is not None:
        clock.publish(Clock(clock=stamp))
    for publisher in plain:
        publisher.publish(Float64(data=k * 1e-6))
    message = Temperature(temperature=20.0 + k)
    message.header.stamp = stamp
    stamped.publish(message)
    message = JointState(name=['muscle'], position=[k * 1e-6], velocity=[0.0], effort=[0.5])
    message.header.stamp = stamp
    joints.publish(message)
    time.sleep(max(0.0, begun + (k + 1) / rate - time.monotonic()))
for publisher in everyone:
    if reliable:
        publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=10))
print('published', flush=True)
time.sleep(600)
"""
# The tool on a disk that is full once the recorder comes to that method: FULL % (method, bytes that a file may have).
FULL = """
import resource, signal, sys
from tcp_muscle_ros import tool
from tcp_muscle_ros.nodes.recorder import Recorder
whole = Recorder.%s
def full(self, *arguments):
    resource.setrlimit(resource.RLIMIT_FSIZE, (%d, resource.RLIM_INFINITY))
    return whole(self, *arguments)
Recorder.%s = full
code = tool.main(sys.argv[1:])
assert signal.getsignal(signal.SIGINT) is signal.default_int_handler, 'the handlers were not given back'
sys.exit(code)
"""
# The recorder, which tells a second file, that no buffer holds back, of each message that it has written: its topic,
# when it was received and when it was written; and of when the bag was closed: record.py TOLD ARGUMENTS...
RECORDER = """
import os, sys, time
from tcp_muscle_ros.recording.bag_writer import BagWriter
from tcp_muscle_ros.tool import main
told = os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
write, close = BagWriter.write_serialized, BagWriter.close
def write_and_tell(self, topic, payload, received):
    now = time.time_ns()
    write(self, topic, payload, received)
    os.write(told, f'{topic} {received} {now}\\n'.encode())
def close_and_tell(self):
    os.write(told, f'closed 0 {time.time_ns()}\\n'.encode())
    close(self)
BagWriter.write_serialized, BagWriter.close = write_and_tell, close_and_tell
raise SystemExit(main(['record', *sys.argv[2:]]))
"""
# The tool whose recorder waits for its first message for three seconds instead of ten.
IMPATIENT = """
import sys
from tcp_muscle_ros import tool
from tcp_muscle_ros.nodes import recorder
recorder._PATIENCE_S = 8.0  # on a busy machine a process is discovered late
sys.exit(tool.main(['record', *sys.argv[1:]]))
"""
TOPICS = {'displacement', 'current', 'displacement_setpoint', 'temperature', 'joint_states'}


@pytest.fixture
def environment():
    with domains.lent() as domain:
        yield os.environ | {
            'ROS_DOMAIN_ID': str(domain),
            'ROS_PYTHON_CHECK_FIELDS': '1',
            'PYTHONPATH': os.pathsep.join(filter(None, sys.path)),
            'PYTHONUNBUFFERED': '1',
        }


@pytest.fixture
def start(environment):
    """Start a process; whatever was started is ended with the test."""
    processes = []

    def popen(*command):
        process = subprocess.Popen(
            [sys.executable, *map(str, command)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        return process

    yield popen
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture
def publish(start):
    return lambda *arguments: start('-c', PUBLISHER, *arguments)


@pytest.fixture
def record(start, tmp_path):
    return lambda *arguments: start('-m', 'tcp_muscle_ros.tool', 'record', '--output', tmp_path / 'bag', *arguments)


@pytest.fixture
def record_impatiently(start, tmp_path):
    return lambda *arguments: start('-c', IMPATIENT, '--output', tmp_path / 'bag', *arguments)


@pytest.fixture
def record_and_tell(start, tmp_path):
    return lambda *arguments: start('-c', RECORDER, tmp_path / 'told', '--output', tmp_path / 'bag', *arguments)


def bag_size(bag):
    return sum(path.stat().st_size for path in bag.glob('*.mcap'))


def told(folder, topic=''):
    """What a recorder has told of a topic, of all topics, or 'closed': (int64[n] received, int64[n] written), ns."""
    whole, _, _ = (folder / 'told').read_text().rpartition('\n') if (folder / 'told').exists() else ('', '', '')
    rows = [line.split() for line in whole.splitlines() if line.startswith(f'{topic} ' if topic else '/')]
    received, written = np.array([row[1:] for row in rows], dtype=np.int64).reshape(-1, 2).T
    return received, written


def wait_for(condition, what, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f'{what} did not happen within {seconds:g} s'
        time.sleep(0.02)


def line(process, begins):
    """Read a process's output up to a line that begins so."""
    for text in process.stdout:
        if text.startswith(begins):
            return text
    raise AssertionError(f'{begins!r} never came; it said on stderr: {process.stderr.read()}')


@pytest.mark.parametrize('how', [signal.SIGINT, signal.SIGTERM])
def test_every_message_from_the_first_to_the_last_is_in_the_bag(publish, record, tmp_path, how):
    recorder = record('--namespace', 'm1')
    line(recorder, 'waiting')
    publisher = publish(200, 600, 'm1')
    line(publisher, 'published')
    recorder.send_signal(how)
    recorder.send_signal(how)  # an impatient user
    out, error = recorder.communicate(timeout=30)
    assert (recorder.returncode, error) == (0, '')
    assert '3000 messages on 5 topics' in out
    came = {f'/m1/{topic}': [] for topic in TOPICS}
    with AnyReader([tmp_path / 'bag'], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == dict.fromkeys(came, 600)
        for connection, log_time, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
            came[connection.topic].append(log_time)
    recording = read_bag(tmp_path / 'bag')
    assert recording.notes == ()
    np.testing.assert_array_equal(recording['displacement'].value, np.arange(600) * 1e-6)
    np.testing.assert_allclose(recording['temperature'].value, 293.15 + np.arange(600), rtol=1e-15)
    # An unstamped message has the time of its tick where the system delivered that tick at once and apart from others;
    # what becomes of those that it delivered late is told from log times that are made (test_bag.py).
    displacement, tick = recording['displacement'].time, recording['temperature'].time
    assert np.all(np.diff(displacement) > 0.0)
    logged = np.array([came[f'/m1/{topic}'] for topic in ('displacement', 'temperature', 'joint_states')])
    first, last, period = logged.min(axis=0), logged.max(axis=0), 1e9 * np.median(np.diff(tick))
    apart = first[1:] - last[:-1] > 0.75 * period
    clear = 1 + np.flatnonzero(apart[:-1] & apart[1:] & (last - first < 0.25 * period)[1:-1])
    assert clear.size > 0
    np.testing.assert_array_equal(displacement[clear], tick[clear])


def test_a_log_reader_that_dies_does_not_end_the_recording(publish, record, tmp_path):
    recorder = record('--namespace', 'm1')
    line(recorder, 'waiting')
    recorder.stdout.close()
    line(publish(500, 100, 'm1'), 'published')
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(30) == 0
    assert recorder.stderr.read() == ''
    assert len(read_bag(tmp_path / 'bag')['temperature']) == 100


@pytest.mark.parametrize(('method', 'size'), [('run', 100_000), ('close', 1)])
def test_a_full_disk_is_one_line_and_what_was_recorded_is_kept(start, publish, tmp_path, method, size):
    bag = tmp_path / 'bag'
    recorder = start('-c', FULL % (method, size, method), 'record', '--output', bag)
    line(recorder, 'waiting')
    publisher = publish(500, 1000, '/')
    if method == 'close':
        line(publisher, 'published')
        wait_for(lambda: bag_size(bag) > 100_000, 'recording')
        recorder.send_signal(signal.SIGINT)
    _, error = recorder.communicate(timeout=30)
    assert recorder.returncode == 2, error
    assert error == (
        f'tcp_muscle record: {bag}: cannot be written (File too large); what was written until then is kept\n'
    )
    recording = read_bag(bag)
    assert any('was not closed' in note for note in recording.notes)
    assert len(recording['temperature']) > 100


def test_a_recorder_killed_with_minus_nine_has_lost_at_most_its_last_second(publish, record_and_tell, tmp_path):
    recorder = record_and_tell('--namespace', '/m1/')
    publish(50, 100_000, 'm1')
    wait_for(lambda: told(tmp_path)[1].size and np.ptp(told(tmp_path)[1]) > 1.9e9, 'recording')
    os.kill(recorder.pid, signal.SIGKILL)
    recorder.wait()
    recording = read_bag(tmp_path / 'bag')
    assert any('was not closed' in note for note in recording.notes)
    for name, first in (('displacement', 0.0), ('temperature', 293.15), ('current', 0.0)):
        received, written = told(tmp_path, f'/m1/{name}')
        assert recording[name].value[0] == first
        lost = written[len(recording[name]) :]
        assert lost.size == 0 or (lost[-1] - lost[0]) * 1e-9 < 1.0, name
        assert np.median(written - received) < 0.1e9, 'what has come waits to be written'
    steps = np.round(np.diff(recording['displacement'].value) * 1e6)
    assert set(steps) == {1.0}


def test_a_duration_counts_from_the_first_message_and_topics_may_join_late(publish, record_and_tell, tmp_path):
    recorder = record_and_tell('--duration', '2')
    line(recorder, 'waiting')
    publish(100, 100_000, 'other')  # not in the namespace that is recorded
    publish(100, 100_000, '/')
    _, error = recorder.communicate(timeout=60)
    assert (recorder.returncode, error) == (0, '')
    recording = read_bag(tmp_path / 'bag')
    with AnyReader([tmp_path / 'bag'], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        lasted = reader.duration * 1e-9
    received, written = told(tmp_path)
    assert (told(tmp_path, 'closed')[1][0] - written[0]) * 1e-9 > 1.99, 'it ended early'
    # Who waits for the processor, at the beginning and at the end, is a little late.
    pause = 1e-9 * max(np.diff(np.sort(received)).max(), np.diff(written).max(), (written - received).max())
    assert lasted < 2.1 + 2.0 * pause
    assert {channel.topic for channel in recording.channels.values()} <= {f'/{t}' for t in TOPICS}


def test_a_publisher_that_offers_best_effort_only_is_recorded(publish, record, tmp_path):
    recorder = record('--duration', '1')
    publish(100, 100_000, '/', 'best_effort')
    _, error = recorder.communicate(timeout=60)
    assert (recorder.returncode, error) == (0, '')
    assert len(read_bag(tmp_path / 'bag')['displacement']) > 50


def test_with_simulated_time_the_log_is_on_that_clock(publish, record, tmp_path):
    recorder = record('--use-sim-time')
    publisher = publish(200, 400, '/', 'clock')
    line(publisher, 'published')
    recorder.send_signal(signal.SIGINT)
    _, error = recorder.communicate(timeout=30)
    assert (recorder.returncode, error) == (0, '')
    recording = read_bag(tmp_path / 'bag')
    assert recording.start_ns == 1_000_000_000
    np.testing.assert_allclose(recording['temperature'].time, np.arange(400) / 200, atol=1e-9)
    assert recording['displacement'].value.tolist() == (np.arange(400) * 1e-6).tolist()
    assert recording['displacement'].time[-1] == pytest.approx(399 / 200, abs=0.05)


def test_without_a_clock_simulated_time_is_said_to_be_missing(publish, record_impatiently):
    recorder = record_impatiently('--use-sim-time', '--duration', '1')
    publish(100, 100_000, '/')
    _, error = recorder.communicate(timeout=60)
    assert recorder.returncode == 2
    assert error.startswith('tcp_muscle record: no message on /clock within 8 s')


def test_nothing_to_record_says_where_there_is_something(publish, record_impatiently, tmp_path):
    line(publish(100, 100_000, 'm1'), 'there')  # waits for a recorder that never subscribes, but its topics are there
    recorder = record_impatiently('--duration', '1')
    _, error = recorder.communicate(timeout=60)
    assert recorder.returncode == 2
    assert re.match(
        r'tcp_muscle record: no message under / within 8 s \(ROS_DOMAIN_ID \d+\); '
        r'there are muscles under /m1 \(--namespace\)\n',
        error,
    )
    assert error.count('\n') == 1
    assert not (tmp_path / 'bag').exists()


def test_stopped_before_the_first_message_no_bag_is_written(record, tmp_path):
    recorder = record()
    line(recorder, 'waiting')
    recorder.send_signal(signal.SIGINT)
    out, error = recorder.communicate(timeout=30)
    assert recorder.returncode == 2, out
    assert error.startswith('tcp_muscle record: no message came of a muscle under /; ')
    assert error.endswith('bag was not written\n') and error.count('\n') == 1
    assert not (tmp_path / 'bag').exists()


# A node that is no muscle says how it is: diagnostics.py
DIAGNOSED = """
import time
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
rclpy.init()
publisher = rclpy.create_node('camera').create_publisher(DiagnosticArray, '/diagnostics', 10)
while True:
    publisher.publish(DiagnosticArray())
    if publisher.get_subscription_count():
        print('heard', flush=True)
    time.sleep(0.02)
"""


def test_where_only_diagnostics_are_heard_no_bag_is_written_and_the_old_one_stays(start, record, tmp_path):
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'bag_0.mcap').write_text('old')
    recorder = record('--force')
    line(recorder, 'waiting')
    line(start('-c', DIAGNOSED), 'heard')
    time.sleep(0.5)
    recorder.send_signal(signal.SIGINT)
    out, error = recorder.communicate(timeout=30)
    assert recorder.returncode == 2, out
    assert 'no message came of a muscle under /' in error
    assert [path.name for path in tmp_path.iterdir()] == ['bag']
    assert (tmp_path / 'bag' / 'bag_0.mcap').read_text() == 'old'


def test_a_bag_is_replaced_by_force_once_the_new_one_is_whole(publish, record, tmp_path):
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'bag_0.mcap').write_text('old')
    recorder = record('--force')
    line(recorder, 'waiting')
    line(publish(100, 50, '/'), 'published')
    recorder.send_signal(signal.SIGINT)
    out, error = recorder.communicate(timeout=30)
    assert (recorder.returncode, error) == (0, ''), out
    assert len(read_bag(tmp_path / 'bag')['displacement']) == 50
    assert [path.name for path in tmp_path.iterdir()] == ['bag']


@pytest.mark.parametrize(
    ('arguments', 'says'),
    [
        (['--namespace', 'no good'], '--namespace no good: '),
        (['--output', '.'], 'exists already'),
        (['--output', f'{__file__}/bag'], f'{__file__} is a file; expected a folder'),
    ],
)
def test_bad_arguments_are_one_line(record, arguments, says):
    recorder = record(*arguments)
    out, error = recorder.communicate(timeout=30)
    assert (recorder.returncode, out) == (2, '')
    assert error.startswith('tcp_muscle record: ')
    assert says in error
    assert error.count('\n') == 1


def test_more_topics_of_any_type_are_recorded_and_so_is_the_shaped_setpoint(bench, tmp_path):
    from std_msgs.msg import Float64, String

    wanted = ('note', '/elsewhere/count', 'never', 'noted')
    arguments = [*(word for topic in wanted for word in ('--topic', topic)), '--namespace', 'more']
    program = bench.run(['-m', 'tcp_muscle_ros.tool', 'record', '--output', str(tmp_path / 'bag'), *arguments], 'more')
    publishers = {
        bench.node.create_publisher(String, '/more/note', 10): String(data='warm'),
        bench.node.create_publisher(Float64, '/elsewhere/count', 10): Float64(data=3.0),
        bench.node.create_publisher(Float64, '/more/shaped_setpoint', 10): Float64(data=0.01),
        bench.node.create_publisher(Float64, '/more/displacement', 10): Float64(data=0.01),
    }

    def all_heard():
        for publisher, message in publishers.items():
            publisher.publish(message)
        time.sleep(0.05)
        return all(f'recording {publisher.topic_name}' in program.said() for publisher in publishers)

    bench.until(all_heard, 'not all are recorded', 60.0)
    assert program.end(signal.SIGINT) == 0, program.said()
    assert program.said().strip().endswith('; nobody publishes /more/never, /more/noted (did you mean /more/note?)')
    with AnyReader([tmp_path / 'bag']) as bag:
        assert {c.topic: c.msgtype for c in bag.connections} == {
            '/more/note': 'std_msgs/msg/String',
            '/elsewhere/count': 'std_msgs/msg/Float64',
            '/more/shaped_setpoint': 'std_msgs/msg/Float64',
            '/more/displacement': 'std_msgs/msg/Float64',
        }


def test_two_that_publish_one_measurement_are_named_and_two_commanders_are_not_its_matter(bench, tmp_path):
    """As a simulation that was left running in the background does."""
    from std_msgs.msg import Float64

    one, other = (bench.node.create_publisher(Float64, '/left/displacement', 10) for _ in range(2))
    commands = [bench.node.create_publisher(Float64, '/left/current_command', 10) for _ in range(2)]
    arguments = ['--output', str(tmp_path / 'bag'), '--namespace', 'left']
    program = bench.run(['-m', 'tcp_muscle_ros.tool', 'record', *arguments], 'left')
    me = bench.node.get_fully_qualified_name()

    def named():
        for publisher in (one, other, *commands):
            publisher.publish(Float64(data=0.01))
        time.sleep(0.05)
        return f'/left/displacement is published by {me} and by {me}: what is recorded mixes them' in program.said()

    bench.until(named, 'two publishers are no matter', 60.0)
    assert 'current_command is published by' not in program.said()
    assert program.end(signal.SIGINT) == 0, program.said()


def test_what_was_said_once_for_those_who_come_late_is_in_the_bag_once(bench, tmp_path):
    """A rig that says its load and its spool when it starts, before the recorder; and a load that is said otherwise."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Float64, String

    rig = f'/rig_{time.monotonic_ns()}'  # what an attempt before this one has said once lasts
    lasting = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    load, spool = (
        bench.node.create_publisher(k, f'{rig}/{n}', lasting) for k, n in ((Float64, 'load'), (String, 'spool'))
    )
    displacement = bench.node.create_publisher(Float64, f'{rig}/displacement', 10)
    for value in (0.2, 0.3):
        load.publish(Float64(data=value))
    spool.publish(String(data='7'))
    arguments = ['--output', str(tmp_path / 'bag'), '--namespace', rig, '--topic', 'spool']
    program = bench.run(['-m', 'tcp_muscle_ros.tool', 'record', *arguments], rig)

    def recorded(topic, publisher=displacement, value=0.01):
        publisher.publish(Float64(data=value))
        time.sleep(0.05)
        return f'recording {rig}/{topic}' in program.said()

    for topic in ('load', 'spool', 'displacement'):
        bench.until(lambda topic=topic: recorded(topic), f'{topic} is not recorded', 60.0)
    load.publish(Float64(data=0.4))
    other = bench.node.create_publisher(Float64, f'{rig}/load', 10)  # keeps nothing
    resistance = bench.node.create_publisher(Float64, f'{rig}/resistance', lasting)  # heard before it is seen to last
    for k in range(100):
        recorded('load', other, 0.5)
        resistance.publish(Float64(data=float(k)))
    resistance.wait_for_all_acked()
    time.sleep(1.0)  # what has come is taken, also on a busy machine
    assert program.end(signal.SIGINT) == 0, program.said()
    recording = read_bag(tmp_path / 'bag')
    values = recording['load'].value.tolist()
    assert values[:3] == [0.2, 0.3, 0.4]
    assert len(values) > 10 and set(values[3:]) == {0.5}
    np.testing.assert_array_equal(np.diff(recording['resistance'].value), 1.0)
    assert recording['resistance'].value[-1] == 99.0
    assert recording['load'].time[0] < recording['displacement'].time[0] + 3.0
    with AnyReader([tmp_path / 'bag']) as bag:
        assert sum(c.msgcount for c in bag.connections if c.topic == f'{rig}/spool') == 1
