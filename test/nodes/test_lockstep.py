"""Lockstep over DDS: a simulation as fast as it goes, and nodes that keep its time, tick by tick."""

import threading
import time
from itertools import pairwise
from math import pi
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header

from tcp_muscle_ros.control.safety import Safety
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Muscles
from tcp_muscle_ros.nodes import lockstep
from tcp_muscle_ros.nodes.controllers import make_controller
from tcp_muscle_ros.nodes.lockstep import FollowingTime, LeadingTime
from tcp_muscle_ros.nodes.parameters import read
from tcp_muscle_ros.nodes.sim_muscle import make_muscle
from tcp_muscle_ros.nodes.topics import LEASE, REMEMBERED
from tcp_muscle_ros.settings.operating import CONTROL, SIM

pytestmark = pytest.mark.processes
PERIOD = 10_000_000  # ns
URDF = Path(__file__).resolve().parents[2] / 'urdf'
ENOUGH = QoSProfile(depth=1000)


PATIENT = 60.0  # s, for who learns of whom late on a busy machine
_MADE = []  # commanders of the test that runs


@pytest.fixture(autouse=True)
def nobody_answers_any_more():
    """The commander of a test that failed would answer for that of the next, which has its name."""
    yield
    while _MADE:
        _MADE.pop().silent_from = 0


class Commander:
    """Takes part in the lockstep as anybody's node may: sends what is due by tick, and says that it is done.

    ``schedule`` says by the number of the tick what is sent, a number or a message; ``slow`` in which ticks it
    takes 50 ms.
    """

    def __init__(self, bench, topic, schedule, slow=(), kind=Float64):
        self.bench, self.schedule, self.slow = bench, schedule, slow
        self.silent_from, self.ticks, self.lost = None, [], []
        _MADE.append(self)
        node = bench.node
        self.command = node.create_publisher(kind, topic, QoSProfile(depth=1))
        self.subscription = node.create_subscription(Header, '/lockstep/tick', self.tick, ENOUGH)
        self.done = node.create_publisher(Header, '/lockstep/done', ENOUGH)

    def join(self):
        def ready():
            self.done.publish(Header(frame_id='/bench'))  # again and again: who of them hears it nobody knows
            time.sleep(0.1)
            return self.ticks

        self.bench.until(self.command.get_subscription_count, 'nobody takes the commands', 120.0)
        self.bench.until(ready, 'no simulation that leads', 120.0)

    def tick(self, message):
        number = round((message.stamp.sec * 1_000_000_000 + message.stamp.nanosec) / PERIOD)
        self.ticks.append(number)
        if number in self.schedule:
            due = self.schedule[number]
            self.command.publish(Float64(data=due) if isinstance(due, float) else due)
            # Who takes it may know of this node later than this node of it, and is sent it again then: ticks later.
            if not self.command.wait_for_all_acked(Duration(seconds=0.5 * PATIENT)):
                self.lost.append(number)
        if number in self.slow:
            time.sleep(0.05)
        if self.silent_from is None or number < self.silent_from:
            self.done.publish(Header(stamp=message.stamp, frame_id='/bench'))

    def until(self, number):
        self.bench.until(lambda: self.ticks and self.ticks[-1] >= number, f'tick {number} does not come', 60.0)
        assert not self.lost, 'a command did not arrive'


def by_tick(heard):
    return {
        round((message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec) / PERIOD): message
        for _, message in heard[:]
    }


