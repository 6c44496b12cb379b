"""A command whose model is not compiled yet says so instead of standing still."""

import os
import subprocess
import sys

import pytest

from tcp_muscle_ros.process.compiling import SAID

# One function in another, as numba tells of them, of so many seconds; then what is in the cache, which it does not.
COMPILED = """
import time
from numba.core.event import trigger_event
from tcp_muscle_ros.process.compiling import tell_of_compiling
tell_of_compiling(), tell_of_compiling()
for seconds in {seconds}:
    with trigger_event('numba:compile'), trigger_event('numba:compile'):
        time.sleep(seconds)
"""


@pytest.mark.parametrize(('seconds', 'said'), [((0.1, 0.2), ''), ((1.6, 1.6), f'{SAID}\n'), ((0.7, 0.7), f'{SAID}\n')])
def test_what_takes_long_is_told_once(seconds, said):
    done = subprocess.run(
        [sys.executable, '-c', COMPILED.format(seconds=seconds)], capture_output=True, text=True, check=True
    )
    assert done.stderr == said


# With no patience, for a small function takes no second.
SMALL = """
import numba
from tcp_muscle_ros.process import compiling
compiling._PATIENCE = 0.0
compiling.tell_of_compiling()
print(numba.njit(cache=True)(lambda x: 2.0 * x + 1.0)(3.0))
"""


def test_numba_tells_of_what_it_compiles_and_not_of_what_it_finds(tmp_path):
    (tmp_path / 'small.py').write_text(SMALL)
    environment = {**os.environ, 'NUMBA_CACHE_DIR': str(tmp_path / 'cache')}
    said = []
    for _ in range(2):
        command = [sys.executable, 'small.py']
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        assert done.stdout == '7.0\n'
        said.append(done.stderr)
    assert said == [f'{SAID}\n', '']


def test_a_command_that_computes_with_the_model_tells_of_it(tmp_path):
    """Asked in a process of its own: in this one somebody may have asked before."""
    protocol = tmp_path / 'protocol.yaml'
    protocol.write_text('{rate_hz: 10, input: current, segments: [{duration_s: 1, value: 0.1}]}\n')
    program = (
        'from tcp_muscle_ros.process import compiling\nfrom tcp_muscle_ros.tool import main\n'
        f"main(['simulate', '{protocol}', '--output', '{tmp_path / 'bag'}'])\nprint(len(compiling._teller))"
    )
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=True)
    assert done.stdout.endswith('\n1\n')
