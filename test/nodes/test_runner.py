"""``tcp_muscle run`` against a simulated muscle: on time, recorded whole, ended at 0 A by whatever goes wrong."""

import json
import os
import pty
import re
import signal
import time

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger

from tcp_muscle_ros.nodes.runner import speaks_for
from tcp_muscle_ros.nodes.topics import LEASE, REMEMBERED
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.tool import main

pytestmark = pytest.mark.processes

PROTOCOL = """
rate_hz: 100
input: current
segments:
  - {duration_s: 0.5, value: 0.1}
  - {duration_s: %s, value: 0.2%s}
"""


@pytest.fixture(scope='module')
def muscle(bench):
    class Muscle:
        program = bench.start('sim_node', 'played')
        current = bench.listen('/played/current')
        diagnostics = bench.listen('/diagnostics', DiagnosticArray)

    bench.until(lambda: Muscle.current, 'sim_node publishes nothing', 120.0)
    return Muscle


def played(bench, folder, *more, duration=1.0, load='', namespace='played', name='bag', stdin=None):
    """``tcp_muscle run`` as a process, begun."""
    path = folder / 'protocol.yaml'
    path.write_text(PROTOCOL % (duration, load))
    return bench.run(
        [
            '-m',
            'tcp_muscle_ros.tool',
            'run',
            str(path),
            '--output',
            str(folder / name),
            '--namespace',
            namespace,
            *more,
        ],
        'run',
        stdin,
    )


def ended(bench, program, code):
    """Wait for the exit code, which may be that of a refusal."""
    if program in bench.programs:
        bench.programs.remove(program)  # the bench takes other codes than 0 for an accident
    try:
        bench.until(lambda: program.process.poll() is not None, f'does not end: {program.said()}', 60.0)
    finally:
        bench.kill([program])  # one that plays on would be met by the next attempt, which nobody ends
    assert program.process.returncode == code, program.said()
    assert 'Traceback' not in program.said()
    return program.said()


def test_a_protocol_is_played_and_recorded_with_the_lateness_of_each_command(bench, muscle, tmp_path):
    ended(bench, played(bench, tmp_path, '--yes', load=', load_n: 0.3'), 0)
    recording = read_bag(tmp_path / 'bag', channels={'force': '/played/command_lateness'})
    command, current = recording['current_command'], recording['current']
    assert command.value.tolist()[:150] == [0.1] * 50 + [0.2] * 100
    assert set(command.value[150:]) == {0.0}
    assert recording['load'].value[-1] == 0.3
    assert current.value[-1] == 0.0 and current.value.max() == 0.2
    assert recording.known['protocol'] == 'protocol.yaml'
    assert len(recording['force']) == 150
    assert 0.0 <= np.median(recording['force'].value) < 2e-3
    log = json.loads((tmp_path / 'bag.run.json').read_text())['parts']['1']
    assert log['complete'] and log['commands'] == 150
    said = ended(bench, played(bench, tmp_path, '--yes', '--resume', load=', load_n: 0.3'), 0)
    assert 'all of it is done already' in said
    assert log['lateness_s']['p50'] == pytest.approx(np.median(recording['force'].value), abs=1e-4)


def test_a_sensor_on_a_topic_of_its_own_is_recorded_too_and_nothing_is_played_where_it_is_silent(
    bench, muscle, tmp_path
):
    laser = bench.node.create_publisher(Float64, '/laser/height', 10)
    timer = bench.node.create_timer(0.02, lambda: laser.publish(Float64(data=7.0)))
    ended(bench, played(bench, tmp_path, '--yes', '--topic', '/laser/height', name='with'), 0)
    recording = read_bag(tmp_path / 'with', channels={'displacement': '/laser/height'})
    assert len(recording['displacement']) > 50 and set(recording['displacement'].value) == {7.0}
    said = ended(bench, played(bench, tmp_path, '--yes', '--topic', '/laser/heigth', name='without'), 2)
    assert 'nothing came on /laser/heigth within 10 s' in said and 'did you mean /laser/height?' in said
    assert set(read_bag(tmp_path / 'without')['current'].value) == {0.0}
    bench.node.destroy_timer(timer)
    bench.node.destroy_publisher(laser)


