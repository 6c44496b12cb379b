"""How late `tcp_muscle run` sends its commands at 100 Hz, and how late a bare loop would be, at the same time.

    python benchmarks/lateness.py [--duration 60]

A simulated muscle, `run` with its recorder, and a loop that only sleeps until each command would be due: what the
machine makes late is late in both.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from side_by_side import show

RATE = 100.0  # Hz
CLOSE = 2e-3  # s
PROTOCOL = """
rate_hz: 100
input: current
segments:
  - {{duration_s: {0}, value: [0.0, 0.2]}}
"""


def bare(duration: float) -> list[float]:
    """How late (s) a loop is that does nothing but sleep."""
    begun = time.monotonic()
    found = []
    for k in range(round(duration * RATE)):
        due = begun + k / RATE
        time.sleep(max(due - time.monotonic(), 0.0))
        found.append(time.monotonic() - due)
    return found


def lateness(log: Path) -> tuple[float, dict[str, float]]:
    """The share of the commands within 2 ms, and percentiles (s), as `run` writes them down."""
    part = json.loads(log.read_text())['parts']['1']
    return part['within_2_ms'], part['lateness_s']


def main() -> None:
    """Measure both; print the table."""
    parser = argparse.ArgumentParser(description='How late the commands of tcp_muscle run are.')
    parser.add_argument('--duration', type=float, default=60.0, help='s measured')
    parser.add_argument('--domain', type=int, default=94, help='ROS_DOMAIN_ID')
    given = parser.parse_args()
    os.environ |= {'ROS_DOMAIN_ID': str(given.domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    with tempfile.TemporaryDirectory() as folder:
        protocol, bag = Path(folder) / 'protocol.yaml', Path(folder) / 'bag'
        protocol.write_text(PROTOCOL.format(given.duration))
        node = [sys.executable, '-m', 'tcp_muscle_ros.nodes.sim_node', '--ros-args', '--log-level', 'warn']
        muscle = subprocess.Popen(node)
        command = [sys.executable, '-m', 'tcp_muscle_ros.tool', 'run', str(protocol), '--output', str(bag), '--yes']
        try:
            playing = subprocess.Popen(command, stdout=subprocess.DEVNULL)
            while not bag.exists() and playing.poll() is None:
                time.sleep(0.05)
            found = sorted(bare(given.duration))
            if playing.wait(60.0):
                sys.exit('tcp_muscle run failed, see above')
            share, late = lateness(bag.with_name('bag.run.json'))
        finally:
            muscle.send_signal(signal.SIGINT)
            muscle.wait(30)
    floor = {'p50': found[len(found) // 2], 'p99': found[int(0.99 * (len(found) - 1))], 'max': found[-1]}
    within = sum(one <= CLOSE for one in found) / len(found)
    rows = [
        (name, f'{share_:.1%}', *(f'{1e3 * of[key]:.2f}' for key in ('p50', 'p99', 'max')))
        for name, share_, of in (('least: a loop that sleeps', within, floor), ('ours: tcp_muscle run', share, late))
    ]
    title = f'Commands of tcp_muscle run at {RATE:g} Hz, in the same {given.duration:g} s as a bare loop'
    load = ' '.join(f'{one:.1f}' for one in os.getloadavg())
    show(
        f'{title} (aim: 99 % within 2 ms on an idle machine; load average {load})',
        ('', 'within 2 ms', 'late p50, ms', 'p99, ms', 'most, ms'),
        rows,
    )


if __name__ == '__main__':
    main()
