"""Two muscles on one joint in closed loop, on the real nodes: python scripts/antagonist.py [--output FILE.png]

sim_node and controller_node run as two processes with config/antagonist.yaml for a minute and a half; sensors are noisy
and both muscles are other than the controller believes. Writes the picture of docs/many_muscles.md and prints how well
angle and co-contraction were met. A session in which the machine was too busy for real time is run again.
"""

import argparse
import math
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

ROOT = Path(__file__).resolve().parent.parent
DURATION = 90.0  # s
IN_TIME = 60.0  # ms; a longer silence of a node is the machine's, not the controller's
# What the controller does not know of the muscles, and the noise of the sensors.
PLANT = {
    'flexor.hA': 0.0165, 'flexor.k0': 25.0, 'extensor.hA': 0.023, 'extensor.R0': 15.0,
    'force_noise_n': 2e-3, 'temperature_noise_k': 0.1,
}  # fmt: skip
TOPICS = {
    'angle': 'knuckle/angle',
    'setpoint': 'knuckle/angle_setpoint',
    'cocontraction': 'knuckle/cocontraction_setpoint',
    'torque': 'knuckle/external_torque',
    **{f'{muscle} {what}': f'{muscle}/{what}' for muscle in ('flexor', 'extensor') for what in ('force', 'current')},
}
STEPS = [  # until (s), angle (rad), co-contraction (N), torque from outside (N m)
    (4.0, 0.0, 0.6, 0.0),
    (16.0, 0.5, 0.6, 0.0),
    (28.0, -0.5, 0.6, 0.0),
    (40.0, -0.5, 0.9, 0.0),
    (72.0, math.nan, 0.9, 0.0),  # a sine
    (81.0, 0.0, 0.9, 0.0),
    (90.0, 0.0, 0.9, 1.5e-3),
]


def wanted(t: float) -> tuple[float, float, float]:
    """Angle (rad), co-contraction (N) and torque from outside (N m) at a time (s)."""
    angle, mean, torque = next((step[1:] for step in STEPS if t < step[0]), STEPS[-1][1:])
    return (-0.5 * math.cos(2.0 * math.pi * (t - 40.0) / 16.0) if math.isnan(angle) else angle), mean, torque


class Heard:
    """Topics as columns: time at which it was sent (s, system clock) and value."""

    def __init__(self, node: Node) -> None:
        self.rows: dict[str, list[tuple[float, float]]] = {}
        for name, topic in TOPICS.items():
            self._listen(node, name, topic, Float64, lambda message: message.data)
        for muscle in ('flexor', 'extensor'):
            topic = f'{muscle}/temperature'
            self._listen(node, f'{muscle} temperature', topic, Temperature, lambda message: message.temperature)

    def _listen(self, node: Node, name: str, topic: str, kind: type, value: Callable[[Any], float]) -> None:
        rows = self.rows[name] = []

        def take(message: Any, info: dict[str, int]) -> None:
            rows.append((1e-9 * info['source_timestamp'], value(message)))

        node.create_subscription(kind, topic, take, QoSProfile(depth=100))

    def columns(self, begun: float) -> dict[str, NDArray[np.float64]]:
        """Shape (2, n) each: s since ``begun``, and the value."""
        return {name: np.array(rows).T - [[begun], [0.0]] for name, rows in self.rows.items() if rows}


