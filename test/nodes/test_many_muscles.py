"""One process with many muscles: each has its topics, values, watchdog and faults; two of them turn a joint."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from tcp_muscle_ros.control.antagonist import Side
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters
from tcp_muscle_ros.nodes.plan import read_plan
from tcp_muscle_ros.settings.operating import CONTROL, DRIVER, SIM

CONFIG = Path(__file__).resolve().parents[2] / 'config'
HAND = CONFIG / 'hand.yaml'
NAMES = yaml.safe_load(HAND.read_text())['/**']['ros__parameters']['muscles']
TWO = {'muscles': ['thumb', 'index']}
JOINT = {**TWO, 'joints': ['knuckle'], 'knuckle.agonist': 'thumb', 'knuckle.antagonist': 'index'}


def stamp(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


# Values


def test_a_name_alone_is_the_value_of_all_and_with_a_muscles_name_that_of_one():
    given = {'hA': 0.03, 'index.hA': 0.02, 'index.effects': ['creep'], 'index.creep.J': 0.1, 'seed': 5}
    plan = read_plan({**TWO, **given}, SIM)
    thumb, index = plan.muscles['thumb'], plan.muscles['index']
    assert (thumb['hA'], index['hA'], index['creep.J']) == (0.03, 0.02, 0.1)
    assert thumb.muscle().effects == () and index.muscle().effects == ('creep',)
    assert (thumb['joint_name'], index['joint_name']) == ('thumb', 'index')
    assert (thumb['seed'], index['seed']) == (5, 6), 'each has its own noise'
    assert read_plan({**TWO, **given}, CONTROL).muscles['index']['hA'] == 0.02


@pytest.mark.parametrize('nothing', [None, [], ['']])
def test_without_muscles_there_is_one_in_the_nodes_own_namespace(nothing):
    plan = read_plan({'muscles': nothing, 'hA': 0.02}, SIM)
    assert list(plan.muscles) == [''] and not plan.many and plan.muscles['']['joint_name'] == 'tcp_muscle'


@pytest.mark.parametrize(
    ('namespace', 'given', 'joint'),
    [
        ('/', {}, 'tcp_muscle'),
        ('/left/finger_1', {}, 'finger_1'),
        ('/finger_1', {'joint_name': 'knuckle'}, 'knuckle'),
        ('/finger_1', {'joint_name': 'tcp_muscle'}, 'tcp_muscle'),
    ],
)
@pytest.mark.parametrize('owner', [SIM, CONTROL, DRIVER])
def test_the_joint_of_one_muscle_has_the_name_of_its_namespace_unless_told_otherwise(namespace, given, joint, owner):
    assert read_plan(given, owner, namespace).muscles['']['joint_name'] == joint
    assert read_plan(TWO, owner, namespace).muscles['thumb']['joint_name'] == 'thumb'


@pytest.mark.parametrize(
    ('given', 'line'),
    [
        ({**TWO, 'thum.hA': 0.02}, "parameter 'thum.hA': unknown muscle 'thum'; did you mean 'thumb'?"),
        ({**TWO, 'thumb.ha': 0.02}, "thumb: unknown parameter 'ha'; did you mean 'hA'?"),
        ({**TWO, 'ha': 0.02}, "unknown parameter 'ha'; did you mean 'hA'?"),
        ({**TWO, 'thumb.hA': 99.0}, "thumb: parameter 'hA' is 99; expected 1e-05 to 10 W/K"),
        ({**TWO, 'thumb.effects': ['kreep']}, "thumb: parameter 'effects': unknown effect 'kreep'; did you mean"),
        ({**TWO, 'thumb.rate_hz': 50.0}, "thumb: parameter 'rate_hz' is the whole node's: write it without 'thumb.'"),
        ({**TWO, 'joint_name': 'x'}, "parameter 'joint_name' is one muscle's: write 'thumb.joint_name'"),
        ({'joint_name': ''}, "parameter 'joint_name' is ''; expected the name of a joint, or leave it out"),
        ({**TWO, 'index.joint_name': ' '}, "index: parameter 'joint_name' is ''"),
        ({**TWO, 'index.joint_name': 'thumb'}, "joint_name: 'thumb' stands there twice"),
        ({'muscles': ['thumb', 'thumb']}, "parameter 'muscles': 'thumb' stands there twice"),
        ({'muscles': 'thumb'}, "parameter 'muscles' is 'thumb'; expected a list of names, such as [thumb, index]"),
        ({'muscles': ['1st']}, "parameter 'muscles': '1st' is no name for topics; expected letters"),
        ({'muscles': ['creep']}, "parameter 'muscles': 'creep' is the name of an effect"),
        ({'joints': ['knuckle']}, "parameter 'joints' needs 'muscles'"),
        ({**JOINT, 'knuckle.agonist': 'thum'}, "knuckle: parameter 'agonist' is 'thum', no muscle; did you mean"),
        ({**JOINT, 'knuckle.agonist': 'index'}, "knuckle: parameter 'antagonist': 'index' already pulls at 'knuckle'"),
        ({**JOINT, 'knuckle.radius': 0.01}, "knuckle: unknown parameter 'radius'; did you mean 'radius_m'?"),
        ({**JOINT, 'thumb.end': 'spring'}, "thumb: parameter 'end' is 'spring', but a joint holds its end"),
        ({**JOINT, 'joints': ['thumb']}, "parameter 'joints': 'thumb' stands there twice"),
    ],
)
def test_a_mistake_is_answered_by_one_line_that_helps(given, line):
    with pytest.raises(BadInput) as caught:
        read_plan(given, SIM)
    assert line in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.processes
def test_processes_given_a_mistake_end_with_2_and_one_line(tmp_path):
    (tmp_path / 'two.yaml').write_text('/**:\n  ros__parameters:\n    muscles: [thumb, index]\n    joints: [knuckle]\n')
    cases = {  # both at once: their start takes longest
        'sim_node': (['-p', 'thum.hA:=0.02', '-p', 'muscles:=[thumb, index]'], "unknown muscle 'thum'; did you mean"),
        'controller_node': (['--params-file', 'two.yaml'], "knuckle: parameter 'agonist' is '', no muscle; known:"),
    }
    started = {
        name: subprocess.Popen(
            [sys.executable, '-m', f'tcp_muscle_ros.nodes.{name}', '--ros-args', *arguments],
            cwd=tmp_path,
            env={**os.environ, 'PYTHONPATH': ':'.join(filter(None, sys.path))},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for name, (arguments, _) in cases.items()
    }
    for name, process in started.items():
        said, _ = process.communicate(timeout=120)
        assert process.returncode == 2, said
        # Where the model is not compiled yet, its progress is told first.
        mistake = [line for line in said.splitlines() if not line.startswith('[INFO]')]
        assert len(mistake) == 1 and cases[name][1] in mistake[0], said


# A hand


class Hand:
    """Sixteen muscles in one sim_node, and what it says of them."""

    def __init__(self, bench):
        self.bench = bench
        self.temperatures = {name: bench.listen(f'/hand/{name}/temperature', Temperature) for name in NAMES}
        self.currents = {name: bench.listen(f'/hand/{name}/current') for name in NAMES}
        self.joints = bench.listen('/hand/joint_states', JointState)
        self.diagnostics = bench.listen('/diagnostics', DiagnosticArray)
        self.program = bench.start(
            'sim_node', 'hand', '--params-file', str(HAND),
            **{'ring_flexor.derate_temperature_c': 25.0, 'ring_flexor.max_temperature_c': 26.0},
            **{'index_flexor.hA': 0.03, 'little_flexor.start_enabled': False},
        )  # fmt: skip

    def until(self, condition, otherwise, patience=30.0):
        return self.bench.until(condition, otherwise, patience)

    def flowing(self, name):
        return bool(self.currents[name]) and self.currents[name].last.data > 0.0

    def status(self, name):
        """What diagnostics said last of a muscle."""
        found = [
            status
            for _, array in list(self.diagnostics)
            for status in array.status
            if status.name == f'/hand/sim_node/{name}'
        ]
        return found[-1] if found else DiagnosticStatus()

    def commander(self, name, value):
        return self.bench.repeating(self.bench.speaker(f'/hand/{name}/current_command'), value)

    def call(self, kind, service, **fields):
        return self.bench.call(kind, f'/hand/sim_node/{service}', **fields)


@pytest.fixture(scope='module')
def hand(bench):
    made = Hand(bench)
    made.until(lambda: all(made.temperatures.values()) and made.joints, 'a muscle says nothing', 120.0)
    yield made
    made.program.kill()


@pytest.mark.processes
def test_every_muscle_speaks_every_tick_with_one_stamp_and_one_message_holds_all_joints(hand):
    # From here on: what was lost before it would be missed again at each further attempt.
    begun = {name: len(heard) for name, heard in hand.temperatures.items()}
    hand.until(lambda: all(len(h) > begun[n] + 60 for n, h in hand.temperatures.items()), 'too few ticks')
    assert hand.joints.last.name == NAMES
    assert len(hand.joints.last.position) == len(hand.joints.last.effort) == 16
    ticks = [{stamp(m) for _, m in list(heard)[begun[n] + 5 :]} for n, heard in hand.temperatures.items()]
    newest = min(max(stamps) for stamps in ticks)
    oldest = max(min(stamps) for stamps in ticks)
    # Nothing is lost between the first and the last tick that all have.
    shared = {moment for moment in ticks[0] if oldest <= moment <= newest}
    assert len(shared) > 30 and all(shared <= stamps for stamps in ticks)
    assert hand.temperatures['ring_flexor'].last.header.frame_id == 'ring_flexor_moving_end'


@pytest.mark.processes
def test_values_of_one_muscle_are_its_own_and_can_be_changed(hand):
    load = dict(zip(hand.joints.last.name, hand.joints.last.effort, strict=True))
    assert load['thumb_flexor'] == 0.8 and load['thumb_extensor'] == 0.588399
    names = ['thumb_flexor.load_n', 'index_flexor.hA', 'ring_flexor.hA']
    values = hand.call(GetParameters, 'get_parameters', names=names).values
    assert [value.double_value for value in values] == [0.8, 0.03, 0.01933]

    def change(name, value):
        parameters = [Parameter(name, value=value).to_parameter_msg()]
        return hand.call(SetParametersAtomically, 'set_parameters_atomically', parameters=parameters).result

    assert change('index_extensor.force_quantum_n', 0.1).successful
    hand.until(lambda: abs(hand.joints.last.effort[NAMES.index('index_extensor')] - 0.6) < 1e-9, 'not felt')
    assert hand.joints.last.effort[NAMES.index('index_abductor')] == 0.588399
    refused = change('index_extensor.derate_temperature_c', 120.0)
    assert not refused.successful and refused.reason.startswith('index_extensor: derating must begin below')


@pytest.mark.processes
def test_a_commander_that_falls_silent_stops_its_own_muscle_only(hand):
    with hand.commander('middle_flexor', 0.2):
        with hand.commander('index_flexor', 0.15):
            hand.until(lambda: hand.flowing('middle_flexor') and hand.flowing('index_flexor'), 'no current')
        silent = hand.until(lambda: not hand.flowing('index_flexor'), 'the watchdog does not bite')
        hand.until(lambda: hand.status('index_flexor').message.startswith('timed out'), 'not said')
        hand.until(lambda: len(hand.currents['middle_flexor'].since(silent)) > 20, 'the other one says nothing')
        assert {message.data for message in hand.currents['middle_flexor'].since(silent)} == {0.2}
        for name in ('middle_flexor', 'thumb_flexor'):
            assert hand.status(name).message.startswith('enabled')
    spoke = {name for name in NAMES if any(hand.currents[name].values)}
    assert spoke == {'middle_flexor', 'index_flexor'}


@pytest.mark.processes
def test_a_fault_latches_on_its_own_muscle_and_services_are_for_one_or_for_all(hand):
    ambient = hand.bench.speaker('/hand/ring_flexor/ambient_temperature', Temperature)
    with hand.commander('ring_flexor', 0.1) as change, hand.commander('middle_flexor', 0.2):
        hot, cool = Temperature(temperature=60.0), Temperature(temperature=23.0)
        hand.bench.insist(ambient, hot, lambda: hand.status('ring_flexor').level == DiagnosticStatus.ERROR, 'no fault')
        hand.until(lambda: hand.flowing('middle_flexor'), 'the other one stops')
        assert not hand.flowing('ring_flexor') and 'ring_flexor: fault latched' in hand.program.said()
        assert 'ring_flexor: the cause is still there' in hand.call(Trigger, 'ring_flexor/clear_fault').message
        change(0.0)
        hand.bench.insist(
            ambient, cool, lambda: hand.temperatures['ring_flexor'].last.temperature < 60.0, 'it does not cool'
        )
        assert hand.call(Trigger, 'ring_flexor/reset').message == 'ring_flexor: reset: at rest at 23 degC'
        hand.until(lambda: hand.call(Trigger, 'clear_fault').success, 'not cleared')
        assert hand.call(SetBool, 'middle_flexor/enable', data=False).message == 'disabled, 0 A'
        hand.until(lambda: not hand.flowing('middle_flexor'), 'a disabled one flows')
    with hand.commander('little_flexor', 0.1):
        assert not hand.flowing('little_flexor'), 'disabled at the start'
        assert hand.call(SetBool, 'enable', data=True).message == 'enabled'
        hand.until(lambda: hand.flowing('little_flexor'), 'not enabled')


@pytest.mark.processes
def test_the_controller_moves_the_muscles_it_is_told_to(bench, hand):
    hand.call(Trigger, 'reset')
    controller = bench.start('controller_node', 'hand', '--params-file', str(HAND))
    setpoint = bench.speaker('/hand/index_flexor/displacement_setpoint')
    commands = bench.speaker('/hand/joint_commands', JointState)
    setpoint.publish(Float64(data=0.002))
    commands.publish(JointState(name=['middle_flexor', 'nobody'], position=[0.003, 1.0]))
    place = {name: NAMES.index(name) for name in NAMES}

    def at(name, target):
        return abs(hand.joints.last.position[place[name]] - target) < 1e-4

    hand.until(lambda: at('index_flexor', 0.002) and at('middle_flexor', 0.003), 'not reached')
    moved = {name for name, x in zip(NAMES, hand.joints.last.position, strict=True) if abs(x) > 5e-5}
    assert moved <= {'index_flexor', 'middle_flexor', 'ring_flexor', 'little_flexor'}  # the last two still cool
    assert controller.end(2) == 0
    hand.until(lambda: not any(hand.flowing(name) for name in NAMES), 'a current stays on')


# A joint


@pytest.mark.processes
def test_two_muscles_bring_a_joint_to_an_angle_with_a_co_contraction_and_stop_with_its_feedback(bench):
    file = ['--params-file', str(CONFIG / 'antagonist.yaml')]
    angle = bench.listen('/arm/knuckle/angle')
    joints = bench.listen('/arm/joint_states', JointState)
    commands = {name: bench.listen(f'/arm/{name}/current_command') for name in ('flexor', 'extensor')}
    sim = bench.start('sim_node', 'arm', *file, **{'flexor.k0': 26.0, 'extensor.hA': 0.023})
    bench.start('controller_node', 'arm', *file)
    setpoint, mean, torque = (
        bench.speaker(f'/arm/knuckle/{name}')
        for name in ('angle_setpoint', 'cocontraction_setpoint', 'external_torque')
    )
    mean.publish(Float64(data=0.7))
    setpoint.publish(Float64(data=0.3))

    def met(target):
        shown = dict(zip(joints.last.name, joints.last.effort, strict=True))
        tension = 0.5 * (shown['flexor'] + shown['extensor'])
        return abs(angle.last.data - target) < 0.01 and abs(tension - 0.7) < 0.01

    bench.until(lambda: angle and joints and met(0.3), 'not reached')
    assert joints.last.name == ['flexor', 'extensor', 'knuckle']
    assert joints.last.position[2] == pytest.approx(0.3, abs=0.02)
    assert joints.last.position[0] == pytest.approx(0.01 * joints.last.position[2])
    torque.publish(Float64(data=-1e-3))
    bench.until(lambda: angle.last.data < 0.2, 'the torque is not felt')
    bench.until(lambda: met(0.3), 'the torque is not met')
    assert joints.last.effort[2] == pytest.approx(1e-3, abs=2e-4)
    setpoint.publish(Float64(data=5.0))  # beyond the stop: refused
    sim.kill()
    bench.until(lambda: all(heard.last.data == 0.0 for heard in commands.values()), 'it drives a joint it cannot see')


@pytest.mark.processes
def test_a_joint_stops_while_a_muscle_does_not_take_its_current_and_goes_on_when_it_does(bench):
    """Disabled where the current is applied, of which the controller is not told: one muscle, then both."""
    file = ['--params-file', str(CONFIG / 'antagonist.yaml')]
    nodes = [bench.start(name, 'cut', *file) for name in ('sim_node', 'controller_node')]
    angle, diagnostics = bench.listen('/cut/knuckle/angle'), bench.listen('/diagnostics', DiagnosticArray)
    commands = {name: bench.listen(f'/cut/{name}/current_command') for name in ('flexor', 'extensor')}
    setpoint = bench.speaker('/cut/knuckle/angle_setpoint')

    def commanded(**wanted):
        return all(commands[name] and commands[name].last.data == value for name, value in wanted.items())

    def said(name):
        found = [s.message for _, a in list(diagnostics)[-20:] for s in a.status if s.name.endswith(f'ler_node/{name}')]
        return found[-1] if found else ''

    def enable(what, on):
        assert bench.call(SetBool, f'/cut/sim_node/{what}enable', data=on).success

    setpoint.publish(Float64(data=0.3))
    bench.until(lambda: angle and abs(angle.last.data - 0.3) < 0.01, 'not reached', 60.0)
    for what, currents in (('flexor/', {'flexor': 0.02, 'extensor': 0.0}), ('', {'flexor': 0.02, 'extensor': 0.02})):
        enable(what, False)
        bench.until(lambda currents=currents: commanded(**currents), 'the joint goes on', 20.0)
        why = 'flexor does not take its current: disabled or in fault'
        bench.until(lambda why=why: said('knuckle') == why and why in said('flexor'), 'not said', 5.0)
        enable(what, True)
        bench.until(lambda: abs(angle.last.data - 0.3) < 0.01 and said('knuckle') == 'driven', 'it stays', 60.0)
    assert [node.end(2) for node in nodes] == [0, 0]


@pytest.mark.long
@pytest.mark.processes
def test_a_joint_takes_a_stiffness_instead_of_a_co_contraction(bench):
    """By the temperatures and tensions that the muscles then have; whichever of both was asked for last counts."""
    file = ['--params-file', str(CONFIG / 'antagonist.yaml')]
    nodes = [bench.start(name, 'stiff', *file) for name in ('sim_node', 'controller_node')]
    angle = bench.listen('/stiff/knuckle/angle')
    warmth = [bench.listen(f'/stiff/{name}/temperature', Temperature) for name in ('flexor', 'extensor')]
    forces = [bench.listen(f'/stiff/{name}/force') for name in ('flexor', 'extensor')]
    setpoint, mean, stiffness = (
        bench.speaker(f'/stiff/knuckle/{name}_setpoint') for name in ('angle', 'cocontraction', 'stiffness')
    )
    side = Side(Parameters.named('karami_tadesse_2017'), 0.4, 0.27, 373.15)

    def stiff():
        return 0.01**2 * sum(side.stiffness(heard.last.temperature + ZERO_CELSIUS) for heard in warmth)

    def there():
        return all((angle, *warmth, *forces)) and abs(angle.last.data - 0.3) < 0.01

    setpoint.publish(Float64(data=0.3))
    for wanted in (0.0038, 0.0043):
        stiffness.publish(Float64(data=wanted))
        bench.until(lambda wanted=wanted: there() and abs(stiff() / wanted - 1.0) < 0.01, 'another stiffness')
    stiffness.publish(Float64(data=-1.0))  # refused
    mean.publish(Float64(data=1.1))
    bench.until(lambda: there() and abs(0.5 * sum(f.last.data for f in forces) - 1.1) < 0.02, 'no co-contraction')
    assert [node.end(2) for node in nodes] == [0, 0]


@pytest.mark.processes
@pytest.mark.parametrize(
    ('given', 'line'),
    [
        ('none.urdf', "parameter 'description_file': cannot read none.urdf: No such file"),
        (str(HAND), 'the robot description is no XML'),
        (str(CONFIG.parent / 'urdf' / 'arm.urdf'), "no turning joint 'knuckle'; known: "),
    ],
)
def test_a_description_that_is_not_of_these_joints_is_one_line(given, line):
    command = ['-m', 'tcp_muscle_ros.nodes.controller_node', '--ros-args', '--params-file']
    command += [str(CONFIG / 'antagonist.yaml'), '-p', f'description_file:={given}']
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert line in done.stderr and 'Traceback' not in done.stderr
