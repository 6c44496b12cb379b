"""How well sim_node keeps 1 kHz, and what it costs beside a bare loop that publishes the same messages.

    python benchmarks/sim_node_rate.py [--rate 1000] [--duration 60]

Two publishers run one after the other, each a process of its own with a subscriber process on every topic: sim_node
itself, and a loop that sleeps to absolute times and publishes the same seven preallocated messages, unchanged. In both
the clock is read after the last message of a tick: in time is a tick whose messages were all handed over within one
period of the time at which the tick was due. A tick that was never published counts as late.
"""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

import psutil
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.muscle import Muscle, Parameters
from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.safe_node import STATE_QOS
from tcp_muscle_ros.nodes.sim_node import SimNode

TOPICS = {
    **dict.fromkeys(('current', 'voltage', 'resistance', 'displacement', 'force'), Float64),
    'temperature': Temperature,
    'joint_states': JointState,
}
WARM_UP = 3.0  # s, until discovery and first calls are over
QUANTILES = (0.5, 0.99, 0.999)


class MeasuredSimNode(SimNode):
    """sim_node, with the clock read once more after each tick's messages."""

    def __init__(self) -> None:
        super().__init__()
        self.late: list[int] = []

    def _publish(self, stamp: int, *shown: float) -> None:
        super()._publish(stamp, *shown)
        self.late.append(self.time_base.now() - stamp)


def sim(rate: float, duration: float) -> None:
    """sim_node as it is run by its users, until SIGINT; then what it measured."""
    made = []

    def make() -> SimNode:
        made.append(MeasuredSimNode())
        return made[-1]

    run(make, 'sim_node', ['sim_node', '--ros-args', '-p', f'rate_hz:={rate}', '--log-level', 'warn'])
    tell(made[0].late, rate, duration)


def bare(rate: float, duration: float) -> None:
    """The cheapest way to publish these messages at this rate from Python, until SIGINT."""
    rclpy.init()
    node = Node('bare')
    pairs = [(node.create_publisher(kind, name, STATE_QOS), kind()) for name, kind in TOPICS.items()]
    joint = pairs[-1][1]
    joint.name, joint.position, joint.velocity, joint.effort = ['tcp_muscle'], [0.0], [0.0], [0.0]
    late: list[int] = []
    stop = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stop.set())
    start, tick, period = time.monotonic_ns(), 0, 1e9 / rate
    while not stop.is_set():
        tick += 1
        due = start + round(tick * period)
        remaining = due - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)
        for publisher, message in pairs:
            publisher.publish(message)
        late.append(time.monotonic_ns() - due)
    tell(late, rate, duration)
    node.destroy_node()
    rclpy.try_shutdown()


def tell(late: list[int], rate: float, duration: float) -> None:
    """What a publisher measured over the last ``duration`` s, as one line of JSON."""
    expected = round(rate * duration)
    kept = late[-expected:]
    in_time = sum(lateness < 1e9 / rate for lateness in kept)
    ordered = sorted(kept)
    quantiles = [ordered[round(share * (len(ordered) - 1))] / 1e3 for share in QUANTILES]
    print(json.dumps({'published': len(kept), 'expected': expected, 'in_time': in_time, 'late_us': quantiles}))


def subscriber() -> None:
    """Takes every message, until SIGINT."""
    rclpy.init()
    node = Node('subscriber')
    counts = dict.fromkeys(TOPICS, 0)

    def counter(name: str):
        def count(_: object) -> None:
            counts[name] += 1

        return count

    for name, kind in TOPICS.items():
        node.create_subscription(kind, name, counter(name), STATE_QOS)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()
    print(json.dumps(counts))


def measure(role: str, rate: float, duration: float, domain: int) -> dict[str, object]:
    """One publisher with one subscriber process, for ``duration`` s after the warm-up."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}

    def start(name: str) -> subprocess.Popen[str]:
        command = [sys.executable, __file__, '--role', name, '--rate', str(rate), '--duration', str(duration)]
        return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)

    taker, giver = start('subscriber'), start(role)
    try:
        time.sleep(WARM_UP)
        before = psutil.Process(giver.pid).cpu_times()
        time.sleep(duration)
        after = psutil.Process(giver.pid).cpu_times()
        giver.send_signal(signal.SIGINT)
        told = json.loads(giver.communicate(timeout=20)[0].splitlines()[-1])
        taker.send_signal(signal.SIGINT)
        received = json.loads(taker.communicate(timeout=20)[0].splitlines()[-1])
    finally:
        for process in (taker, giver):
            process.kill()
    used = (after.user + after.system) - (before.user + before.system)
    return {**told, 'cpu': used / duration, 'received': min(received.values())}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run both and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--rate', type=float, default=1000.0, help='Hz')
    parser.add_argument('--duration', type=float, default=60.0, help='seconds measured, after the warm-up')
    parser.add_argument('--domain', type=int, default=91, help='ROS_DOMAIN_ID; the next one is used too')
    parser.add_argument('--role', choices=('sim', 'bare', 'subscriber'), help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.role == 'subscriber':
        subscriber()
    elif given.role:
        (sim if given.role == 'sim' else bare)(given.rate, given.duration)
    else:
        Muscle(Parameters.named('karami_tadesse_2017')).step(1e-3, 0.0)  # compiled once, for both that follow
        print(f'{given.rate:g} Hz for {given.duration:g} s, seven topics, one subscriber process, late in us after due')
        print(f'{"publisher":10} {"ticks":>8} {"in time":>10} {"p50":>7} {"p99":>7} {"p99.9":>7} {"CPU":>7}')
        for offset, (role, name) in enumerate((('bare', 'bare loop'), ('sim', 'sim_node'))):
            row = measure(role, given.rate, given.duration, given.domain + offset)
            p50, p99, p999 = row['late_us']
            share = row['in_time'] / row['expected']
            print(f'{name:10} {row["published"]:8} {share:10.4%} {p50:7.0f} {p99:7.0f} {p999:7.0f} {row["cpu"]:7.1%}')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
