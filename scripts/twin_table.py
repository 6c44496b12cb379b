"""Measures the twin's test offline: false alarms in 300 h of muscle time, and how soon each effect is noticed.

Muscles are drawn about the paper's, calibrated from a noisy recording of ten minutes (never given the true model), and
watched at 20 Hz under random currents and loads. Each effect is then concealed at twice its usual strength.
Usage: scripts/twin_table.py [--hours 300] [--output docs/twin_table.md]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tcp_muscle_ros.control.predictor import CHANNELS, LEAST
from tcp_muscle_ros.control.sequential import Rule, Sequential, hours_between_false_alarms
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.observation.holding import Conditions
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import EFFECTS, SPECIFICATIONS, Parameters, simulate
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import Channel, Recording
from tcp_muscle_ros.report.intervals_file import write_intervals
from tcp_muscle_ros.settings.intervals import variants

RATE = 20.0  # Hz
NOISE = {'temperature': 0.1, 'resistance': 0.01, 'displacement': 2e-5}  # K, ohm, m: standard deviations
MUSCLES = 12
RUN = 3600.0  # s, of one run without an effect
WATCHED = 1200.0  # s, of one with
CALIBRATED_ON = 600.0  # s
MOST_OBSERVATIONS = 1000
LOADS = (0.2942, 0.5884, 0.9807)  # N
LATE = 1.0 / RATE  # s, by which the times of measurements are taken to be unsure: a period, as by twin_node
_SPREAD = {'hA': 0.1, 'R0': 0.05, 'a_R': 0.1, 'k0': 0.1, 'C': 0.1, 'B': 0.1}  # relative, of the muscles that are drawn


class Inputs(NamedTuple):
    """What is done to a muscle, float64[n]: s, A, N."""

    time: Array
    current: Array
    load: Array


class Watched(NamedTuple):
    """A muscle, the model that was calibrated on it, and muscles drawn from its intervals."""

    true: Parameters
    model: Parameters
    variants: Sequence[Parameters]


def inputs(duration: float, random: np.random.Generator) -> Inputs:
    """Random steps of the current, half of them zero, and now and then another load."""
    time_s = np.arange(round(duration * RATE)) / RATE
    current, load = np.zeros_like(time_s), np.full_like(time_s, LOADS[1])
    start = 0.0
    while start < duration:
        hold = random.uniform(4.0, 30.0)
        chosen = (time_s >= start) & (time_s < start + hold)
        current[chosen] = 0.0 if random.random() < 0.4 else random.uniform(0.05, 0.27)
        if random.random() < 0.1:
            load[time_s >= start] = random.choice(LOADS)
        start += hold
    return Inputs(time_s, current, load)


def shown(muscle: Parameters, done: Inputs) -> Array:
    """What ideal sensors show, float64[3, n]: K, ohm, m."""
    outputs = simulate(muscle, *done[:2], load=done.load, starting_load=LOADS[1], only=tuple(NOISE))
    return np.array([getattr(outputs, name) for name in NOISE])


def noisy(values: Array, random: np.random.Generator) -> Array:
    """The same with the sensors' noise."""
    return values + np.array(list(NOISE.values()))[:, None] * random.standard_normal(values.shape)


def watched(random: np.random.Generator, folder: Path) -> Watched:
    """A muscle is drawn, recorded with noise, and calibrated from that recording."""
    nominal = Parameters.named('karami_tadesse_2017')
    true = nominal.replace({name: nominal[name] * np.exp(s * random.standard_normal()) for name, s in _SPREAD.items()})
    done = inputs(CALIBRATED_ON, random)
    seen = noisy(shown(true, done), random)
    values = {'current': done.current, 'load': done.load, **dict(zip(NOISE, seen, strict=True))}
    recording = Recording('made', {name: Channel(name, done.time, v, name) for name, v in values.items()}, 0)
    experiment = prepare(recording, nominal, Conditions(load=LOADS[1], ambient=nominal['T0']), MOST_OBSERVATIONS)
    calibration = calibrate([experiment], nominal)
    write_intervals(folder / 'muscle.intervals.json', calibration.known)
    drawn = variants(folder / 'muscle.yaml', calibration.parameters) or {}
    return Watched(true, calibration.parameters, list(drawn.values())[:12])


def predicted(one: Watched, done: Inputs) -> tuple[Array, Array]:
    """Value and spread of the prediction, float64[3, n] each: as ``control.predictor`` has them."""
    value = shown(one.model, done)
    own = np.mean([(shown(other, done) - value) ** 2 for other in one.variants], axis=0)
    steps = np.abs(np.diff(value, axis=1, prepend=value[:, :1])) * (LATE * RATE)
    return value, np.sqrt(own + LEAST[: len(NOISE), None] ** 2 + steps**2)


def alarms(residual: Array, spread: Array, rule: Rule) -> tuple[Array, Array]:
    """Which channel alarmed first when (s; NaN: never), over arrays (channels, runs, n)."""
    test = Sequential(residual.shape[:2], rule)
    for k in range(residual.shape[2]):
        test.add(residual[:, :, k], spread[:, :, k], k / RATE)
    first = np.where(np.isnan(test.alarmed_at), np.inf, test.alarmed_at)
    return np.argmin(first, axis=0), np.min(first, axis=0)


