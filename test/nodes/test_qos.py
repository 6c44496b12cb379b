"""Who hears whom over DDS: measurements either way, commands reliably, and what is said where nobody hears."""

import re
import threading
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.topics import COMMAND_QOS, MEASUREMENT_QOS, STATE_QOS, qos_mismatch

pytestmark = pytest.mark.processes

ROOT = Path(__file__).resolve().parents[2]
RELIABLE, BEST_EFFORT = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT


def offered(reliability):
    return QoSProfile(depth=10, reliability=reliability)


def said(heard, name):
    """The latest message of /diagnostics about a node."""
    return next((s.message for _, array in reversed(heard) for s in array.status if s.name == name), '')


@pytest.fixture(scope='module')
def diagnostics(bench):
    return bench.listen('/diagnostics', DiagnosticArray)


@pytest.fixture(scope='module')
def controllers(bench):
    """One that hears as it comes, and one that was told to insist."""
    strict = '-p', 'qos_overrides./strict/displacement.subscription.reliability:=reliable'
    plain, told = bench.start('controller_node', 'plain'), bench.start('controller_node', 'strict', *strict)
    return {'plain': plain, 'strict': told}


class Sensor:
    """Publishes a displacement that moves, and so is alive, at 100 Hz."""

    def __init__(self, bench, namespace, reliability):
        self._bench, self._stop = bench, threading.Event()
        self._publisher = bench.node.create_publisher(Float64, f'/{namespace}/displacement', offered(reliability))
        self._thread = threading.Thread(target=self._publish, daemon=True)

    def _publish(self):
        k = 0
        while not self._stop.wait(0.01):
            self._publisher.publish(Float64(data=1e-4 * (k % 2)))
            k += 1

    def __enter__(self):
        self._thread.start()

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._bench.until(self._bench.executor.create_task(self._end).done, 'the bench itself hangs')

    def _end(self):
        self._bench.node.destroy_publisher(self._publisher)


def test_only_what_differs_is_said_to():
    """A deadline that nobody stated is 0 in one graph and without end in another."""
    never = QoSProfile(depth=1, deadline=Duration(seconds=9e9), liveliness_lease_duration=Duration(seconds=9e9))
    assert qos_mismatch(offered(BEST_EFFORT), never) == 'best effort publisher and reliable subscription'
    assert qos_mismatch(offered(RELIABLE), never) == ''
    both = QoSProfile(depth=1, deadline=Duration(seconds=1.0))
    assert qos_mismatch(offered(BEST_EFFORT), both) == (
        'best effort publisher and reliable subscription, subscription has a deadline, but publisher does not'
    )


@pytest.mark.parametrize('reliability', [BEST_EFFORT, RELIABLE], ids=['best_effort', 'reliable'])
def test_a_sensor_is_heard_whichever_way_it_offers(bench, controllers, reliability):
    command = bench.listen('/plain/current_command')
    setpoint = bench.speaker('/plain/displacement_setpoint')
    bench.until(lambda: command, 'controller_node publishes nothing', 120.0)
    with Sensor(bench, 'plain', reliability):
        setpoint.publish(Float64(data=0.02))
        bench.until(lambda: command.last.data > 0.1, 'the sensor is not heard')
    bench.until(lambda: command.last.data == 0.0, 'without its sensor it heats on')
    bench.forget(command)


def test_a_sensor_that_cannot_be_heard_is_said_to_be_one(bench, controllers, diagnostics):
    setpoint = bench.speaker('/strict/displacement_setpoint')
    setpoint.publish(Float64(data=0.02))
    node = '/strict/controller_node'
    bench.until(lambda: 'no displacement yet' in said(diagnostics, node), 'silence is not said')
    with Sensor(bench, 'strict', BEST_EFFORT):
        bench.until(lambda: 'incompatible QoS' in said(diagnostics, node), 'not said')
        message = said(diagnostics, node)
        assert 'incompatible QoS on /strict/displacement with /bench: best effort publisher and reliable' in message
        assert 'no displacement yet' not in message and message.count('incompatible') == 1
    bench.until(lambda: 'incompatible' not in said(diagnostics, node), 'said of a sensor that is gone')
    assert controllers['strict'].said().count('incompatible QoS on /strict/displacement') == 1
    with Sensor(bench, 'strict', RELIABLE):
        bench.until(lambda: said(diagnostics, node).startswith('enabled'), 'a reliable one is not heard')


def test_a_twin_hears_every_measurement_either_way_and_says_what_it_cannot_hear(bench, diagnostics):
    override = '-p', 'qos_overrides./watched/displacement.subscription.reliability:=reliable'
    bench.start('twin_node', 'watched', *override)
    load = bench.node.create_publisher(Float64, '/watched/load', offered(BEST_EFFORT))
    with Sensor(bench, 'watched', BEST_EFFORT):
        expected = 'incompatible QoS on /watched/displacement with /bench'
        bench.until(lambda: expected in said(diagnostics, '/watched/twin_node'), 'not said', 120.0)
        bench.until(load.get_subscription_count, 'its load is not heard')
        assert '/watched/load' not in said(diagnostics, '/watched/twin_node')
    bench.until(bench.executor.create_task(lambda: bench.node.destroy_publisher(load)).done, 'the bench hangs')


