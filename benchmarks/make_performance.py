"""Run every benchmark, show its tables, and put them into docs/performance.md.

    ./scripts/bench [--long] [--only NAME...]

Each runs in a process of its own, one after the other, so that nothing but itself is measured. ``--long`` waits for
every diagnosis however long it takes. A benchmark that fails keeps its old table, and the exit code says so.
"""

import argparse
import contextlib
import datetime
import importlib.metadata
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

from tcp_muscle_ros.report.marked import replace_marked

HERE = Path(__file__).resolve().parent
DOCUMENT = HERE.parent / 'docs' / 'performance.md'
NAMES = (
    'model', 'many_muscles', 'tick', 'node_rate', 'node_tick', 'lateness', 'twin', 'hand', 'bags', 'start_up', 'robot',
    'diagnosis',
)  # fmt: skip
SHORT = {'diagnosis': ['--limit', '90']}
PACKAGES = ('numpy', 'scipy', 'numba', 'rosbags', 'mcap-ros2-support', 'ros-rclpy')


def machine() -> str:
    """What the figures depend on: date, cores, load before the start, versions."""
    versions = [f'Python {platform.python_version()}']
    for package in PACKAGES:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            versions.append(f'{package} {importlib.metadata.version(package)}')
    cores = len(os.sched_getaffinity(0))
    return (
        f'{datetime.datetime.now(datetime.timezone.utc):%d %B %Y}, {platform.machine()}, {cores} cores, load average '
        f'before the start {os.getloadavg()[0]:.1f}; {", ".join(versions)}.'
    )


def run(name: str, arguments: list[str]) -> str | None:
    """The tables that a benchmark prints, shown as they come; None if it failed."""
    process = subprocess.Popen(
        [sys.executable, str(HERE / f'{name}.py'), *arguments], stdout=subprocess.PIPE, text=True
    )
    lines = []
    assert process.stdout is not None
    for line in process.stdout:
        print(line, end='', flush=True)
        lines.append(line)
    return ''.join(lines).strip() if process.wait() == 0 else None


def main() -> int:
    """Run them; returns the exit code."""
    parser = argparse.ArgumentParser(description='Run every benchmark and put its tables into docs/performance.md.')
    parser.add_argument('--long', action='store_true', help='wait for every diagnosis, however long it takes')
    parser.add_argument('--only', nargs='+', choices=NAMES, default=NAMES, metavar='NAME', help=', '.join(NAMES))
    given = parser.parse_args()
    begin = time.monotonic()
    about = machine()
    print(f'{about}\n')
    failed = []
    for name in given.only:
        tables = run(name, [] if given.long else SHORT.get(name, []))
        if tables is None:
            failed.append(name)
        else:
            replace_marked(DOCUMENT, name, tables)
        print(f'({name}: {time.monotonic() - begin:.0f} s since the start)\n', flush=True)
    if not failed and set(given.only) == set(NAMES):
        replace_marked(DOCUMENT, 'machine', about)
    for name in failed:
        print(f'bench: benchmarks/{name}.py failed, see above; its table stays the old one', file=sys.stderr)
    return 1 if failed else 0


if __name__ == '__main__':
    raise SystemExit(main())
