"""How a process ends when something in it breaks: with the current off, and an exit code that says so."""

import signal

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

pytestmark = pytest.mark.processes

# sim_node with a fault of ours in it, that comes once current flows.
BROKEN = """
from tcp_muscle_ros.nodes import sim_muscle, sim_node
from tcp_muscle_ros.nodes.lifetime import run
called = 0
whole = {owner}.{method}
def broken(self, *arguments):
    global called
    one = getattr(self, 'muscles', [self])[0]
    called += one.safety.current > 0.0
    if called > {often}:
        raise ZeroDivisionError('on purpose')
    return whole(self, *arguments)
{owner}.{method} = broken
raise SystemExit(run(sim_node.SimNode, 'sim_node', ['sim_node', '--ros-args', '-r', '__ns:=/{method}']))
"""


# ``work`` is called by the thread of the ticks, ``facts`` by a callback.
@pytest.mark.parametrize(
    ('owner', 'method', 'often'), [('sim_node.SimNode', 'work', 20), ('sim_muscle.SimMuscle', 'facts', 0)]
)
def test_an_error_of_ours_turns_the_current_off_and_ends_with_1(bench, owner, method, often):
    program = bench.run(['-c', BROKEN.format(owner=owner, method=method, often=often)], method)
    current = bench.listen(f'/{method}/current')
    with bench.repeating(bench.speaker(f'/{method}/current_command'), 0.2):
        bench.until(lambda: 0.2 in current.values, 'no current', 120.0)
        assert program.process.wait(20) == 1
        bench.programs.remove(program)
        bench.until(lambda: current.last.data == 0.0, 'the current stays on', 2.0)
    assert 'ZeroDivisionError: on purpose' in program.said()
    assert program.said().count('Traceback') == 1, program.said()
    bench.forget(current)


def test_a_signal_while_the_model_is_still_being_made_ends_with_0(bench):
    slow = """
import time
from tcp_muscle_ros.nodes.lifetime import run
def make():
    print('making', flush=True)
    time.sleep(60.0)
raise SystemExit(run(make, 'sim_node', ['sim_node']))
"""
    program = bench.run(['-c', slow], 'slow')
    bench.until(lambda: 'making' in program.said(), 'it does not start', 120.0)
    assert program.end(signal.SIGTERM, signal.SIGTERM) == 0
    assert program.said() == 'making\n'
