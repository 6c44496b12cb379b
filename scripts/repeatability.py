#!/usr/bin/env python3
"""How well the public rigs' runs of one power repeat each other: the least error that any model of them can have.

    python scripts/repeatability.py [--data ../shared/data] [--write]

Of each group of scripts/real_recordings.py, and each power in it: runs are set side by side from the instant at which
the power comes on, and what they do not share is given in per cent of the peak: as they are, with a gain and a zero for
each run, of that by time scale, and how well each run is predicted by the mean of the others; and how many of the runs
stick and slip. With --write the tables go into docs/real_recordings.md. Without the data it says so and ends.
"""

import sys
from pathlib import Path

import numpy as np
from public_table import show
from real_diagnoses import power_of
from real_recordings import GROUPS, NOMINAL, Group, channel_of, experiments

from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, signature
from tcp_muscle_ros.diagnosis.noise.repeatability import SCALES, Repeatability, repeatability
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.muscle.arrays import Array

BEFORE = 2.0  # s shown before the power comes on
HEADING = (
    '| | runs | peak | as they are | own gain, zero | quicker than {0:g} s | {0:g} to {1:g} s | slower '
    '| predicted by the others | stick-slip |\n|---|---|---|---|---|---|---|---|---|---|'
).format(*SCALES)


def side_by_side(runs: list[Experiment]) -> tuple[Array, Array]:
    """Instants (s) from the switch on, and each run at them, its value before taken out; shape (runs, n)."""
    starts = [float(run.imposed.time[np.argmax(run.imposed.drive > 0.0)]) for run in runs]
    columns = [run.observed[channel_of(run)] for run in runs]
    step = max(float(np.median(np.diff(o.time))) for o in columns)
    first = max(float(o.time[0]) - start for o, start in zip(columns, starts, strict=True))
    last = min(float(o.time[-1]) - start for o, start in zip(columns, starts, strict=True))
    time = np.arange(max(first, -BEFORE), last, step)
    values = [np.interp(time, o.time - start, o.value) for o, start in zip(columns, starts, strict=True)]
    return time, np.stack([value - np.median(value[time <= 0.0]) for value in values])


def sticks(runs: list[Experiment]) -> int:
    """How many of the runs stick and slip."""
    count = 0
    for run in runs:
        name = channel_of(run)
        o, left = run.observed[name], calibrate([run], NOMINAL).fit.left[0][name]
        count += signature(o.time, o.value, o.value - left).kind == CHANCE
    return count


def row(label: str, found: Repeatability, sticking: int) -> str:
    """One row of the table, in per cent of the peak."""
    share = [100.0 * value / found.peak for value in (found.plain, found.own_gain, *found.by_scale, found.foretold)]
    said = ' | '.join('-' if np.isnan(value) else f'{value:.1f} %' for value in share)
    return f'| {label} | {found.runs} | {1e3 * found.peak:.3g} | {said} | {sticking} of {found.runs} |'


def group_rows(group: Group, everything: dict[str, Experiment]) -> list[str]:
    """The rows of a group: one a power, and all of them (root mean square over runs, each in per cent of its peak)."""
    kinds: dict[str, list[Experiment]] = {}
    for name in sorted(n for n in everything if n.startswith(group.starts) and group.leave_out not in n):
        kinds.setdefault(power_of(name), []).append(everything[name])
    rows, found = [], []
    for kind, runs in kinds.items():
        print(f'  {kind}', file=sys.stderr, flush=True)
        one = repeatability(*side_by_side(runs))
        if one is None:
            rows.append(f'| {kind} | 1 | | nothing to compare it with |' + ' |' * 6)
        else:
            rows.append(row(kind, one, sticks(runs)))
            found.append(one)
    if found:
        count = sum(one.runs for one in found)
        own, foretold = (
            100.0 * np.sqrt(sum(one.runs * (getattr(one, name) / one.peak) ** 2 for one in found) / count)
            for name in ('own_gain', 'foretold')
        )
        rows.append(f'| **all** | {count} | | | **{own:.1f} %** | | | | **{foretold:.1f} %** | |')
    return rows


def table(group: Group, everything: dict[str, Experiment]) -> str:
    """A group's heading and its rows."""
    one = next(run for name, run in everything.items() if name.startswith(group.starts))
    unit = 'mm' if channel_of(one) == 'displacement' else 'mN'
    title = f'### {group.title[0].upper()}{group.title[1:]} (peak in {unit})'
    return '\n'.join([title, '', HEADING, *group_rows(group, everything), ''])


def tables(data: Path) -> list[str]:
    """The tables of all groups."""
    everything = experiments(data)
    return [table(group, everything) for group in GROUPS]


if __name__ == '__main__':
    show(__doc__, 'repeatability', tables)