def by_the_books(setpoint, begin, ticks):
    """The same loop without nodes: displacement (m) and current (A) by tick. What a tick commands flows from the next.

    The controller keeps its own ticks from the first that it hears.
    """
    simulated, controlled = read({}, SIM), read({}, CONTROL)
    muscle, controller = Muscles([make_muscle(simulated)]), make_controller(controlled)
    plant = Safety(simulated.limits(command_timeout=0.5), enabled=True)
    safety = Safety(controlled.limits(command_timeout=0.0), enabled=True)
    dt, current, command, shown = PERIOD * 1e-9, 0.0, None, []
    for number in range(1, ticks + 1):
        (reading,) = muscle.step(dt, [current])
        if command is not None:
            plant.command(command, number * dt)
        current = plant.update(
            number * dt,
            dt,
            resistance=reading.resistance,
            temperatures=(reading.temperature, reading.fibre_temperature),
        )
        shown.append((reading.displacement, current))
        temperature = reading.temperature - ZERO_CELSIUS + ZERO_CELSIUS  # as it travels
        if number > begin:
            wanted = controller.update(
                setpoint,
                temperature=temperature,
                load=None,
                ambient=None,
                applied_current=current,
                displacement=reading.displacement,
            )
            safety.command(wanted.current, number * dt)
            command = safety.update(number * dt, dt, temperatures=(temperature, wanted.predicted_temperature))
        elif number > 1:
            command = safety.update(number * dt, dt, temperatures=(temperature, None))
    return shown


def test_a_closed_loop_as_fast_as_it_goes_is_the_loop_of_the_books_bit_for_bit(bench):
    begin, ticks = 50, 900
    sim = bench.start('sim_node', 'step', real_time_factor=0.0, lockstep_nodes=2, lockstep_timeout_s=PATIENT)
    controller = bench.start('controller_node', 'step', use_sim_time=True)
    joints = bench.listen('/step/joint_states', JointState)
    commander = Commander(bench, '/step/displacement_setpoint', {begin: 0.02}, slow=(begin, 120, 121, 500))
    commander.join()
    commander.until(ticks)
    heard = by_tick(joints)
    expected = by_the_books(0.02, begin, ticks)
    assert {number: heard[number].position[0] for number in range(1, ticks)} == {
        number: displacement for number, (displacement, _) in enumerate(expected[: ticks - 1], 1)
    }
    assert abs(heard[ticks - 1].position[0] - 0.02) < 1e-9
    for program in (controller, sim):
        program.kill()
    bench.forget(joints, commander)


def test_who_does_not_answer_is_waited_for_no_more_and_may_come_back(bench):
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    sim = bench.start('sim_node', 'patient', real_time_factor=0.0, lockstep_nodes=1, lockstep_timeout_s=0.5)
    waits = 'lockstep: waiting for 1 nodes; there: none'
    bench.until(lambda: any(waits in s.message for _, a in diagnostics for s in a.status), 'nobody is told', 120.0)
    commander = Commander(bench, '/patient/current_command', {})
    commander.silent_from = 10
    commander.join()
    commander.until(200)
    assert 'lockstep: /bench did not answer the tick at 0.1 s within 0.5 s and is no longer waited for' in sim.said()
    commander.silent_from = None
    bench.until(lambda: sim.said().count('in lockstep with /bench') == 2, 'it may not come back')
    sim.kill()
    bench.forget(commander, diagnostics)


def test_a_controller_that_keeps_the_systems_time_is_refused_with_the_reason(bench):
    sim = bench.start('sim_node', 'apart', real_time_factor=0.0)
    controller = bench.start('controller_node', 'apart')
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    commands = bench.listen('/apart/current_command')
    setpoint = bench.speaker('/apart/displacement_setpoint')
    reason = (
        '/apart/sim_node runs in lockstep and not in real time; start this node with --ros-args -p use_sim_time:=true'
    )

    def refused():
        setpoint.publish(Float64(data=0.01))
        said = [s.message for _, array in diagnostics[-20:] for s in array.status if s.name == '/apart/controller_node']
        return any(f'timed out, {reason}' in message for message in said)

    when = bench.until(refused, 'it is not refused')
    bench.until(lambda: len(commands.since(when)) > 20, 'it does not speak')
    assert not any(message.data for message in commands.since(when))
    assert f'0 A: {reason}' in controller.said()
    for program in (controller, sim):
        program.kill()
    bench.forget(diagnostics, commands)


