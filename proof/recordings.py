"""From ideal signals to what a lab hands over: noise, quantisation, losses, stamps, and a rosbag2 bag."""

import json
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.signal import lfilter

from proof.truth.bench import Experiment, Signals
from proof.truth.plant import Array

SIGMA = {'temperature': 0.2, 'resistance': 0.02, 'displacement': 0.05e-3, 'force': 2e-3}
INPUTS = ('current', 'power', 'voltage')
DRIVE = 'drive'  # among the instruments: what reads the input; its noise is a share of the largest
START_NS = 1_760_000_000_000_000_000


@dataclass(frozen=True)
class Noise:
    """Of one channel: white plus first-order coloured, standard deviation `sigma` in all."""

    sigma: float
    coloured: float  # share of the variance
    pole: float  # of the coloured part, per tick
    quantum: float  # 0: none
    lost: float  # share of samples lost one by one
    bursts: int  # stretches lost

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """A realisation."""
        white = rng.standard_normal(n) * self.sigma * np.sqrt(1.0 - self.coloured)
        drive = rng.standard_normal(n) * np.sqrt(1.0 - self.pole**2)
        drive[0] /= np.sqrt(1.0 - self.pole**2)
        return np.asarray(white + self.sigma * np.sqrt(self.coloured) * lfilter([1.0], [1.0, -self.pole], drive))

    def density(self, n: int) -> Array:
        """Variance per line of a real FFT of n samples, relative to white noise of variance one."""
        line = np.exp(-2j * np.pi * np.arange(n // 2 + 1) / n)
        coloured = (1.0 - self.pole**2) / np.abs(1.0 - self.pole * line) ** 2
        return np.asarray(self.sigma**2 * ((1.0 - self.coloured) + self.coloured * coloured))


def draw_noise(rng: np.random.Generator, *, coloured: bool = False) -> dict[str, Noise]:
    """The instruments of one lab. coloured: the decoy whose noise wanders."""
    noise = {}
    for name, sigma in SIGMA.items():
        quanta = {
            'temperature': (0.0625, 0.1),
            'resistance': (0.005, 0.01),
            'displacement': (1e-5, 2e-5),
            'force': (5e-4,),
        }
        noise[name] = Noise(
            sigma=sigma * float(rng.uniform(0.8, 1.2)) * (1.3 if coloured else 1.0),
            coloured=float(rng.uniform(0.75, 0.95) if coloured else rng.uniform(0.1, 0.6)),
            pole=float(rng.uniform(0.97, 0.995) if coloured else rng.uniform(0.6, 0.95)),
            quantum=float(rng.choice(quanta[name])) if rng.random() < 0.4 else 0.0,
            lost=float(rng.choice([0.0, 0.002, 0.01])),
            bursts=int(rng.choice([0, 0, 0, 1, 2])),
        )
    # A source that says what it imposes has none; an ammeter beside it reads it with noise.
    share = float(10.0 ** rng.uniform(-4.0, -3.0)) if rng.random() < 0.5 else 0.0
    quantum = share * float(rng.choice([0.0, 0.0, 0.5, 1.0]))
    noise[DRIVE] = Noise(share, coloured=0.0, pole=0.0, quantum=quantum, lost=0.0, bursts=0)
    return noise


def instrument(
    signals: Signals, experiment: Experiment, noise: dict[str, Noise], channels: Sequence[str], rng: np.random.Generator
) -> dict[str, tuple[Array, Array]]:
    """What is written down: channel -> (indices of the ticks that were kept, values in the units of the topics)."""
    n = len(experiment.time)
    found: dict[str, tuple[Array, Array]] = {}
    for name in channels:
        values = getattr(signals, name) + noise[name].draw(rng, n)
        if noise[name].quantum:
            values = np.round(values / noise[name].quantum) * noise[name].quantum
        kept = rng.random(n) >= noise[name].lost
        for _ in range(noise[name].bursts):
            start = int(rng.integers(0, n))
            kept[start : start + int(rng.uniform(4, 40))] = False
        if name == 'resistance':
            kept &= signals.current > 0.003
        where = np.flatnonzero(kept)
        found[name] = (where, values[where])
    drive, meter, largest = signals.drive, noise[DRIVE], float(np.max(np.abs(signals.drive)))
    if meter.sigma:
        drive = drive + largest * meter.draw(rng, n)
        if meter.quantum:
            drive = np.round(drive / (largest * meter.quantum)) * largest * meter.quantum
    found[INPUTS[experiment.kind]] = (np.arange(n), drive)
    changed = np.flatnonzero(np.diff(experiment.load, prepend=-1.0) != 0.0)
    seconds = np.searchsorted(experiment.time, np.arange(0.0, experiment.time[-1], 1.0))
    where = np.unique(np.concatenate([changed, seconds]))
    found['load'] = (where, experiment.load[where])
    return found


def write(
    path: Path,
    experiment: Experiment,
    found: dict[str, tuple[Array, Array]],
    variance: float,
    start_ns: int,
    rng: np.random.Generator,
) -> None:
    """A rosbag2 directory with an MCAP file and the contract's topics."""
    store = get_typestore(Stores.ROS2_JAZZY)
    stamp = start_ns + np.round(experiment.time * 1e9).astype(np.int64)
    logged = stamp + rng.integers(50_000, 900_000, len(stamp))  # the way to the recorder takes up to 0.9 ms
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        if experiment.blocked:
            bag.set_custom_data('tcp_muscle_known', json.dumps({'end': 'blocked'}))
        messages: list[tuple[int, int, bytes]] = []
        connections = []
        for number, (name, (where, values)) in enumerate(found.items()):
            kind = 'sensor_msgs/msg/Temperature' if name == 'temperature' else 'std_msgs/msg/Float64'
            connections.append(bag.add_connection(f'/{name}', kind, typestore=store))
            coded = _temperatures(stamp[where], values, variance) if name == 'temperature' else _floats(values)
            messages += [(int(t) + number, number, m) for t, m in zip(logged[where], coded, strict=True)]
        messages.sort(key=lambda message: message[0])
        for log_ns, number, data in messages:
            bag.write(connections[number], log_ns, data)


def _floats(values: Array) -> Iterator[bytes]:
    pack = struct.Struct('<4sd').pack
    return (pack(b'\x00\x01\x00\x00', float(v)) for v in values)


def _temperatures(stamp: Array, values: Array, variance: float) -> Iterator[bytes]:
    """Header (sec, nanosec, empty frame_id), then two doubles at the next multiple of 8."""
    pack = struct.Struct('<4siIIB3xdd').pack
    return (
        pack(b'\x00\x01\x00\x00', int(t) // 10**9, int(t) % 10**9, 1, 0, float(v), variance)
        for t, v in zip(stamp, values, strict=True)
    )
