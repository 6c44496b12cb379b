"""kill -9 at random instants of every process that there is, by the script that does it 200 times."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import domains
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

pytestmark = pytest.mark.processes

SCRIPT = Path(__file__).resolve().parents[2] / 'scripts' / 'kills.py'
KILLS = 20  # four of each process, one after another; about eight seconds each


# Without a bench and its turn: the processes wait more than they compute, and another module has the turn meanwhile.
def test_after_kill_minus_9_nothing_heats_and_nothing_is_lost(tmp_path):
    command = [sys.executable, str(SCRIPT), '--kills', str(KILLS), '--output', str(tmp_path / 'kills.md')]
    with domains.lent() as domain, (tmp_path / 'said').open('w') as said:
        environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain),
            'PYTHONPATH': os.pathsep.join(filter(None, sys.path)),
        }
        script = subprocess.Popen(
            command, env=environment, stdout=said, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            code = script.wait(1200.0)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(script.pid, signal.SIGKILL)  # it and what it started
    assert code == 0, (tmp_path / 'said').read_text()
    assert f'**0 of {KILLS} did not hold.**' in (tmp_path / 'kills.md').read_text()
