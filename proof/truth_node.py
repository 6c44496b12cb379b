"""A muscle of the truth behind a node, in lockstep: currents and loads in, and out what its instruments show.

python -m proof.truth_node --seed 25 --muscle 0 --namespace NS

Its time goes on while somebody commands it. Each commander finds it cold and at rest under the first load that it
hangs, as worn as the ones before left it. A logger's losses are not simulated.
"""

import argparse
import signal
import sys
import threading
from typing import Any

import numpy as np
import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from proof.cases import Case
from proof.investigated import LOAD, drawn
from proof.recordings import DRIVE, Noise
from proof.truth.plant import Array
from proof.truth.stepping import Stepping
from tcp_muscle_ros.nodes.lockstep import LeadingTime
from tcp_muscle_ros.nodes.polled import Inputs
from tcp_muscle_ros.nodes.ticks import SECOND
from tcp_muscle_ros.nodes.topics import COMMAND_QOS, STATE_QOS, Topics

LONGEST = 1800.0  # s, of one commander
PATIENCE = 10.0  # s, after which a peer that does not answer is waited for no more


class Instrument:
    """A channel's noise and quantisation; the noise of as many ticks as there may be is drawn ahead."""

    def __init__(self, noise: Noise, scale: float, rng: np.random.Generator, ticks: int) -> None:
        self._noise = scale * noise.draw(rng, ticks)
        self._quantum = scale * noise.quantum

    def read(self, value: float, tick: int) -> float:
        """What it shows of a value."""
        shown = value + float(self._noise[tick])
        return round(shown / self._quantum) * self._quantum if self._quantum else shown


class TruthNode:
    """The node; ``run`` returns when ``stop`` is set."""

    def __init__(self, case: Case, namespace: str) -> None:
        self._case, self._count, self._dose = case, 0, 0.0
        self._time: Array = np.arange(round(LONGEST * case.lab.rate)) / case.lab.rate
        self._current, self._load, self._heated = 0.0, LOAD, False
        self._stepping: Stepping | None = None
        self.node = Node('truth_node', namespace=namespace, enable_rosout=False)
        self._topics, self._inputs = Topics(self.node), Inputs()
        self._command = self._listen('current_command', self._take_current)
        self._listen('load', self._take_load)
        kinds = {'temperature': Temperature, **dict.fromkeys(('resistance', 'displacement', 'current'), Float64)}
        self._shown = {name: self._topics.publisher(kind, name, STATE_QOS) for name, kind in kinds.items()}
        self._base = LeadingTime(self.node, 0.0, 1, PATIENCE)
        self._base.open(self._topics)
        self._ticks = 0

    def _listen(self, topic: str, take: Any) -> Any:
        subscription = self._topics.subscription(Float64, topic, take, COMMAND_QOS, self._inputs.group)
        self._inputs.add(subscription, Float64, take)
        return subscription

    def _take_current(self, message: Float64) -> None:
        self._current = message.data
        self._heated |= message.data > 0.0

    def _take_load(self, message: Float64) -> None:
        if not self._heated and message.data != self._load:
            self._stepping = None  # a weight that is hung on a cold muscle: it has come to rest
        self._load = message.data

    def run(self, stop: threading.Event) -> None:
        """One commander after the other."""
        while not stop.is_set():
            self._base.begin(stop)
            self._current, self._load, self._heated = 0.0, LOAD, False
            while not stop.is_set() and self._command.get_publisher_count():
                self._tick(stop)
            self._base.forget_who_is_gone()
            self._end()

    def _end(self) -> None:
        if self._stepping is not None:
            self._dose, self._stepping = self._stepping.dose, None
            self._count += self._heated  # else somebody only looked

    def _tick(self, stop: threading.Event) -> None:
        self._ticks += 1
        self._base.wait(round(self._ticks * SECOND / self._case.lab.rate), stop)
        self._inputs.take()
        if self._stepping is None:
            self._begin()
        assert self._stepping is not None
        self._stepping.tick(self._current, self._load)
        self._publish(self._stepping)

    def _begin(self) -> None:
        case, rng = self._case, self._case.rng(self._count)
        self._stepping = Stepping(case.bench, self._time, case.lab.ambient, self._count, self._dose, self._load)
        scales = {DRIVE: case.lab.top, **dict.fromkeys(('temperature', 'resistance', 'displacement'), 1.0)}
        self._instruments = {
            name: Instrument(case.noise[name], scale, rng, self._time.size) for name, scale in scales.items()
        }

    def _publish(self, stepping: Stepping) -> None:
        signals, tick = stepping.signals(), stepping.ticks - 1
        said = {
            name: self._instruments[name].read(float(getattr(signals, name)[-1]), tick)
            for name in ('temperature', 'resistance', 'displacement')
        }
        said['current'] = self._instruments[DRIVE].read(float(signals.drive[-1]), tick)
        if signals.current[-1] <= 0.003:
            del said['resistance']
        for name, value in said.items():
            message = Float64(data=value)
            if name == 'temperature':
                message = Temperature(temperature=value)
                seconds, rest = divmod(self._base.now(), SECOND)
                message.header.stamp.sec, message.header.stamp.nanosec = seconds, rest
            self._shown[name].publish(message)


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog='python -m proof.truth_node', description=__doc__.splitlines()[0])
    parser.add_argument('--seed', type=int, default=25)
    parser.add_argument('--muscle', type=int, default=0)
    parser.add_argument('--namespace', default='')
    chosen = parser.parse_args(arguments)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    case, _ = drawn(chosen.seed, chosen.muscle)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    truth = TruthNode(case, '/' + chosen.namespace.strip('/'))
    print('ready', flush=True)
    truth.run(stop)
    truth.node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
