#!/usr/bin/env python3
"""How well stick-slip is foretold on runs that were not used: the bench rig's strokes, and a motion of another kind.

    python scripts/stick_slip_table.py [--data ../shared/data] [--write]

Each run that sticks is left out once. From the others of its power come the effect's values, the spread of time
constants, and the repeatability; the run left out is then held against simulations of each of those, with many seeds.
A second table does the same with a motion that this package's model did not make: an end that rests by a Weibull law
about a path of first order. With --write both go into docs/real_recordings.md. Without the data it says so and ends.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from public_table import made_today, show
from real_diagnoses import power_of, with_gain
from real_recordings import NOMINAL, experiments
from repeatability import side_by_side

from tcp_muscle_ros.diagnosis.answer.sticking import Imitation, imitation, stuck
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, Signature, alike, signature
from tcp_muscle_ros.diagnosis.noise.repeatability import repeatability
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.recording import Channel, Recording

SEEDS = 20
LED, FEW = 2, 4  # rounds in which a muscle is led, and simulations in each
NORMAL = 1.645  # standard deviations either way, that hold 90 %
DIFFERS, TWICE = 0.01, 0.05  # probability below which samples differ; below which those of twice the size are told
HEADING = (
    '| | runs | within the band | width over repeatability | stick-slip alone: within | its width '
    '| error of the mean path, smooth | with stick-slip | jumps not told apart | rests not told apart '
    '| jumps of twice the size told |\n|---|---|---|---|---|---|---|---|---|---|---|'
)


@dataclass(frozen=True)
class Run:
    """A run, its own smooth fit, and what it shows of rests and jumps."""

    experiment: Experiment
    fitted: Fit
    found: Signature

    @property
    def seen(self) -> Array:
        """The recorded stroke, m."""
        return self.experiment.observed['displacement'].value


@dataclass(frozen=True)
class Foretold:
    """One run that was left out: shares of its samples in the bands, widths over the repeatability's, errors of mean
    paths over the peak, and the probabilities of the two-sample tests."""

    inside: float
    width: float
    inside_alone: float
    width_alone: float
    smooth: float
    sticky: float
    jumps: float
    rests: float
    twice: float


def run_of(experiment: Experiment) -> Run:
    """A run with its smooth fit."""
    fitted = calibrate([experiment], NOMINAL).fit
    o = experiment.observed['displacement']
    return Run(experiment, fitted, signature(o.time, o.value, o.value - fitted.left[0]['displacement']))


def foretell(left_out: Run, others: Sequence[Run]) -> Foretold | None:
    """The run left out, held against simulations of the others; None where they have too few jumps."""
    experiment, seen = left_out.experiment, left_out.seen
    smooth = [with_gain(experiment.predict(other.fitted.muscle)['displacement'], seen) for other in others]
    runs, found = [r.experiment for r in others], [r.found for r in others]
    sticky, jumps, rests = [], [np.empty(0)], [np.empty(0)]
    for other in others:
        like = imitation(runs, other.fitted.muscle, found)
        if like is None:
            return None
        led = leading(other.experiment, other.fitted.muscle, like)
        like = imitation(runs, led, found) or like
        course = experiment.predict(led)['displacement']
        for seed in range(SEEDS):
            moved = experiment.predict(stuck(led, like, seed))['displacement']
            sticky.append(with_gain(moved, seen))
            still = left_out.found.still
            shown = signature(experiment.observed['displacement'].time, np.round(moved / still) * still, course)
            jumps.append(shown.sizes())
            rests.append(shown.durations())
    peak, made, courses = float(np.ptp(seen)), np.concatenate(jumps), np.stack(sticky)
    repeats = peak * repeating(others if len(others) > 1 else [*others, left_out])
    alone = in_band(seen, courses.mean(axis=0), courses.std(axis=0))
    # One more run is as far from the mean of a few as they are from each other, and that mean from the true one.
    further = repeats**2 * (1.0 + 1.0 / len(others))
    rest = np.sqrt(max(further - float(np.mean(courses.var(axis=0))), 0.0))
    whole = in_band(seen, courses.mean(axis=0), np.hypot(courses.std(axis=0), rest))
    over = 2.0 * NORMAL * repeats
    return Foretold(
        whole[0],
        whole[1] / over,
        alone[0],
        alone[1] / over,
        rms(seen - np.mean(smooth, axis=0)) / peak,
        rms(seen - courses.mean(axis=0)) / peak,
        alike(left_out.found.sizes(), made),
        alike(left_out.found.durations(), np.concatenate(rests)),
        alike(2.0 * left_out.found.sizes(), made),
    )


def repeating(runs: Sequence[Run]) -> float:
    """What runs do not share, each with a gain and a zero, over the peak."""
    found = repeatability(*side_by_side([r.experiment for r in runs]))
    assert found is not None
    return found.own_gain / found.peak


def leading(experiment: Experiment, muscle: Parameters, like: Imitation) -> Parameters:
    """The muscle that leads to what a smooth fit of it shows once its end sticks.

    An end that sticks follows late, on average by half of what it is held by, both ways. A smooth fit took that for the
    muscle's own, and with the effect on top it would be late twice.
    """
    o, found = experiment.observed['displacement'], muscle
    for _ in range(LED):
        smooth = experiment.predict(found)['displacement']
        late = np.mean(
            [experiment.predict(stuck(found, like, seed))['displacement'] - smooth for seed in range(FEW)], axis=0
        )
        moved = replace(experiment, observed={**experiment.observed, 'displacement': replace(o, value=o.value - late)})
        found = calibrate([moved], found).parameters
    return found


def in_band(seen: Array, middle: Array, spread: Array) -> tuple[float, float]:
    """The share of samples within the band that holds 90 %, and its mean width."""
    return float(np.mean(np.abs(seen - middle) <= NORMAL * spread)), 2.0 * NORMAL * float(np.mean(spread))


def rms(value: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(value**2)))


def foretold(runs: Sequence[Run]) -> list[Foretold]:
    """Of each run that sticks, by the others that do; none where it is the only one."""
    sticking = [r for r in runs if r.found.kind == CHANCE]
    each = [foretell(r, [other for other in sticking if other is not r]) for r in sticking if len(sticking) > 1]
    return [one for one in each if one is not None]


def line(label: str, told: Sequence[Foretold]) -> str:
    """Means over runs, in per cent or as counts."""

    def mean(name: str) -> float:
        return float(np.mean([getattr(one, name) for one in told]))

    count, shares = len(told), {name: f'{100 * mean(name):.1f} %' for name in ('smooth', 'sticky')}
    inside, alone = (f'{100 * mean(name):.0f} %' for name in ('inside', 'inside_alone'))
    jumps, rests = (sum(getattr(one, name) > DIFFERS for one in told) for name in ('jumps', 'rests'))
    twice = sum(one.twice < TWICE for one in told)
    cells = [inside, f'{mean("width"):.2f}', alone, f'{mean("width_alone"):.2f}', shares['smooth'], shares['sticky']]
    cells += [f'{n} of {count}' for n in (jumps, rests, twice)]
    return f'| {label} | {count} | {" | ".join(cells)} |'


def another_kind(seed: int) -> Experiment:
    """A stroke of first order whose end rests until it is off by a length of a Weibull law, and then makes up for part
    of it; time constant and gain are each run's own. Read by an encoder of 9 um."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 78.0, 0.2)
    lag, gain = 11.0 * np.exp(0.1 * rng.standard_normal()), 0.02 * np.exp(0.15 * rng.standard_normal())
    top = 1.0 - np.exp(-30.0 / lag)
    heating = 1.0 - np.exp(-np.clip(time - 25.0, 0.0, 30.0) / lag)
    path = gain * np.where(time < 55.0, heating, top * np.exp(-np.maximum(time - 55.0, 0.0) / lag))
    end, shown = 0.0, np.zeros(time.size)
    rests_for = 1.2e-3 * rng.weibull(1.8)
    for k, wanted in enumerate(path):
        if abs(wanted - end) > rests_for:
            end += (wanted - end) * rng.uniform(0.6, 1.0)
            rests_for = 1.2e-3 * rng.weibull(1.8)
        shown[k] = np.round(end / 9e-6) * 9e-6
    power = 2.0 * ((time >= 25.0) & (time < 55.0))
    channels = {'power': (time, power), 'displacement': (time, shown), 'load': (time[:1], np.array([0.098]))}
    return prepare(Recording('made', {n: Channel(n, *of, '') for n, of in channels.items()}, 0), NOMINAL)


def table(data: Path) -> list[str]:
    """The lines of the table: by power, over all, and of recordings that were made otherwise."""
    kinds: dict[str, list[Run]] = {}
    for name, experiment in sorted(experiments(data).items()):
        if name.startswith('stroke_'):
            kinds.setdefault(power_of(name), []).append(run_of(experiment))
    told = {kind: foretold(runs) for kind, runs in kinds.items()}
    rows = [HEADING, *(line(kind, mine) for kind, mine in told.items() if mine)]
    rows.append(line('**all**', [one for mine in told.values() for one in mine]))
    rows.append(line('made otherwise', foretold([run_of(another_kind(seed)) for seed in range(10)])))
    return [*made_today(), *rows]


if __name__ == '__main__':
    show(__doc__, 'sticking', table)
