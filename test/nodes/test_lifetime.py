"""How a process ends when something in it breaks: with the current off, and an exit code that says so."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from diagnostic_msgs.msg import DiagnosticArray

ROOT = Path(__file__).resolve().parents[2]
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


# A compiler that calls back from native code, where an exception is told and swallowed, and then lacks its answer.
COMPILER = """
import ctypes, time
from tcp_muscle_ros.nodes import lifetime
answers = []
@ctypes.CFUNCTYPE(None)
def call_back():
    time.sleep(30.0)
    answers.append(1)
def compile_ahead(say):
    say('1 of 1: a model')
    call_back()
    answers[0]
lifetime.is_compiled, lifetime.compile_ahead = (lambda: False), compile_ahead
raise SystemExit(lifetime.run(lambda: None, 'sim_node', ['sim_node']))
"""


def test_a_signal_in_the_middle_of_the_compiler_ends_with_0_and_no_traceback(bench):
    program = bench.run(['-c', COMPILER], 'compiler')
    bench.until(lambda: 'compiling, 1 of 1' in program.said(), 'it does not start', 120.0)
    assert program.end(signal.SIGINT) == 0
    assert 'Traceback' not in program.said()
    assert 'Exception ignored' not in program.said()


def test_what_a_signal_breaks_off_in_the_start_may_fail_in_its_own_way(bench):
    failing = """
import time
from tcp_muscle_ros.nodes.lifetime import run
def make():
    try:
        print('making', flush=True)
        time.sleep(60.0)
    except BaseException:
        raise RuntimeError('what was made is in pieces') from None
raise SystemExit(run(make, 'sim_node', ['sim_node']))
"""
    program = bench.run(['-c', failing], 'failing')
    bench.until(lambda: 'making' in program.said(), 'it does not start', 120.0)
    assert program.end(signal.SIGINT) == 0
    assert program.said() == 'making\n'


# sim_node with two muscles that refuse an input of a new name every tick, while a callback counts them slowly.
CROWDED = """
import math, time
from collections import Counter
from tcp_muscle_ros.nodes import safe_muscle, sim_node
from tcp_muscle_ros.nodes.lifetime import run
class Slow(Counter):
    def items(self):
        for pair in super().items():
            yield pair
            time.sleep(0.05)
class Refusing(sim_node.SimNode):
    def work(self, *arguments):
        super().work(*arguments)
        for muscle in self.muscles:
            muscle.within(f'input_{len(muscle.refused_inputs)}', math.nan, 0.0, 1.0, 'N')
safe_muscle.Counter = Slow
arguments = ['--ros-args', '-r', '__ns:=/crowded', '-p', 'muscles:=[thumb, index]', '-p', 'rate_hz:=50.0']
raise SystemExit(run(Refusing, 'sim_node', ['sim_node', *arguments]))
"""


def test_an_input_refused_while_the_diagnostics_are_made_ends_nothing(bench):
    diagnostics = bench.listen('/diagnostics', DiagnosticArray)
    program = bench.run(['-c', CROWDED], 'crowded')

    def told():
        return [
            value.value
            for _, array in list(diagnostics)
            for status in array.status
            for value in status.values
            if status.name == '/crowded/sim_node/thumb' and value.key == 'refused_inputs' and 'input_1 ' in value.value
        ]

    bench.until(lambda: len(told()) > 1, 'no diagnostics', 120.0)
    assert program.end(signal.SIGINT) == 0, program.said()
    bench.forget(diagnostics)


# Loaded by Python before all else: a signal comes as soon as rclpy is asked for.
WHILE_LOADING = """
import os, signal, sys
class Signal:
    def find_spec(self, name, *_):
        if name == 'rclpy':
            os.kill(os.getpid(), signal.%s)
sys.meta_path.insert(0, Signal())
"""


@pytest.mark.parametrize('number', ['SIGINT', 'SIGTERM'])
@pytest.mark.parametrize('node', ['sim_node', 'controller_node'])
@pytest.mark.parametrize('how', ['module', 'program'])
def test_a_signal_while_modules_are_loaded_ends_with_0(tmp_path, number, node, how):
    (tmp_path / 'sitecustomize.py').write_text(WHILE_LOADING % number)
    module, function = re.search(rf"'{node} = ([\w.]+):(\w+)'", (ROOT / 'setup.py').read_text()).groups()
    program = f'import sys; from {module} import {function}; sys.exit({function}())'
    done = subprocess.run(
        [sys.executable, *(['-m', f'tcp_muscle_ros.nodes.{node}'] if how == 'module' else ['-c', program])],
        env={**os.environ, 'PYTHONPATH': os.pathsep.join([str(tmp_path), *filter(None, sys.path)])},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_a_signal_before_the_callbacks_run_ends_with_0(bench):
    early = """
import gc, os, signal
from tcp_muscle_ros.nodes import sim_node
gc.freeze = lambda: os.kill(os.getpid(), signal.SIGINT)
raise SystemExit(sim_node.main(['sim_node', '--ros-args', '-r', '__ns:=/early', '--log-level', 'error']))
"""
    program = bench.run(['-c', early], 'early')
    assert program.process.wait(120) == 0, program.said()
    assert program.said() == ''