@pytest.fixture(scope='module')
def hand(bench):
    mistyped = '-p', 'qos_overrides./hand/thumb/displacment.publisher.depth:=3'
    return bench.start('sim_node', 'hand', '-p', 'muscles:=[thumb, index]', *mistyped)


def test_a_commander_that_cannot_be_heard_is_said_to_be_one(bench, hand, diagnostics):
    publisher = bench.node.create_publisher(Float64, '/hand/index/current_command', offered(BEST_EFFORT))
    expected = 'incompatible QoS on /hand/index/current_command with /bench: best effort publisher'
    bench.until(lambda: expected in said(diagnostics, '/hand/sim_node/index'), 'not said', 120.0)
    bench.until(bench.executor.create_task(lambda: bench.node.destroy_publisher(publisher)).done, 'the bench hangs')
    bench.until(lambda: 'incompatible' not in said(diagnostics, '/hand/sim_node/index'), 'said of one that is gone')


def test_a_listener_who_asks_for_too_much_and_one_of_another_type_are_named(bench, hand, diagnostics):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    greedy = bench.node.create_subscription(Float64, '/hand/thumb/force', lambda _: None, latched)
    other = bench.node.create_publisher(DiagnosticArray, '/hand/thumb/load', offered(RELIABLE))
    for expected in (
        'incompatible QoS on /hand/thumb/force with /bench',
        'incompatible type on /hand/thumb/load with /bench: diagnostic_msgs/msg/DiagnosticArray, expected std_msgs/msg',
    ):
        bench.until(lambda: expected in said(diagnostics, '/hand/sim_node/thumb'), f'not said: {expected}', 120.0)  # noqa: B023

    def end():
        bench.node.destroy_subscription(greedy)
        bench.node.destroy_publisher(other)

    bench.until(bench.executor.create_task(end).done, 'the bench hangs')


def test_an_override_that_fits_no_topic_is_named_with_the_nearest(bench, hand):
    name = 'qos_overrides./hand/thumb/displac{}ment.publisher.depth'
    expected = f"parameter '{name.format('')}' fits no topic of this node; did you mean '{name.format('e')}'?"
    bench.until(lambda: expected in hand.said(), 'not said', 120.0)


def table():
    """README's table of QoS: topic -> (reliability, depth)."""
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    rows = re.findall(r'^\| (in|out)[^|]*\| (`[^|]*`)[^|]*\| (best effort|reliable), keep last (\d+) \|$', text, re.M)
    return {(way, name): (kind, int(n)) for way, names, kind, n in rows for name in re.findall(r'`([\w/]+)`', names)}


def test_the_table_in_the_readme_is_what_the_nodes_do(bench, controllers, hand):
    """Reliability and durability as the graph shows them. It does not show depths: those are held to the profiles."""
    told = table()
    assert len(told) > 15
    profiles = {('best effort', 10): MEASUREMENT_QOS, ('reliable', 1): COMMAND_QOS, ('reliable', 10): STATE_QOS}
    for profile in profiles.values():
        assert profile.durability == DurabilityPolicy.VOLATILE and profile.history == HistoryPolicy.KEEP_LAST
    assert {key: (p.reliability == BEST_EFFORT, p.depth) for key, p in profiles.items()} == {
        key: (key[0] == 'best effort', key[1]) for key in profiles
    }
    places = {('controller_node', '/plain'): '/plain/', ('sim_node', '/hand'): '/hand/thumb/'}
    seen = set()
    for (node, namespace), prefix in places.items():
        for way, by_node, ends in (
            ('in', bench.node.get_subscriber_names_and_types_by_node, bench.node.get_subscriptions_info_by_topic),
            ('out', bench.node.get_publisher_names_and_types_by_node, bench.node.get_publishers_info_by_topic),
        ):
            for topic, _ in by_node(node, namespace):
                name = topic if topic == '/diagnostics' else topic.removeprefix(prefix)
                if name.startswith('/') and name != '/diagnostics':
                    continue  # rclpy's own, and the other muscle's
                (own,) = [end for end in ends(topic) if (end.node_name, end.node_namespace) == (node, namespace)]
                kind = 'best effort' if own.qos_profile.reliability == BEST_EFFORT else 'reliable'
                assert told[way, name][0] == kind, (node, way, name)
                assert own.qos_profile.durability == DurabilityPolicy.VOLATILE
                seen.add((way, name))
    # Topics of a joint, of self-sensing and of muscles on a joint: no node here has them.
    elsewhere = (
        'resistance', 'force', 'angle', 'angle_setpoint', 'cocontraction_setpoint', 'stiffness_setpoint',
        'external_torque',
    )  # fmt: skip
    assert set(told) - seen == {*(('in', name) for name in elsewhere), ('out', 'angle')}