def twice_as_strong(effect: str) -> dict[str, float]:
    """The parameters of an effect at twice its usual strength, as far as its bounds go."""
    one = EFFECTS[effect]
    name = f'{effect}.{one.strength}'
    row = SPECIFICATIONS[name]
    return {name: float(np.clip(one.none + 2.0 * (row.value - one.none), row.low, row.high))}


def false_alarms(
    muscles: Sequence[Watched], hours: float, rule: Rule, random: np.random.Generator
) -> tuple[int, float]:
    """Alarms without a difference, and the hours in which they came."""
    count, watched_h = 0, 0.0
    batch = 24
    while watched_h < hours - 1e-9:
        residuals, spreads = [], []
        for k in range(min(batch, round(hours - watched_h))):
            one = muscles[k % len(muscles)]
            done = inputs(RUN, random)
            value, spread = predicted(one, done)
            residuals.append(noisy(shown(one.true, done), random) - value)
            spreads.append(spread)
        _, when = alarms(np.stack(residuals, axis=1), np.stack(spreads, axis=1), rule)
        count += int(np.sum(np.isfinite(when)))
        watched_h += len(residuals) * RUN / 3600.0
    return count, watched_h


def delays(muscles: Sequence[Watched], rule: Rule, random: np.random.Generator) -> dict[str, tuple[float, float, str]]:
    """By effect: the share of the muscles in which it was noticed, the median delay (s), the channel that showed it."""
    done = [inputs(WATCHED, random) for _ in muscles]
    foreseen = [predicted(one, what) for one, what in zip(muscles, done, strict=True)]
    spread = np.stack([one[1] for one in foreseen], axis=1)
    found = {}
    for effect in EFFECTS:
        residuals = []
        for one, what, (value, _) in zip(muscles, done, foreseen, strict=True):
            true = one.true.with_effects(effect).replace(twice_as_strong(effect))
            residuals.append(noisy(shown(true, what), random) - value)
        channel, when = alarms(np.stack(residuals, axis=1), spread, rule)
        noticed = np.isfinite(when)
        names = [CHANNELS[k] for k in channel[noticed]]
        most = max(set(names), key=names.count) if names else ''
        found[effect] = float(np.mean(noticed)), float(np.median(when)), most
    return found


def document(rule: Rule, counted: tuple[int, float], found: dict[str, tuple[float, float, str]], took: float) -> str:
    """The table as Markdown."""
    count, hours = counted
    rows = [
        f'| `{name}` | {EFFECTS[name].stage} | {100 * share:.0f} % | '
        f'{f"{delay:.0f} s" if np.isfinite(delay) else "not within the run"} | {channel or "none"} |'
        for name, (share, delay, channel) in found.items()
    ]
    stated = {bias: hours_between_false_alarms(rule, bias, len(NOISE)) for bias in (0.0, 2.5, 3.0)}
    return '\n'.join(
        [
            '# How soon the twin notices what',
            '',
            f'Made by `scripts/twin_table.py --hours {hours:g}` on {date.today()}, in {took / 60:.0f} min on one core.',
            '',
            f'**False alarms: {count} in {hours:.0f} h** of muscle time: {MUSCLES} muscles, each calibrated from '
            f'{CALIBRATED_ON / 60:.0f} min, at {RATE:g} Hz with noise of '
            + ', '.join(f'{value:g} {unit}' for value, unit in zip(NOISE.values(), ('K', 'ohm', 'm'), strict=True))
            + '.',
            '',
            'Stated, of three channels, where a calibration is off for good by so many standard deviations: '
            + ', '.join(f'{bias:g}: one in {value:.1g} h' for bias, value in stated.items())
            + '.',
            '',
            f'Each effect at twice its usual strength (within its bounds) from the start of a run of '
            f'{WATCHED / 60:.0f} min, in {MUSCLES} muscles. "Not within the run": noticed in less than half of them.',
            '',
            '| effect | stage | noticed | median delay | channel |',
            '|---|---|---|---|---|',
            *rows,
            '',
        ]
    )


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--hours', type=float, default=300.0)
    parser.add_argument('--output', type=Path, default=Path('docs/twin_table.md'))
    parser.add_argument('--seed', type=int, default=25)
    args = parser.parse_args()
    begun, random, rule = time.process_time(), np.random.default_rng(args.seed), Rule()
    with tempfile.TemporaryDirectory() as folder:
        muscles = [watched(random, Path(folder)) for _ in range(MUSCLES)]
    print(f'calibrated {time.process_time() - begun:.0f} s', flush=True)
    counted = false_alarms(muscles, args.hours, rule, random)
    print(f'false alarms: {counted}, {time.process_time() - begun:.0f} s', flush=True)
    found = delays(muscles, rule, random)
    args.output.write_text(document(rule, counted, found, time.process_time() - begun))
    print(args.output.read_text())


if __name__ == '__main__':
    main()
