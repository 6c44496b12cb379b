"""What twin_node costs, beside a bare loop that publishes as many messages, in one run; and its memory over a day.

    python benchmarks/twin.py [--duration 20] [--hours 24]

Beside a simulated muscle at 100 Hz whose current changes stand, in one ROS domain, the twin (12 messages a tick), a
loop that publishes 12 messages a tick and does nothing else (``publishing.py``), and a subscriber on all of them. Then
the twin's node is given the ticks of a day of simulated time, one after the other, and its resident memory is looked
at.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np
import psutil
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from side_by_side import show
from std_msgs.msg import Float64

from tcp_muscle_ros.muscle import ZERO_CELSIUS, simulate
from tcp_muscle_ros.muscle.__main__ import compile_ahead
from tcp_muscle_ros.nodes.topics import STATE_QOS
from tcp_muscle_ros.nodes.twin_hearing import Heard
from tcp_muscle_ros.nodes.twin_node import PREDICTED, TwinNode
from tcp_muscle_ros.settings.operating import DEFAULT_SET
from tcp_muscle_ros.settings.parameter_file import read

RATE = 100.0  # Hz
DAY_RATE = 10.0  # Hz, of the ticks of a day
TOPICS = [f'{kind}_{name}{end}' for name in PREDICTED for kind, end in
          (('predicted', ''), ('predicted', '_low'), ('predicted', '_high'), ('residual', ''))]  # fmt: skip
NAMESPACE = 'benchmark'
SETTLING = 10.0  # s, until discovery and first calls are over and the twin follows
LEVELS = (0.0, 0.15, 0.2, 0.1)  # A, for 2 s each
NOISE = {'temperature': 0.1, 'resistance': 0.01, 'displacement': 2e-5}  # K, ohm, m
KEPT = 600.0  # s, in the twin's memory


def bare() -> None:
    """Publish as many messages as the twin, until SIGINT."""
    rclpy.init()
    node = Node('bare', namespace=NAMESPACE)
    pairs = [(node.create_publisher(Float64, f'bare/{topic}', STATE_QOS), Float64()) for topic in TOPICS]
    start, tick = time.monotonic(), 0
    while True:
        tick += 1
        time.sleep(max(start + tick / RATE - time.monotonic(), 0.0))
        for publisher, message in pairs:
            publisher.publish(message)


def subscriber() -> None:
    """A subscription on every topic of both, which nobody looks at, until SIGINT."""
    rclpy.init()
    node = Node('subscriber', namespace=NAMESPACE)
    for giver in ('bare', 'twin_node'):
        for topic in TOPICS:
            node.create_subscription(Float64, f'{giver}/{topic}', lambda _: None, STATE_QOS)
    threading.Event().wait()


def cost(duration: float) -> list[tuple[float, float]]:
    """Of the bare loop and the twin, in the same ``duration`` s: processor time (share of a core), ticks a second."""

    def start(*command: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, *command])

    def node(name: str, *more: str) -> subprocess.Popen[bytes]:
        return start('-m', f'tcp_muscle_ros.nodes.{name}', '--ros-args', '--log-level', 'warn', '-r',
                     f'__ns:=/{NAMESPACE}', *more)  # fmt: skip

    noise = [part for name, unit in (('temperature', 'k'), ('resistance', 'ohm'), ('displacement', 'm'))
             for part in ('-p', f'{name}_noise_{unit}:={NOISE[name]}')]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        twin = node('twin_node', '-p', f'report_folder:={folder}')
        floor = start(__file__, '--role', 'bare')
        everyone = [twin, floor, start(__file__, '--role', 'subscriber'), node('sim_node', *noise)]
        rclpy.init()
        commander = Node('commander', namespace=NAMESPACE)
        command = commander.create_publisher(Float64, 'current_command', QoSProfile(depth=1))
        heard = [commander.create_subscription(Float64, f'{name}/{TOPICS[0]}', lambda _: None, QoSProfile(depth=100))
                 for name in ('bare', 'twin_node')]  # fmt: skip
        try:
            _command(command, SETTLING, heard)
            watched = [psutil.Process(one.pid) for one in (floor, twin)]
            before, begun = [one.cpu_times() for one in watched], time.monotonic()
            counts = _command(command, duration, heard)
            passed = time.monotonic() - begun
            after = [one.cpu_times() for one in watched]
        finally:
            for process in everyone:
                process.send_signal(signal.SIGINT)
            for process in everyone:
                process.wait(30)
            rclpy.try_shutdown()
    used = [b.user + b.system - a.user - a.system for a, b in zip(before, after, strict=True)]
    return [(one / passed, count / passed) for one, count in zip(used, counts, strict=True)]


def _command(publisher: rclpy.publisher.Publisher, duration: float, heard: list[Subscription]) -> list[int]:
    """Command for so long; how many messages came on each subscription meanwhile."""
    begun, counts = time.monotonic(), [0] * len(heard)
    while (now := time.monotonic() - begun) < duration:
        publisher.publish(Float64(data=LEVELS[int(now / 2.0) % len(LEVELS)]))
        time.sleep(0.05)
        for k, subscription in enumerate(heard):
            with subscription.handle:
                while subscription.handle.take_message(Float64, False) is not None:
                    counts[k] += 1
    return counts


def day(hours: float, folder: str) -> tuple[list[tuple[float, float]], int]:
    """Resident memory (MB) of a process with the twin's node after so many hours of simulated time; and its alarms,
    which leave their bags in ``folder``."""
    random, per_hour = np.random.default_rng(1), round(3600.0 * DAY_RATE)
    time_s = np.arange(per_hour) / DAY_RATE
    # The last minutes of an hour without a current: the next begins cold.
    current = np.where(time_s < 3300.0, np.asarray(LEVELS)[(time_s / 20.0).astype(int) % len(LEVELS)], 0.0)
    file = read(DEFAULT_SET)
    load, ambient = file.number('load_n'), file.number('ambient_temperature_c') + ZERO_CELSIUS
    shown = simulate(file.parameters, time_s, current, load=load, ambient=ambient, only=tuple(NOISE))
    values = (f'rate_hz:={DAY_RATE}', f'keep_s:={KEPT}', f'report_folder:={folder}')
    rclpy.init(args=['--ros-args', *(part for value in values for part in ('-p', value)), '--log-level', 'warn'])
    node, process, found = TwinNode(), psutil.Process(), []
    try:
        for hour in range(round(hours)):
            noisy = {name: getattr(shown, name) + s * random.standard_normal(per_hour) for name, s in NOISE.items()}
            rows = np.column_stack([current, *noisy.values()]).tolist()
            for k, row in enumerate(rows):
                node._take(Heard(3600.0 * hour + k / DAY_RATE, dict(zip(('current', *noisy), row, strict=True))))
                node._notice()
                if k % round(DAY_RATE) == 0:
                    node._publish_diagnostics()
            found.append((hour + 1.0, process.memory_info().rss / 2**20))
        return found, node._alarms
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def main() -> None:
    """Both, one after the other; print the tables."""
    parser = argparse.ArgumentParser(description='What twin_node costs.')
    parser.add_argument('--duration', type=float, default=20.0, help='s measured')
    parser.add_argument('--hours', type=float, default=24.0, help='of simulated time for its memory; 0: not measured')
    parser.add_argument('--domain', type=int, default=93, help='ROS_DOMAIN_ID')
    parser.add_argument('--role', choices=('bare', 'subscriber'), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.role:
        signal.signal(signal.SIGINT, lambda *_: os._exit(0))
        (bare if given.role == 'bare' else subscriber)()
        return
    os.environ |= {'ROS_DOMAIN_ID': str(given.domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    compile_ahead()
    if given.duration:
        found = cost(given.duration)
        rows = [
            (name, f'{rate:.1f}', f'{used:.1%}', f'{used / found[0][0]:.2f}')
            for name, (used, rate) in zip(('least: bare loop', 'ours: twin_node'), found, strict=True)
        ]
        title = f'twin_node beside a bare loop, both in the same {given.duration:g} s at {RATE:g} Hz'
        columns = ('', 'ticks a second', 'of a core', 'over least')
        show(f'{title}, {len(TOPICS)} messages a tick (aim: CPU 2.5 of the least)', columns, rows)
    if given.hours:
        with tempfile.TemporaryDirectory() as folder:
            memory, alarms = day(given.hours, folder)
        wanted = [one for one in memory if one[0] in (1.0, 2.0, 6.0, 12.0, 16.0, 20.0, 24.0, memory[-1][0])]
        rows = [(f'{hours:g} h', f'{megabytes:.1f}') for hours, megabytes in wanted]
        title = f'Memory of twin_node after so much simulated time at {DAY_RATE:g} Hz, {KEPT:g} s kept'
        show(f'{title}, {alarms} alarms', ('', 'resident, MB'), rows)


if __name__ == '__main__':
    main()
