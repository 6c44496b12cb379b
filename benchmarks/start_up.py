"""How long a start takes: sim_node until its first message, and the command line until its help.

    python benchmarks/start_up.py

The first message is seen by a subscriber that waits for it. `import rclpy` alone is what no ROS 2 node in Python can do
without. "Compiled ahead" is how set-up leaves the package (`python -m tcp_muscle_ros.muscle`); the last rows start with
an empty cache, as without that. Wall time, the median of five.
"""

import contextlib
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from side_by_side import show
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.topics import STATE_QOS

SIM = [sys.executable, '-m', 'tcp_muscle_ros.nodes.sim_node', '--ros-args', '--log-level', 'error']
DOMAIN = '93'


class FirstMessage:
    """Waits for the first message on ``force``."""

    def __init__(self) -> None:
        self._node = Node('first_message')
        self._seen = False
        self._node.create_subscription(Float64, 'force', self._see, STATE_QOS)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)

    def _see(self, _: Float64) -> None:
        self._seen = True

    def after(self, command: list[str], environment: dict[str, str]) -> float:
        """Seconds from the start of a process to its first message."""
        self._seen = False
        begin = time.perf_counter()
        process = subprocess.Popen(command, env=environment)
        try:
            while not self._seen:
                self._executor.spin_once(timeout_sec=0.05)
                if process.poll() is not None:
                    raise SystemExit('start_up.py: sim_node ended before its first message')
            return time.perf_counter() - begin
        finally:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(timeout=20)
            process.kill()
            while self._node.count_publishers('force'):  # the next start must not be answered by this one
                self._executor.spin_once(timeout_sec=0.05)
            for _ in range(20):
                self._executor.spin_once(timeout_sec=0.0)


def finished(*arguments: str) -> float:
    """Seconds that a Python process takes."""
    begin = time.perf_counter()
    subprocess.run([sys.executable, *arguments], stdout=subprocess.DEVNULL, check=True)
    return time.perf_counter() - begin


def main() -> None:
    """Start everything in turns; print the table."""
    os.environ.update(ROS_DOMAIN_ID=DOMAIN, ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
    rclpy.init()
    waiting = FirstMessage()
    subprocess.run([sys.executable, '-m', 'tcp_muscle_ros.muscle'], stdout=subprocess.DEVNULL, check=True)
    here = dict(os.environ)
    creep = ['-p', 'effects:=[creep, hysteresis]']
    works: dict[str, Callable[[], float]] = {
        'least: `import rclpy`': lambda: finished('-c', 'import rclpy'),
        'ours: sim_node to its first message, compiled ahead': lambda: waiting.after(SIM, here),
        'ours: the same with two effects on': lambda: waiting.after(SIM + creep, here),
        '`python -c pass`': lambda: finished('-c', 'pass'),
        'ours: `tcp_muscle --help`': lambda: finished('-m', 'tcp_muscle_ros.tool', '--help'),
    }
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(5):
        for name, work in works.items():
            times[name].append(work())
    with tempfile.TemporaryDirectory(prefix='start_up_') as empty:
        nothing_compiled = here | {'XDG_CACHE_HOME': empty}
        times['without compiling ahead: the first start'] = [waiting.after(SIM, nothing_compiled)]
        times['and the second'] = [waiting.after(SIM, nothing_compiled)]
    median = {name: statistics.median(several) for name, several in times.items()}
    floor = median['least: `import rclpy`']
    show(
        'Start-up, s (aims: 1.5 s over `import rclpy`; 0.3 s for the help)', ('', 's', 'over `import rclpy`'),
        [
            (name, f'{t:.2f}', '' if 'pass' in name or 'help' in name else f'{t - floor:+.2f}')
            for name, t in median.items()
        ],
    )  # fmt: skip
    rclpy.shutdown()


if __name__ == '__main__':
    main()
