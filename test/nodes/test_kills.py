"""kill -9 at random instants of every process that there is, by the script that does it 200 times."""

from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

pytestmark = pytest.mark.processes

SCRIPT = Path(__file__).resolve().parents[2] / 'scripts' / 'kills.py'
KILLS = 20  # four of each process; about five seconds each


def test_after_kill_minus_9_nothing_heats_and_nothing_is_lost(bench, tmp_path):
    program = bench.run([str(SCRIPT), '--kills', str(KILLS), '--output', str(tmp_path / 'kills.md')], 'kills')
    bench.until(lambda: program.process.poll() is not None, f'does not end: {program.said()}', 1200.0)
    assert program.process.returncode == 0, program.said()
    assert f'**0 of {KILLS} did not hold.**' in (tmp_path / 'kills.md').read_text()