class Graph:
    """A node that sees who publishes ``/clock``, and what it logs."""

    def __init__(self, *names):
        self.names, self.logged = names, []

    def count_publishers(self, _):
        return len(self.names)

    def get_publishers_info_by_topic(self, topic):
        assert topic == '/clock'
        spaces = (name.rpartition('/') for name in self.names)
        return [SimpleNamespace(node_namespace=space or '/', node_name=name) for space, _, name in spaces]

    def get_logger(self):
        return SimpleNamespace(warning=self.logged.append)

    def get_clock(self):
        return Clock(clock_type=ClockType.ROS_TIME)


@pytest.fixture
def clock(monkeypatch):
    made = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(lockstep, 'time', SimpleNamespace(monotonic=lambda: made.now))
    return made


@pytest.mark.parametrize('leads', [True, False])
def test_two_simulations_that_lead_are_named_once_neither_can_be_one_that_was_killed(clock, leads):
    graph = Graph('/a/sim_node')
    base = LeadingTime(graph, 2.0, 0, 10.0) if leads else FollowingTime(graph, None)

    def said(names, *moments):
        graph.names = names
        told = []
        for seconds in moments:
            clock.now += seconds
            told.append(base.held_up())
        return told

    both = '/clock is published by /a/sim_node and by /b/sim_node: stop all but one, or give each its domain'
    one, two = ('/a/sim_node',), ('/b/sim_node', '/a/sim_node')
    assert said(one, 1.0, 60.0) == ['', '']
    assert said(two, 1.0, LEASE) == ['', '']  # one of them was killed
    assert said(one, 1.0) == ['']
    assert said(two, 1.0, REMEMBERED, 1.0) == ['', both, both]
    assert graph.logged == [both]
    assert said(one, 1.0) == ['']
    assert said(('/a/sim_node', '/a/sim_node'), 1.0, 60.0) == ['', '']  # which diagnostics say of the name


def test_a_simulation_whose_peer_answers_the_ticks_of_another_says_for_whom_it_waits_and_who_leads_too(clock):
    base, stop, told = LeadingTime(Graph('/a/sim_node', '/b/sim_node'), 2.0, 0, 10.0), threading.Event(), []

    def answer(_):
        """One every second, of a tick of the other's."""
        clock.now += 1.0
        told.append(base.held_up())
        if len(told) == 4:
            stop.set()
        return (Header(frame_id='/a/controller_node', stamp=Time(sec=9)), 0) if len(told) != 1 else None

    base._inbox = SimpleNamespace(next=answer)
    base._done = {'/a/controller_node': 0}
    base._wait_for_peers(PERIOD, stop)
    assert told[-1] == (
        'lockstep: waiting for /a/controller_node (for 3 s); /clock is published by /a/sim_node and by /b/sim_node: '
        'stop all but one, or give each its domain, unless one was killed just now'
    )


def test_a_joint_of_two_muscles_turns_the_same_way_each_time(bench):
    def run(namespace):
        of_joint = ['-p', 'muscles:=[flexor, extensor]', '-p', 'joints:=[knuckle]']
        of_joint += ['-p', 'knuckle.agonist:=flexor', '-p', 'knuckle.antagonist:=extensor']
        sim = bench.start(
            'sim_node',
            namespace,
            *of_joint,
            real_time_factor=0.0,
            lockstep_nodes=2,
            lockstep_timeout_s=PATIENT,
            temperature_noise_k=0.2,
        )
        controller = bench.start('controller_node', namespace, *of_joint, use_sim_time=True)
        joints = bench.listen(f'/{namespace}/joint_states', JointState)
        commander = Commander(bench, f'/{namespace}/knuckle/angle_setpoint', {20: pi / 12})
        commander.join()
        commander.until(250)
        heard = by_tick(joints)
        for program in (controller, sim):
            program.kill()
        bench.forget(joints, commander)
        return [tuple(heard[number].position) for number in range(1, 250)]

    first = run('joint_a')
    assert abs(first[-1][2]) > 0.05  # it turns
    assert first == run('joint_b')


