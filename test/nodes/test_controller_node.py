"""controller_node against rigs that lie, fall silent or ask for nonsense, and against a muscle that behaves."""

import re
import threading
import time
from contextlib import contextmanager
from itertools import pairwise
from math import inf, nan
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

pytestmark = pytest.mark.processes

LOST = 0.2  # s, the feedback's timeout at 100 Hz
MARGIN = 0.06  # s: two ticks, and what was under way; more where a pause of the machine was heard


@pytest.fixture(scope='module')
def diagnostics(bench):
    return bench.listen('/diagnostics', DiagnosticArray)


def stamp(message):
    """The time of a stamped message, ns."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class Controller:
    def __init__(self, bench, diagnostics, namespace, **parameters):
        self.bench, self.namespace, self._diagnostics = bench, namespace, diagnostics
        self.command = bench.listen(f'/{namespace}/current_command')
        self.shaped = bench.listen(f'/{namespace}/shaped_setpoint')
        self.program = bench.start('controller_node', namespace, **parameters)
        self.setpoint = bench.speaker(f'/{namespace}/displacement_setpoint')
        bench.until(lambda: self.command, 'controller_node publishes nothing', 120.0)

    def facts(self):
        for _, array in reversed(self._diagnostics[-50:]):
            for status in array.status:
                if status.name == f'/{self.namespace}/controller_node':
                    return {'message': status.message, **{value.key: value.value for value in status.values}}
        return {'message': '', 'state': ''}

    def call(self, kind, service, **fields):
        return self.bench.call(kind, f'/{self.namespace}/controller_node/{service}', **fields)

    def end(self):
        self.program.kill()
        self.bench.forget(self.command, self.shaped)


@contextmanager
def rig(bench, namespace, topic, value):
    """A sensor that publishes what ``value(k)`` says at 100 Hz, None for nothing."""
    publisher, stop = bench.speaker(f'/{namespace}/{topic}'), threading.Event()

    def publish():
        k = 0
        while not stop.wait(0.01):
            shown = value(k)
            if shown is not None:
                publisher.publish(Float64(data=shown))
            k += 1

    thread = threading.Thread(target=publish, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@pytest.fixture
def controller(bench, diagnostics, request):
    made = Controller(bench, diagnostics, request.node.name[:50].replace('[', '_').replace(']', ''))
    yield made
    made.end()


def test_a_frozen_sensor_stops_the_current(bench, controller):
    with rig(bench, controller.namespace, 'displacement', lambda k: 0.0):
        controller.setpoint.publish(Float64(data=0.02))
        bench.until(lambda: controller.command.last.data > 0.2, 'it does not begin')
        stopped = bench.until(lambda: controller.command.last.data == 0.0, 'it heats on against a dead sensor', 10.0)
        bench.until(lambda: 'displacement frozen at 0 while the model moves' in controller.program.said(), 'not said')
        bench.until(lambda: controller.facts()['state'] == 'timed out', 'not in the diagnostics')
        # What retries may do to a muscle whose sensor stays dead: a fraction of a millimetre.
        bench.until(lambda: len(controller.command.since(stopped)) > 500, 'it stands still')
        predicted = float(controller.facts()['predicted_displacement_m'])
        assert predicted < 1e-3


def test_feedback_that_moves_keeps_it_going_and_silence_stops_it(bench, controller):
    mute = threading.Event()
    with rig(bench, controller.namespace, 'displacement', lambda k: None if mute.is_set() else 1e-4 * (k % 2)):
        controller.setpoint.publish(Float64(data=0.02))
        begun = bench.until(lambda: controller.command.last.data > 0.2, 'it does not begin')
        bench.until(lambda: len(controller.command.since(begun)) > 150, 'it stands still')
        mute.set()
        silent = time.monotonic()
        bench.until(lambda: controller.command.last.data == 0.0, 'silence does not stop it', 5.0)
        assert controller.command.flowing_for(silent) < LOST + MARGIN + controller.command.pause(silent)
        mute.clear()
        bench.until(lambda: controller.command.last.data > 0.2, 'it does not come back', 10.0)


@pytest.mark.parametrize('broken', [nan, inf])
def test_feedback_that_is_no_number_is_no_feedback(bench, controller, broken):
    good = threading.Event()
    good.set()
    with rig(bench, controller.namespace, 'displacement', lambda k: 1e-4 * (k % 2) if good.is_set() else broken):
        controller.setpoint.publish(Float64(data=0.02))
        bench.until(lambda: controller.command.last.data > 0.2, 'it does not begin')
        good.clear()
        bench.until(lambda: controller.command.last.data == 0.0, 'it goes on', 5.0)
        bench.until(lambda: controller.facts().get('refused_inputs', '').startswith('displacement'), 'not counted')
        assert controller.program.process.poll() is None


# One muscle and its controller for what follows


@pytest.fixture(scope='module')
def pair(bench, diagnostics):
    sim = bench.start('sim_node', 'pair', displacement_noise_m=1e-5)
    made = Controller(bench, diagnostics, 'pair', start_enabled=False)
    made.displacement = bench.listen('/pair/displacement')
    bench.until(lambda: made.displacement, 'sim_node publishes nothing', 120.0)
    yield made
    made.end()
    sim.kill()
    bench.forget(made.displacement)


def test_it_waits_for_enable_and_for_a_setpoint_that_makes_sense(bench, pair):
    for count, nonsense in enumerate((nan, inf, 20.0), 1):  # the last one in millimetres
        pair.setpoint.publish(Float64(data=nonsense))
        wanted = f'displacement_setpoint {count}'
        bench.until(lambda wanted=wanted: pair.facts().get('refused_inputs') == wanted, 'not counted')
    assert pair.facts()['setpoint_m'] == 'nan' and 'no setpoint yet' in pair.facts()['message']
    pair.setpoint.publish(Float64(data=0.005))
    bench.until(lambda: pair.facts()['setpoint_m'] == '0.005', 'the setpoint is not taken')
    assert set(pair.command.values) == {0.0}, 'disabled'
    assert pair.call(SetBool, 'enable', data=True).success
    bench.until(lambda: abs(pair.displacement.last.data - 0.005) < 2e-4, 'it does not get there')


def test_it_holds_the_last_setpoint_and_shows_what_it_can_do_of_an_impossible_one(bench, pair):
    held = time.monotonic()
    bench.until(lambda: len(pair.displacement.since(held)) > 200, 'too few ticks')
    assert all(abs(message.data - 0.005) < 3e-4 for message in pair.displacement.since(held + 1.5))
    pair.setpoint.publish(Float64(data=0.4))
    bench.until(lambda: 0.04 < pair.shaped.last.data < 0.1, 'not shaped to what the muscle can do')
    assert max(pair.command.values) <= 0.27
    told = 'setpoint 0.4 m is beyond reach: '
    bench.until(lambda: told in pair.facts()['message'], 'nobody is told')
    pair.setpoint.publish(Float64(data=-0.02))
    told_below = 'setpoint -0.02 m is beyond reach: 0 m is the least, without a current (positive when shorter)'
    bench.until(lambda: told_below in pair.facts()['message'], 'nobody is told of a sign')
    pair.setpoint.publish(Float64(data=0.005))
    bench.until(lambda: 'beyond reach' not in pair.facts()['message'], 'it is told for ever')


def test_the_readmes_lines_of_python_command_a_muscle(bench, pair):
    text = (Path(__file__).resolve().parents[2] / 'README.md').read_text(encoding='utf-8')
    (lines,) = re.findall(r'```python\n(import rclpy.*?)```', text, re.DOTALL)
    program = bench.run(['-c', lines, '--ros-args', '-r', '__ns:=/pair'], 'readme')
    bench.until(lambda: pair.facts().get('setpoint_m') == '0.02', f'not heard: {program.said()}')


def test_ros2_control_speaks_through_joint_commands(bench, pair):
    joints = bench.speaker('/pair/joint_commands', JointState)
    joints.publish(JointState(name=['elbow', 'pair'], position=[0.02, 0.008]))
    bench.until(lambda: pair.facts()['setpoint_m'] == '0.008', 'not heard')
    refused = pair.facts()['refused_inputs']
    # What ros2_control sends before its first command is no mistake: it is ignored, and nothing is refused.
    joints.publish(JointState(name=['pair'], position=[nan]))
    joints.publish(JointState(name=['elbow'], position=[0.02]))
    joints.publish(JointState(name=['pair'], position=[0.009]))
    bench.until(lambda: pair.facts()['setpoint_m'] == '0.009', 'not heard after them')
    assert pair.facts()['refused_inputs'] == refused


def test_disable_and_reset(bench, pair):
    pair.setpoint.publish(Float64(data=0.03))
    bench.until(lambda: pair.command.last.data > 0.2, 'no current')
    assert pair.call(SetBool, 'enable', data=False).success
    disabled = time.monotonic()
    bench.until(lambda: len(pair.command.from_zero(disabled)) > 30, 'it stands still')
    assert set(pair.command.from_zero(disabled)) == {0.0}
    assert pair.command.flowing_for(disabled) < MARGIN + pair.command.pause(disabled)
    assert pair.call(Trigger, 'reset').message == 'reset: waiting for a setpoint'
    pair.call(SetBool, 'enable', data=True)
    enabled = time.monotonic()
    bench.until(lambda: len(pair.command.since(enabled)) > 30, 'it stands still')
    assert {message.data for message in pair.command.since(enabled)} == {0.0}, 'no setpoint, no current'
    pair.setpoint.publish(Float64(data=0.01))
    bench.until(lambda: pair.command.last.data > 0.0, 'it does not work again')
    assert pair.call(Trigger, 'reset').success
    bench.until(lambda: pair.command.last.data == 0.0, 'after a reset the last current flows on')
    assert pair.facts()['setpoint_m'] == 'nan'


def test_a_receiver_that_lets_nothing_flow_is_a_worry_until_it_does(bench, pair):
    worry = 'none of the current that is asked for flows'
    assert pair.call(SetBool, 'enable', data=True).success
    pair.setpoint.publish(Float64(data=0.01))
    bench.until(lambda: pair.command.last.data > 0.05, 'no current')
    assert worry not in pair.facts()['message']
    pair.setpoint.publish(Float64(data=0.04))
    assert bench.call(SetBool, '/pair/sim_node/enable', data=False).success
    bench.until(lambda: worry in pair.facts()['message'], 'nothing is said')
    assert bench.call(SetBool, '/pair/sim_node/enable', data=True).success
    bench.until(lambda: worry not in pair.facts()['message'], 'it is still said')
    assert pair.call(Trigger, 'reset').success


def test_resistance_alone_closes_the_loop_and_a_probe_wakes_a_rig_that_shows_none_without_current(bench, diagnostics):
    sim = bench.start('sim_node', 'sensed', min_sense_current_a=0.01)
    made = Controller(bench, diagnostics, 'sensed', feedback='resistance', probe_current_a=0.02)
    displacement = bench.listen('/sensed/displacement')
    made.setpoint.publish(Float64(data=0.01))
    bench.until(lambda: 0.02 in made.command.values, 'no probe')
    bench.until(lambda: displacement and abs(displacement.last.data - 0.01) < 1e-4, 'it does not get there')
    made.setpoint.publish(Float64(data=0.0))
    bench.until(lambda: displacement.last.data < 0.003, 'it does not let go')
    later = time.monotonic()
    bench.until(lambda: len(made.command.since(later)) > 100, 'it stands still')
    assert min(message.data for message in made.command.since(later)) >= 0.0
    assert max(message.data for message in made.command.since(later)) <= 0.05
    made.end()
    sim.kill()
    bench.forget(displacement)


def test_the_loop_closes_in_simulated_time_too(bench, diagnostics):
    sim = bench.start('sim_node', 'faster', real_time_factor=3.0)
    made = Controller(bench, diagnostics, 'faster', use_sim_time=True)
    joints = bench.listen('/faster/joint_states', JointState)
    begun = time.monotonic()
    made.setpoint.publish(Float64(data=0.01))
    bench.until(lambda: joints and abs(joints.last.position[0] - 0.01) < 1e-4, 'it does not get there')
    arrived = time.monotonic()
    bench.until(lambda: len(made.command.since(arrived)) > 50, 'it stands still')
    # What the muscle does while the machine holds the controller up is not the controller's.
    seen = [(stamp(message) * 1e-9, message.position[0]) for _, message in joints[:]]
    fastest = max((b - a) / (then - at) for (at, a), (then, b) in pairwise(seen))
    held_up = 3.0 * made.command.pause(begun)
    assert max(x for _, x in seen) < 0.01 + 1e-4 + fastest * held_up
    sim.kill()  # and /clock with it: no tick comes any more
    bench.until(lambda: made.command.last.data == 0.0, 'the last command stays on')
    bench.until(lambda: '/clock stands still' in made.program.said(), 'not said')
    made.end()
    bench.forget(joints)


def test_the_message_sequence_of_joint_state_topic_system(bench):
    """As joint_state_topic_hardware_interface 1.1.0 sends and reads: every cycle, NaN until a controller is active.

    Its publisher keeps one message, its subscription is of sensor data (best effort); it looks its joints up by name,
    and takes velocity and effort by the same index where they are not empty.
    """
    from rclpy.qos import qos_profile_sensor_data

    name = 'finger_3'
    sim = bench.start('sim_node', name)
    controller = bench.start('controller_node', name)
    states = []
    bench.node.create_subscription(JointState, f'/{name}/joint_states', states.append, qos_profile_sensor_data)
    commands = bench.speaker(f'/{name}/joint_commands', JointState)
    displacement = bench.listen(f'/{name}/displacement')
    bench.until(lambda: states, 'no state', 120.0)

    def send(position, count, *, also=()):
        for _ in range(count):
            message = JointState(name=[name, *also], position=[position, *[0.0] * len(also)])
            message.header.stamp = bench.node.get_clock().now().to_msg()
            commands.publish(message)
            time.sleep(0.01)

    def state():
        (index,) = (k for k, one in enumerate(states[-1].name) if one == name)
        return states[-1].position[index], states[-1].velocity[index], states[-1].effort[index]

    send(nan, 50)  # configured, inactive
    send(state()[0], 20)  # activated: where the joint is
    send(0.005, 100, also=('wheel',))
    bench.until(lambda: abs(state()[0] - 0.005) < 2e-4, 'it does not go there')
    send(0.005, 100)  # a held setpoint is sent on, and nothing times out
    assert abs(displacement.last.data - 0.005) < 2e-4 and state()[2] > 0.0
    for _ in range(3):
        commands.publish(JointState(name=[name, 'wheel']))
        time.sleep(0.05)
    bench.until(lambda: controller.said().count(f"joint_commands names '{name}', without a position") == 1, 'not said')
    send(nan, 50)  # deactivated: it holds
    assert abs(state()[0] - 0.005) < 2e-4
    said = controller.said()
    assert 'refused' not in said and 'timed out' not in said, said
    send(7.0, 1)
    bench.until(lambda: f"joint_commands '{name}' of 7 refused" in controller.said(), 'refused as another input')
    assert said.count("joint_commands names 'wheel', no joint of this node; known: finger_3") == 1, said
    for program in (controller, sim):
        program.kill()


def test_a_set_whose_source_states_no_resistance_is_warned_of_once(bench):
    file = ['--params-file', str(Path(__file__).resolve().parents[2] / 'config' / 'sun_zhao_2021.yaml')]
    warned = "R0 = 14 ohm is that of the paper's muscle: the source of sun_zhao_2021 states none"
    alone, measured = (
        bench.start('controller_node', name, *file, *more)
        for name, more in (('unstated', ()), ('measured', ('-p', 'R0:=20.0')))
    )
    for name in ('unstated', 'measured'):
        bench.call(Trigger, f'/{name}/controller_node/reset')
    assert alone.said().count(warned) == 1 and 'current_limit_a=0.23' in alone.said()
    assert 'R0 =' not in measured.said()
    assert [one.end(2) for one in (alone, measured)] == [0, 0]
