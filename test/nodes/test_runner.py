"""``tcp_muscle run`` against a simulated muscle: on time, recorded whole, ended at 0 A by whatever goes wrong."""

import json
import signal

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray

from tcp_muscle_ros.recording.bag import read_bag

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


def played(bench, folder, *more, duration=1.0, load='', namespace='played', name='bag'):
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
    )


def ended(bench, program, code):
    """Wait for the exit code, which may be that of a refusal."""
    bench.programs.remove(program)  # the bench takes other codes than 0 for an accident
    bench.until(lambda: program.process.poll() is not None, f'does not end: {program.said()}', 60.0)
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


def test_two_commanders_are_refused_and_both_nodes_say_so(bench, muscle, tmp_path):
    controller = bench.start('controller_node', 'played')
    bench.until(lambda: muscle.current.subscription and bench.node.count_publishers('/played/current_command'), 'none')
    assert '/played/controller_node commands this muscle too' in ended(bench, played(bench, tmp_path, '--yes'), 2)
    assert not (tmp_path / 'bag').exists()
    second = bench.speaker('/played/power_command')

    def told(node):
        return any(
            status.name == f'/played/{node}' and 'several commanders: /bench, /played/controller_node' in status.message
            for _, array in muscle.diagnostics[-20:]
            for status in array.status
        )

    for node in ('sim_node', 'controller_node'):
        bench.until(lambda node=node: told(node), f'{node} says nothing of a second commander')
    bench.node.destroy_publisher(second)
    controller.end(signal.SIGINT)


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
    muscle.kill()
    assert 'for 1.0 s' in ended(bench, program, 2)
    for name in ('bag', 'bag_stopped_1'):
        kept = read_bag(tmp_path / name)
        assert not kept.notes and kept['current_command'].value[-1] == 0.0