def test_a_run_is_replaced_only_by_force_and_only_by_one_that_is_complete(bench, muscle, tmp_path):
    for kept in ('bag', 'bag.run.json'):
        (tmp_path / kept).mkdir() if kept == 'bag' else (tmp_path / kept).write_text('old')
    (tmp_path / 'bag' / 'bag_0.mcap').write_text('old')
    (tmp_path / 'bag' / 'metadata.yaml').write_text('old')
    assert 'exists already and is not overwritten' in ended(bench, played(bench, tmp_path, '--yes'), 2)
    assert (tmp_path / 'bag' / 'metadata.yaml').read_text() == (tmp_path / 'bag.run.json').read_text() == 'old'
    ended(bench, played(bench, tmp_path, '--yes', '--force'), 0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['bag', 'bag.run.json', 'protocol.yaml']
    assert len(read_bag(tmp_path / 'bag')['current_command']) >= 150


def test_ctrl_c_ends_it_with_zero_and_a_resumed_run_plays_the_part_again(bench, muscle, tmp_path):
    program = played(bench, tmp_path, '--yes', duration=30.0)
    bench.until(lambda: muscle.current.last.data == 0.2, 'nothing flows')
    program.process.send_signal(signal.SIGINT)
    assert 'interrupted, 0 A' in ended(bench, program, 130)
    bench.until(lambda: muscle.current.last.data == 0.0, 'the current stays on', 2.0)
    kept = read_bag(tmp_path / 'bag')
    assert not kept.notes and kept['current_command'].value[-1] == 0.0
    assert not json.loads((tmp_path / 'bag.run.json').read_text())['parts']['1']['complete']
    said = ended(bench, played(bench, tmp_path, '--yes', '--resume', duration=2.0), 2)
    assert 'of another protocol' in said


def test_a_person_hangs_the_loads_and_a_run_goes_on_with_the_part_that_is_not_done(bench, muscle, tmp_path):
    """At a terminal: each load is asked for before anything flows; who leaves in the middle goes on there later."""
    person, terminal = pty.openpty()
    asked = {'first': 'hang 31 g (0.3 N), press Enter', 'second': 'hang 61 g (0.6 N), press Enter'}
    loads = """
  - {duration_s: 0.5, value: 0.05, load_n: 0.3}
  - {duration_s: 0.5, value: 0.06, load_n: 0.6}"""
    path = tmp_path / 'loads.yaml'
    path.write_text('rate_hz: 100\ninput: current\nsegments:' + loads)

    def begun(*more):
        command = ['-m', 'tcp_muscle_ros.tool', 'run', str(path), '--output', str(tmp_path / 'bag'), *more]
        return bench.run([*command, '--namespace', 'played'], 'run', terminal)

    def flows():
        return muscle.current.last.data > 0.0

    program = begun()
    bench.until(lambda: asked['first'] in program.said(), 'nobody is asked', 60.0)
    assert not flows()
    os.write(person, b'\n')
    bench.until(lambda: asked['second'] in program.said(), 'the second load is not asked for', 60.0)
    assert not flows()
    os.write(person, b'\x04')  # the person leaves: end of the input
    assert 'nobody is there to change the load' in ended(bench, program, 2)
    first = (tmp_path / 'bag' / 'part_1' / 'metadata.yaml').stat().st_mtime_ns
    assert not (tmp_path / 'bag' / 'part_2').exists()

    program = begun('--resume')
    bench.until(lambda: asked['second'] in program.said(), 'the second load is not asked for', 60.0)
    assert asked['first'] not in program.said()
    os.write(person, b'\n')
    ended(bench, program, 0)
    assert (tmp_path / 'bag' / 'part_1' / 'metadata.yaml').stat().st_mtime_ns == first
    for part, load, current in ((1, 0.3, 0.05), (2, 0.6, 0.06)):
        kept = read_bag(tmp_path / 'bag' / f'part_{part}')
        assert kept.known['part'] == part and kept.known['load_n'] == load
        assert kept['current_command'].value.max() == current and kept['current'].value[-1] == 0.0
    os.close(person)
    os.close(terminal)


def test_two_commanders_are_refused_and_both_nodes_say_so(bench, muscle, tmp_path):
    controller = bench.start('controller_node', 'played')
    bench.until(lambda: muscle.current.subscription and bench.node.count_publishers('/played/current_command'), 'none')
    assert '/played/controller_node commands this muscle too' in ended(bench, played(bench, tmp_path, '--yes'), 2)
    assert not (tmp_path / 'bag').exists()
    second = bench.speaker('/played/power_command')

    def told(node):
        return any(
            status.name == f'/played/{node}'
            and 'several nodes command it: /bench, /played/controller_node' in status.message
            for _, array in muscle.diagnostics[-20:]
            for status in array.status
        )

    for node in ('sim_node', 'controller_node'):
        bench.until(lambda node=node: told(node), f'{node} says nothing of a second commander')
    bench.node.destroy_publisher(second)
    controller.end(signal.SIGINT)


def test_a_second_run_is_refused_and_the_first_goes_on(bench, muscle, tmp_path):
    """Both have one name."""
    first = played(bench, tmp_path, '--yes', duration=300.0)
    bench.until(lambda: muscle.current.last.data == 0.2, 'nothing flows')
    second = played(bench, tmp_path, '--yes', duration=300.0, name='second')
    said = ended(bench, second, 2)
    assert 'another /played/protocol_runner commands this muscle too; stop it first' in said
    assert not (tmp_path / 'second').exists()
    time.sleep(REMEMBERED - LEASE + 5.0)  # in which the first would end, if it took the second for one that stays
    assert muscle.current.last.data == 0.2
    first.process.send_signal(signal.SIGINT)
    assert 'interrupted, 0 A' in ended(bench, first, 130)


@pytest.mark.long
def test_a_driver_that_names_another_commander_is_believed_before_the_graph_shows_it(bench, muscle, tmp_path):
    driver = bench.speaker('/diagnostics', DiagnosticArray)
    facts = {'current_limit_a': '0.27', 'commanded_by': '/elsewhere/arm, /played/protocol_runner'}
    values = [KeyValue(key=key, value=value) for key, value in facts.items()]
    array = DiagnosticArray(status=[DiagnosticStatus(name='/played/driver', message='enabled', values=values)])
    program = played(bench, tmp_path, '--yes')

    def ends():
        driver.publish(array)
        return program.process.poll() is not None

    bench.until(ends, 'it is played', 60.0)
    assert '/elsewhere/arm commands this muscle too' in ended(bench, program, 2)
    assert not (tmp_path / 'bag').exists()
    bench.node.destroy_publisher(driver)


def test_a_muscle_that_does_not_take_the_commands_is_told_from_none(bench, tmp_path):
    """Each is waited for as long: both at once."""
    measured = [bench.node.create_publisher(Float64, f'/{name}/displacement', 10) for name in ('lone', 'deaf')]
    lasting = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    takes = bench.node.create_subscription(Float64, '/deaf/current_command', print, lasting)
    with bench.repeating(measured[0], 0.0), bench.repeating(measured[1], 0.0):
        lone, deaf = (played(bench, tmp_path, '--yes', namespace=name, name=name) for name in ('lone', 'deaf'))
        bench.programs.remove(deaf)  # it may end first
        said = ended(bench, lone, 2)
        assert 'a muscle is measured, but no node takes /lone/current_command' in said
        said = ended(bench, deaf, 2)
        assert '/bench takes /deaf/current_command with an incompatible QoS: ' in said
    bench.node.destroy_subscription(takes)
    for publisher in measured:
        bench.node.destroy_publisher(publisher)


@pytest.mark.long
def test_a_commander_without_a_name_is_waited_for_since_it_may_be_this_run_itself(bench, tmp_path):
    """So it was where a run was killed and begun anew: the driver knew the old one by name, the new one not yet.

    The muscle is this test's: measured once the run has found its driver, whose word nothing else precedes.
    """
    driver = bench.node.create_publisher(DiagnosticArray, '/diagnostics', 10)
    measured = bench.node.create_publisher(Temperature, '/spoken/temperature', 10)
    takes = bench.node.create_subscription(Float64, '/spoken/current_command', lambda _: None, 10)

    def says(commanders):
        values = [KeyValue(key='current_limit_a', value='0.27'), KeyValue(key='commanded_by', value=commanders)]
        status = DiagnosticStatus(name='/spoken/driver', message='enabled', values=values)
        return DiagnosticArray(status=[status])

    with bench.repeating(driver, says('/spoken/protocol_runner, an unknown node')) as say:
        program = played(bench, tmp_path, '--yes', namespace='spoken')
        bench.until(lambda: bench.node.count_publishers('/spoken/current_command'), 'it does not begin', 60.0)
        time.sleep(2.0)  # the driver is heard by then
        with bench.repeating(measured, Temperature(temperature=23.0)):
            time.sleep(5.0)
            assert program.process.poll() is None, program.said()
            assert 'part 1' not in program.said()
            say(says('/spoken/protocol_runner'))
            ended(bench, program, 0)
    for publisher in (driver, measured):
        bench.node.destroy_publisher(publisher)
    bench.node.destroy_subscription(takes)


@pytest.mark.long
def test_in_lockstep_a_run_gives_the_bag_that_offline_gives(bench, tmp_path):
    """What is commanded by a tick flows from the next: the bag is one tick longer at its beginning."""
    sim = bench.start('sim_node', 'hurried', real_time_factor=0.0, lockstep_nodes=1)
    ended(bench, played(bench, tmp_path, '--yes', duration=30.0, load=', load_n: 0.3', namespace='hurried'), 0)
    assert main(['simulate', str(tmp_path / 'protocol.yaml'), '--output', str(tmp_path / 'offline')]) == 0
    live = read_bag(tmp_path / 'bag', channels={'force': '/hurried/command_lateness'})
    offline = read_bag(tmp_path / 'offline')
    ticks = len(offline['current'].value) - 1
    assert ticks == 3050 and np.abs(live['force'].value).max() < 1e-9
    assert live['current'].value[1 : ticks + 1].tolist() == offline['current'].value[:ticks].tolist()
    for name in ('temperature', 'resistance', 'displacement'):  # 1e-12: what the length of a tick is rounded to
        np.testing.assert_allclose(live[name].value[1 : ticks + 1], offline[name].value[:ticks], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(np.diff(live['temperature'].time), 0.01, rtol=1e-6)
    stopped = played(bench, tmp_path, '--yes', duration=1000.0, namespace='hurried', name='stopped')
    bench.until((tmp_path / 'stopped').exists, 'nothing is recorded')
    sim.process.send_signal(signal.SIGINT)
    assert 'stopped, 0 A: the simulation stands still' in ended(bench, stopped, 2)


def test_a_fault_of_the_driver_and_a_muscle_hotter_than_the_rig_allows_end_it(bench, tmp_path):
    """It loses a tenth of the heat that the model foresees, and warms quickly."""
    current = bench.listen('/faulty/current')
    rig = tmp_path / 'rig.yaml'
    rig.write_text('limits: {highest_temperature_c: 56, loads_by: rig}\n')
    bench.start('sim_node', 'faulty', hA=0.002, C=0.06)
    bench.until(lambda: current, 'sim_node publishes nothing', 120.0)
    hot = played(bench, tmp_path, '--rig', str(rig), duration=60.0, namespace='faulty', name='hot')
    assert re.search(r'stopped, 0 A: the temperature is (5[6-9]|6\d)\.', ended(bench, hot, 2))
    bench.until(lambda: current.last.data == 0.0, 'the current stays on', 2.0)
    waiting = played(bench, tmp_path, '--yes', duration=60.0, namespace='faulty', name='waiting')
    how_warm = re.compile(r'waiting for the muscle to be cold: \d\d\.\d degC, room 23\.0 degC')
    bench.until(lambda: how_warm.search(waiting.said()), 'it waits in silence')
    waiting.process.send_signal(signal.SIGINT)
    assert 'interrupted before anything was played' in ended(bench, waiting, 130)
    assert bench.call(Trigger, '/faulty/sim_node/reset').success  # cold again
    program = played(bench, tmp_path, '--yes', duration=60.0, namespace='faulty', name='fault')
    bench.until(lambda: current.last.data == 0.2, 'nothing flows')
    limits = {'derate_temperature_c': 10.0, 'max_temperature_c': 15.0}
    change = [Parameter(name, value=value).to_parameter_msg() for name, value in limits.items()]
    assert bench.call(SetParametersAtomically, '/faulty/sim_node/set_parameters_atomically', parameters=change)
    assert 'stopped, 0 A: /faulty/sim_node: fault, over-temperature' in ended(bench, program, 2)
    for name in ('hot', 'fault'):
        kept = read_bag(tmp_path / name)
        assert not kept.notes and kept['current_command'].value[-1] == 0.0


def test_an_investigation_asks_the_driver_how_much_current_it_allows(bench, tmp_path):
    """Its protocols are made gentler by tenths until they are allowed; one that is resumed asks again."""
    current = bench.listen('/weak/current')
    bench.start('sim_node', 'weak', current_limit_a=0.15)
    bench.until(lambda: current, 'sim_node publishes nothing', 120.0)
    first, found = tmp_path / 'first.yaml', tmp_path / 'found'
    first.write_text(PROTOCOL % (60.0, ''))
    command = ['investigate', '--first', str(first), '--namespace', 'weak', '--yes', '--output', str(found)]
    for allowed, steps, more in ((0.15, 3, []), (0.19, 1, ['--resume'])):
        change = [Parameter('current_limit_a', value=allowed).to_parameter_msg()]
        assert bench.call(SetParametersAtomically, '/weak/sim_node/set_parameters_atomically', parameters=change)
        program = bench.run(['-m', 'tcp_muscle_ros.tool', *command, *more], 'investigate')
        flows = pytest.approx(0.2 * 0.9**steps)
        bench.until(lambda flows=flows: current.last.data == flows, 'nothing flows', 120.0)
        program.process.send_signal(signal.SIGINT)
        assert 'interrupted' in ended(bench, program, 130)


def test_a_commander_that_comes_meanwhile_or_a_muscle_that_dies_ends_it(bench, tmp_path):
    muscle = bench.start('sim_node', 'mortal')
    current = bench.listen('/mortal/current')
    bench.until(lambda: current, 'sim_node publishes nothing', 120.0)
    program = played(bench, tmp_path, '--yes', duration=30.0, namespace='mortal')
    bench.until(lambda: current.last.data == 0.2, 'nothing flows')
    second = bench.speaker('/mortal/voltage_command')
    assert 'stopped, 0 A: /bench commands this muscle too' in ended(bench, program, 2)
    bench.node.destroy_publisher(second)
    program = played(bench, tmp_path, '--yes', '--resume', duration=30.0, namespace='mortal')
    bench.until(lambda: current.last.data == 0.2, 'nothing flows')
    assert bench.call(SetBool, '/mortal/sim_node/enable', data=False).success
    assert 'stopped, 0 A: /mortal/sim_node: disabled' in ended(bench, program, 2)
    assert bench.call(SetBool, '/mortal/sim_node/enable', data=True).success
    program = played(bench, tmp_path, '--yes', '--resume', duration=30.0, namespace='mortal')
    bench.until(lambda: current.last.data == 0.2, 'nothing flows')
    muscle.kill()
    assert re.search(r'stopped, 0 A: no \w+ for \d\.\d s', ended(bench, program, 2))
    for name in ('bag', 'bag_stopped_1', 'bag_stopped_2'):
        kept = read_bag(tmp_path / name)
        assert not kept.notes and kept['current_command'].value[-1] == 0.0


def test_a_commander_that_comes_while_a_hot_muscle_cools_ends_it(bench, tmp_path):
    bench.start('sim_node', 'hot', initial_temperature_c=80.0, hA=0.002)
    program = played(bench, tmp_path, '--yes', namespace='hot')
    bench.until(lambda: 'to be cold' in program.said(), 'it does not wait', 120.0)
    second = bench.speaker('/hot/current_command')
    assert '/bench commands this muscle too; stop it first' in ended(bench, program, 2)
    bench.node.destroy_publisher(second)


@pytest.mark.long
def test_a_muscle_that_dies_is_noticed_as_soon_after_a_person_took_long_to_hang_the_load(bench, tmp_path):
    """Nobody listens while a person is asked: that is no gap between two messages, five of which make a silence."""
    muscle, current = bench.start('sim_node', 'waiting'), bench.listen('/waiting/current')
    bench.until(lambda: current, 'sim_node publishes nothing', 120.0)
    reading, person = os.pipe()
    load = ', load_n: 0.6'  # after half a second under the usual one
    program = played(bench, tmp_path, duration=60.0, load=load, namespace='waiting', stdin=reading)
    bench.until(lambda: 'hang' in program.said(), 'nobody is asked', 60.0)
    time.sleep(3.0)  # five times that would be told
    os.write(person, b'\n\n')
    bench.until(lambda: current.last.data == 0.2, 'nothing flows')
    muscle.kill()
    assert re.search(r'stopped, 0 A: no \w+ for [1-4]\.\d s', ended(bench, program, 2))
    os.close(reading)
    os.close(person)


def test_a_muscle_among_several_of_a_node_in_a_namespace_says_its_limit(bench, tmp_path):
    current = bench.listen('/hand/thumb/current')
    bench.start('sim_node', 'hand', muscles=['thumb', 'index'], current_limit_a=0.15)
    bench.until(lambda: current, 'sim_node publishes nothing', 120.0)
    said = ended(bench, played(bench, tmp_path, '--yes', namespace='hand/thumb'), 2)
    assert 'above the limit of 0.15 A of /hand/sim_node/thumb' in said


@pytest.mark.parametrize(
    ('namespace', 'name', 'its'),
    [
        ('/', '/sim_node', True),
        ('/m', '/m/sim_node', True),
        ('/thumb', '/sim_node/thumb', True),
        ('/hand/thumb', '/hand/sim_node/thumb', True),
        ('/m', 'a driver', True),
        ('/m', '/sim_node', False),
        ('/', '/m/sim_node', False),
        ('/thumb', '/hand/sim_node/thumb', False),
        ('/hand/thumb', '/hand/sim_node/index', False),
        ('/hand/thumb', '/other/sim_node/thumb', False),
    ],
)
def test_whose_a_status_is(namespace, name, its):
    assert speaks_for(namespace, name) is its
