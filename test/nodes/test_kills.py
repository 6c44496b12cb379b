"""kill -9 at random instants of every process that there is, by the script that does it 200 times."""

import os
from pathlib import Path

import domains
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

pytestmark = pytest.mark.processes

SCRIPT = Path(__file__).resolve().parents[2] / 'scripts' / 'kills.py'
KILLS = 20  # four of each process; about five seconds each
LOOPBACK, MULTICAST = '0100007F', '0100FFEF'  # as the kernel writes them: 127.0.0.1, and the middleware's 239.255.0.1


def test_after_kill_minus_9_nothing_heats_and_nothing_is_lost(bench, tmp_path):
    program = bench.run([str(SCRIPT), '--kills', str(KILLS), '--output', str(tmp_path / 'kills.md')], 'kills')
    bench.until(lambda: program.process.poll() is not None, f'does not end: {program.said()}', 1200.0)
    assert program.process.returncode == 0, program.said()
    assert f'**0 of {KILLS} did not hold.**' in (tmp_path / 'kills.md').read_text()


@pytest.mark.skipif(not domains.OF_FAST_DDS, reason='the threads and the profile are those of Fast DDS')
def test_nodes_of_tests_reach_nobody_else_and_share_no_memory_that_a_killed_one_may_leave_locked(bench):
    program = bench.start('sim_node', 'by_itself')
    current = bench.listen('/by_itself/current')
    bench.until(lambda: current, 'sim_node publishes nothing', 120.0)
    process = Path(f'/proc/{program.process.pid}')
    threads = {(task / 'comm').read_text().strip() for task in (process / 'task').iterdir()}
    assert any(name.startswith('dds.udp') for name in threads), threads
    assert not any(name.startswith('dds.shm') for name in threads), threads
    sockets = {os.readlink(file)[8:-1] for file in (process / 'fd').iterdir() if os.readlink(file)[:8] == 'socket:['}
    rows = [row.split() for kind in ('udp', 'udp6') for row in (process / 'net' / kind).read_text().splitlines()[1:]]
    bound = {row[1].partition(':')[0] for row in rows if row[9] in sockets}
    assert bound and bound <= {LOOPBACK, MULTICAST}, bound
    program.kill()
    bench.forget(current)