def run() -> dict[str, NDArray[np.float64]]:
    """Run the nodes through the profile; returns what was heard."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = Node('antagonist_session', enable_rosout=False)
    heard = Heard(node)
    speak = [node.create_publisher(Float64, TOPICS[name], 1) for name in ('setpoint', 'cocontraction', 'torque')]
    file = ['--params-file', str(ROOT / 'config' / 'antagonist.yaml')]
    plant = [word for name, value in PLANT.items() for word in ('-p', f'{name}:={value}')]
    processes = [
        subprocess.Popen([sys.executable, '-m', f'tcp_muscle_ros.nodes.{name}', '--ros-args', *file, *more])
        for name, more in (('sim_node', plant), ('controller_node', []))
    ]
    try:
        while not (all(one.get_subscription_count() for one in speak) and heard.rows['flexor current']):
            if any(process.poll() is not None for process in processes):
                raise SystemExit('a node ended')
            rclpy.spin_once(node, timeout_sec=0.1)
        begun, started = time.monotonic(), time.time()
        for tick in range(round(DURATION / 0.05)):
            for publisher, value in zip(speak, wanted(tick * 0.05), strict=True):
                publisher.publish(Float64(data=float(value)))
            while (left := begun + (tick + 1) * 0.05 - time.monotonic()) > 0.0:
                rclpy.spin_once(node, timeout_sec=left)
        return heard.columns(started)
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait(20.0)
        node.destroy_node()
        rclpy.try_shutdown()


def report(columns: dict[str, NDArray[np.float64]]) -> None:
    """How well both were met in the last 2 s of each step, and along the sine."""
    t, angle = columns['angle']
    one, two = (np.interp(t, *columns[f'{muscle} force']) for muscle in ('flexor', 'extensor'))
    mean = 0.5 * (one + two)
    print(f'{"until s":>8s}{"angle rad":>11s}{"met to":>9s}{"mean N":>9s}{"met to":>9s}{"torque mN m":>13s}')
    for until, target, force, torque in STEPS:
        if math.isnan(target):
            path = (t > 44.0) & (t < until)
            error = angle[path] - [wanted(moment)[0] for moment in t[path]]
            print(f'{until:8.0f}{"sine":>11s}{np.sqrt(np.mean(error**2)):9.4f}  (rms)')
            continue
        last = (t > until - 2.0) & (t < until)
        errors = [np.abs(x[last].mean() - y) for x, y in ((angle, target), (mean, force))]
        print(f'{until:8.0f}{target:11.2f}{errors[0]:9.4f}{force:9.2f}{errors[1]:9.4f}{1e3 * torque:13.1f}')
    for name, places in (('to 0.5 rad', (4.0, 16.0, 0.0, 0.5)), ('to -0.5 rad', (16.0, 28.0, 0.5, -0.5))):
        begin, end, before, target = places
        there = (t > begin) & (t < end)
        outside = np.abs(angle[there] - target) > 0.05 * abs(target - before)
        print(f'{name}: within 5 % after {t[there][outside][-1] - begin:.1f} s')


def draw(columns: dict[str, NDArray[np.float64]], path: Path) -> None:
    """Angle, tensions, temperatures and currents over time."""
    import matplotlib as mpl

    mpl.use('Agg')
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(4, 1, figsize=(9.0, 9.0), sharex=True, layout='constrained')
    colours = {'flexor': 'tab:red', 'extensor': 'tab:blue'}
    axes[0].plot(*columns['setpoint'], color='0.6', lw=2.5, label='setpoint')
    axes[0].plot(*columns['angle'], color='k', lw=1.0, label='joint')
    axes[0].set_ylabel('angle, rad')
    for muscle, colour in colours.items():
        axes[1].plot(*columns[f'{muscle} force'], color=colour, lw=0.8, label=muscle)
        axes[2].plot(*columns[f'{muscle} temperature'], color=colour, lw=0.8, label=muscle)
        t, current = columns[f'{muscle} current']
        axes[3].plot(t, current, color=colour, lw=0.4, alpha=0.25)
        axes[3].plot(t, np.convolve(current, np.full(50, 0.02), 'same'), color=colour, label=f'{muscle}, mean of 0.5 s')
    t, one = columns['flexor force']
    mean = 0.5 * (one + np.interp(t, *columns['extensor force']))
    axes[1].plot(*columns['cocontraction'], color='0.6', lw=2.5, label='co-contraction, setpoint')
    axes[1].plot(t, mean, color='k', lw=0.8, label='co-contraction')
    for axis, label in zip(axes[1:], ('tension, N', 'temperature, °C', 'current, A'), strict=True):
        axis.set_ylabel(label)
    axes[0].axvspan(STEPS[-2][0], DURATION, color='0.93', label='1.5 mN m from outside')
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.legend(loc='upper left', ncols=4, fontsize=8)
        axis.margins(x=0.0)
        low, high = axis.get_ylim()
        axis.set_ylim(low, high + 0.22 * (high - low))
    axes[0].set_title('Two muscles on one joint: angle and co-contraction in closed loop, neither muscle as modelled')
    axes[-1].set_xlabel('time, s')
    figure.savefig(path, dpi=110)


def main() -> int:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--output', type=Path, default=ROOT / 'docs' / 'images' / 'antagonist.png')
    output: Path = parser.parse_args().output
    for _ in range(4):
        columns = run()
        gap = 1e3 * float(np.diff(columns['angle'][0]).max())
        if gap <= IN_TIME:
            break
        print(f'(once more: a node was held up for {gap:.0f} ms)', flush=True)
    report(columns)
    draw(columns, output)
    print(f'picture {output}')
    return 0


if __name__ == '__main__':
    sys.exit(main())
