#!/usr/bin/env python3
"""Which faults of instruments are named when they are put into the public bench rig's runs: a table, one row a fault.

    python scripts/instrument_faults.py [--data ../shared/data] [--write]

Each run is looked at as it was recorded, and with each fault put in, as `tcp_muscle check` and the gate of a diagnosis
look at it. With --write the table goes into docs/real_recordings.md. Without the data it says so and ends.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from public_table import made_today, show
from real_recordings import ROOT

from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.recording.inputs import hold
from tcp_muscle_ros.recording.instruments import instrument_faults
from tcp_muscle_ros.recording.recording import Channel, Recording

OHM = 13.3  # of this rig's muscle, by its source
SEVEN = 1.07
AHEAD = 2.0  # s
SHARE = 0.2  # of the rows are held
STEP, TONE = 0.03, 0.005  # of the peak to peak
HERTZ = 1.7
Change = Callable[[Recording, Channel], Recording]


def with_output(run: Recording, output: Channel, time: Array, value: Array) -> Recording:
    """The run with another course of its output."""
    return replace(run, channels={**run.channels, output.name: replace(output, time=time, value=value)})


def held(run: Recording, output: Channel) -> Recording:
    """A fifth of the rows repeat the one before."""
    value = output.value.copy()
    for k in np.flatnonzero(np.random.default_rng(len(value)).random(value.size) < SHARE):
        value[k] = value[max(k - 1, 0)]
    return with_output(run, output, output.time, value)


def steps(run: Recording, output: Channel) -> Recording:
    """The instrument reads higher while the power is on."""
    on = hold(run['power'], output.time) > 0.0
    return with_output(run, output, output.time, output.value + STEP * np.ptp(output.value) * on)


def ahead(run: Recording, output: Channel) -> Recording:
    """The output is stamped by a clock that is ahead."""
    late = output.time >= AHEAD
    return with_output(run, output, output.time[late] - AHEAD, output.value[late])


def tone(run: Recording, output: Channel) -> Recording:
    """A wave throughout."""
    wave = TONE * np.ptp(output.value) * np.sin(2.0 * np.pi * HERTZ * output.time)
    return with_output(run, output, output.time, output.value + wave)


def both_high(run: Recording, output: Channel, keep: tuple[str, ...] = ('power',)) -> Recording:
    """Voltage and current as the nominal resistance gives them, both too high; with the power, or without."""
    power = run['power']
    made = {
        'voltage': Channel('voltage', power.time, SEVEN * np.sqrt(OHM * power.value), ''),
        'current': Channel('current', power.time, SEVEN * np.sqrt(power.value / OHM), ''),
    }
    kept = {name: c for name, c in run.channels.items() if name != 'power' or 'power' in keep}
    return replace(run, channels={**kept, **made})


FAULTS: tuple[tuple[str, str, Change], ...] = (
    ('as it was recorded', '', lambda run, _: run),
    ('a fifth of the rows repeat the one before', 'held', held),
    (f'a step of {100 * STEP:g} % of the peak at each of the two switches', 'switch', steps),
    (f'the output on a clock {AHEAD:g} s ahead', 'clock', ahead),
    (f'a tone of {HERTZ:g} Hz, amplitude {100 * TONE:g} % of the peak', 'tone', tone),
    ('voltage and current both 7 % high, power recorded', 'contradiction', both_high),
    ('voltage and current both 7 % high, no power', 'contradiction', lambda r, o: both_high(r, o, ())),
)


def kinds(run: Recording) -> set[str]:
    """What is named of a run."""
    return {kind for _, kind, _ in instrument_faults(run)}


def table(runs: dict[str, Recording]) -> list[str]:
    """The table as lines of markdown."""
    lines = [
        '| put in | stroke: named | something else named | force: named | something else named |',
        '|---|---|---|---|---|',
    ]
    for told, kind, change in FAULTS:
        cells = []
        for channel in ('displacement', 'force'):
            found = [kinds(change(run, run[channel])) for run in runs.values() if channel in run.channels]
            right = f'{sum(kind in names for names in found)} of {len(found)}' if kind else '-'
            cells += [right, f'{sum(bool(names - {kind}) for names in found)} of {len(found)}']
        lines.append(f'| {told} | {" | ".join(cells)} |')
    return lines


def lines_of(data: Path) -> list[str]:
    """The table of the runs of the bench rig."""
    import_map = read_import_map(ROOT / 'config' / 'import_tca_bench_rig.yaml')
    found = import_runs(import_map, lab_files([data / 'tca_bench_rig']))
    runs = {run.name: run.recording for run in found if 'outlier' not in run.name}
    return [*made_today(), *table(runs)]


if __name__ == '__main__':
    show(__doc__, 'faults', lines_of)
