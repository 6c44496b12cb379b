"""Publishers side by side, each in a process of its own: sim_node, and the cheapest loop that publishes as much.

Shared by ``node_rate.py`` and ``hand.py``. The loop sleeps to absolute times and publishes the same preallocated
messages, unchanged. In both the clock is read after the last message of a tick: in time is a tick whose messages were
all handed over within one period of the time at which it was due. A tick that was never published counts as late. A
process with a subscription on every topic stands beside them; it lets the messages come in without looking at them, so
that it is not what is measured.
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
from dataclasses import dataclass
from pathlib import Path

import psutil
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import Float64

from tcp_muscle_ros.nodes.lifetime import run
from tcp_muscle_ros.nodes.sim_node import SimNode
from tcp_muscle_ros.nodes.topics import STATE_QOS

TOPICS = {
    **dict.fromkeys(('current', 'voltage', 'resistance', 'displacement', 'force'), Float64),
    'temperature': Temperature,
    'joint_states': JointState,
}
WARM_UP = 2.0  # s, after everyone is there, until discovery and first calls are over
READY = 'ready'


@dataclass(frozen=True)
class Load:
    """What is published: by so many muscles (0: one, without a name), at a rate (Hz)."""

    muscles: int
    rate: float

    @property
    def names(self) -> list[str]:
        """Of the muscles; '' for one without a name."""
        return [f'm{k}' for k in range(self.muscles)] or ['']

    @property
    def topics(self) -> list[tuple[str, type]]:
        """Every topic with its type; many muscles have one of all their joints besides."""
        each = [(f'{name}/{topic}'.lstrip('/'), kind) for name in self.names for topic, kind in TOPICS.items()]
        return [*each, ('joint_states', JointState)] if self.muscles else each


class MeasuredSimNode(SimNode):
    """sim_node, with the clock read once more after each tick's messages."""

    def __init__(self) -> None:
        super().__init__()
        self.late: list[int] = []

    def start(self, on_failure) -> None:
        """As sim_node, and says so."""
        super().start(on_failure)
        print(READY, flush=True)

    def _publish(self, stamp: int) -> None:
        super()._publish(stamp)
        self.late.append(self.time_base.now() - stamp)


def sim(load: Load, namespace: str) -> list[int]:
    """sim_node as it is run by its users, until SIGINT; how late its ticks were, ns."""
    made = []

    def make() -> SimNode:
        made.append(MeasuredSimNode())
        return made[-1]

    arguments = ['-p', f'rate_hz:={load.rate}', '--log-level', 'warn']
    if namespace:
        arguments += ['-r', f'__ns:=/{namespace}']
    elif load.muscles:
        arguments += ['-p', f'muscles:=[{", ".join(load.names)}]']
    code = run(make, 'sim_node', ['sim_node', '--ros-args', *arguments])
    if code != 0:
        raise SystemExit(code)
    return made[0].late


def bare(load: Load) -> list[int]:
    """The cheapest way to publish these messages at this rate from Python, until SIGINT."""
    rclpy.init()
    node = Node('bare')
    pairs = [(node.create_publisher(kind, name, STATE_QOS), kind()) for name, kind in load.topics]
    for _, message in pairs:
        if isinstance(message, JointState):
            message.name, message.position, message.velocity, message.effort = ['tcp_muscle'], [0.0], [0.0], [0.0]
    if load.muscles:
        joint = pairs[-1][1]
        joint.name, zeros = load.names, [0.0] * load.muscles
        joint.position, joint.velocity, joint.effort = zeros, zeros, zeros
    late: list[int] = []
    stop = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stop.set())
    start, tick, period = time.monotonic_ns(), 0, 1e9 / load.rate
    print(READY, flush=True)
    while not stop.is_set():
        tick += 1
        due = start + round(tick * period)
        remaining = due - time.monotonic_ns()
        if remaining > 0:
            time.sleep(remaining * 1e-9)
        for publisher, message in pairs:
            publisher.publish(message)
        late.append(time.monotonic_ns() - due)
    rclpy.try_shutdown()
    return late


def subscriber(load: Load) -> None:
    """A subscription on every topic, until SIGINT."""
    rclpy.init()
    node = Node('subscriber')
    for name, kind in load.topics:
        node.create_subscription(kind, name, lambda _: None, STATE_QOS)
    print(READY, flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        threading.Event().wait()
    rclpy.try_shutdown()


@dataclass(frozen=True)
class Result:
    """What publishers did in the time that was measured: of the worst of them, the processor time of all."""

    in_time: float
    p50: float  # us after due
    p99: float
    cpu: float  # of one core
    megabytes: float  # resident


def measure(role: str, load: Load, duration: float, domain: int) -> Result:
    """``sim``, ``sims`` (a process for each muscle) or ``bare``, with a subscriber, for ``duration`` s.

    Raises:
        ChildProcessError: a publisher that ended; its last line on stderr.
    """
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}

    def start(role: str, namespace: str = '') -> subprocess.Popen[str]:
        command = [sys.executable, str(Path(__file__)), role, str(load.muscles), str(load.rate), str(duration)]
        pipe = subprocess.PIPE
        return subprocess.Popen([*command, namespace], env=environment, stdout=pipe, stderr=pipe, text=True)

    taker = start('subscriber')
    givers = [start('sim', name) for name in load.names] if role == 'sims' else [start(role)]
    everyone = [taker, *givers]
    try:
        for process in everyone:
            assert process.stdout is not None and process.stderr is not None
            if process.stdout.readline().strip() != READY:
                raise ChildProcessError(process.stderr.read().strip().splitlines()[-1])
        time.sleep(WARM_UP)
        watched = [psutil.Process(giver.pid) for giver in givers]
        before = [one.cpu_times() for one in watched]
        time.sleep(duration)
        after = [one.cpu_times() for one in watched]
        memory = sum(one.memory_info().rss for one in watched) / 2**20
        for process in everyone:
            process.send_signal(signal.SIGINT)
        told = [json.loads(giver.communicate(timeout=30)[0].splitlines()[-1]) for giver in givers]
    finally:
        for process in everyone:
            process.kill()
            process.communicate()
    used = sum(b.user + b.system - a.user - a.system for a, b in zip(before, after, strict=True))
    in_time, p50, p99 = (list(column) for column in zip(*told, strict=True))
    return Result(min(in_time), max(p50), max(p99), used / duration, memory)


def tell(late: list[int], rate: float, duration: float) -> None:
    """The share of ticks in time over the last ``duration`` s and the quantiles of lateness (us), as JSON."""
    expected = round(rate * duration)
    kept = sorted(late[-expected:])
    in_time = sum(lateness < 1e9 / rate for lateness in kept) / expected
    print(json.dumps([in_time, *(kept[round(share * (len(kept) - 1))] / 1e3 for share in (0.5, 0.99))]))


def main(arguments: Sequence[str] | None = None) -> None:
    """One process of a measurement."""
    parser = argparse.ArgumentParser(description='One process of a measurement; see node_rate.py and hand.py.')
    parser.add_argument('role', choices=('sim', 'bare', 'subscriber'))
    parser.add_argument('muscles', type=int)
    parser.add_argument('rate', type=float)
    parser.add_argument('duration', type=float)
    parser.add_argument('namespace')
    given = parser.parse_args(arguments)
    load = Load(given.muscles, given.rate)
    if given.role == 'subscriber':
        subscriber(load)
    else:
        tell(sim(load, given.namespace) if given.role == 'sim' else bare(load), given.rate, given.duration)


if __name__ == '__main__':
    main()