@pytest.mark.long
def test_an_elbow_stays_where_it_is_while_the_shoulder_lifts_it_if_the_arms_weight_is_known(bench):
    """As test/robots/test_controlled.py has it without nodes."""
    pytest.importorskip('mujoco', reason="needs MuJoCo (extra 'mujoco', Python 3.11 and later)")
    joints = ['shoulder', 'elbow']
    of_arm = [f'{joint}_{role}' for joint in joints for role in ('flexor', 'extensor')]
    given = [f'muscles:=[{", ".join(of_arm)}]', f'joints:=[{", ".join(joints)}]', 'load_n:=0.4']
    for joint in joints:
        given += [f'{joint}.agonist:={joint}_flexor', f'{joint}.antagonist:={joint}_extensor']
        given += [f'{joint}.radius_m:=0.012', f'{joint}.cocontraction_n:=0.7']
    given = [word for one in given for word in ('-p', one)]
    schedule = {
        at: JointState(name=joints, position=[shoulder, 0.3]) for at, shoulder in ((20, 0.0), (520, 0.0), (521, 0.6))
    }

    def strayed(namespace, *known):
        """How far the elbow went (rad) while the shoulder was lifted."""
        sim = bench.start(
            'sim_node',
            namespace,
            *given,
            '-p',
            'robot:=arm',
            real_time_factor=0.0,
            lockstep_nodes=2,
            lockstep_timeout_s=PATIENT,
        )
        controller = bench.start('controller_node', namespace, *given, *known, use_sim_time=True)
        states = bench.listen(f'/{namespace}/joint_states', JointState)
        commander = Commander(bench, f'/{namespace}/joint_commands', schedule, kind=JointState)
        commander.join()
        commander.until(1320)
        heard = by_tick(states)
        for program in (controller, sim):
            program.kill()
        bench.forget(states, commander)
        assert heard[1319].position[4] == pytest.approx(0.6, abs=3e-3)
        return max(abs(heard[number].position[5] - 0.3) for number in range(520, 1320))

    unknown = strayed('arm_felt')
    known = strayed('arm_known', '-p', f'description_file:={URDF / "arm.urdf"}')
    assert unknown > 5e-3
    assert known < 0.5 * unknown, (known, unknown)


def test_a_twin_predicts_in_the_time_of_the_simulation(bench):
    sim = bench.start('sim_node', 'twinned', real_time_factor=0.0, lockstep_nodes=2, lockstep_timeout_s=PATIENT)
    twin = bench.start('twin_node', 'twinned', use_sim_time=True)
    apart = bench.start('twin_node', 'twinned', '-r', '__node:=apart')
    residual = bench.listen('/twinned/twin_node/residual_displacement')
    predicted = bench.listen('/twinned/twin_node/predicted_displacement')
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    commander = Commander(bench, '/twinned/current_command', dict.fromkeys(range(1, 2000), 0.2), slow=(300, 400))
    commander.join()
    commander.until(600)
    bench.until(lambda: len(residual) > 400, 'the twin says little')  # what it said before it knew of the bench is lost
    moved = min(b - a for a, b in pairwise(predicted.values))
    # From tick to tick the residual changes by less than a hundredth of what the muscle moves: no tick was too many,
    # too few or of another length. (What is left of the state that was estimated at the start fades.)
    assert max(abs(b - a) for a, b in pairwise(residual.values)) < 0.01 * moved
    for value in (value for _, array in diagnostics[:] for status in array.status for value in status.values):
        if value.key.rpartition('_')[2] in ('a', 'c', 's', 'm', 'ohm'):  # a unit: a number, nan where there is none
            float(value.value)
    messages = {status.name: status.message for _, array in diagnostics[:] for status in array.status}
    assert messages['/twinned/twin_node'] == 'follows'
    assert '/twinned/sim_node runs in lockstep and not in real time' in messages['/twinned/apart']
    for program in (twin, apart, sim):
        program.kill()
    bench.forget(residual, predicted, diagnostics, commander)
