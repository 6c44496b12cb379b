#!/usr/bin/env python3
"""Calibrate the paper's model to every run of two public rigs, and say per run how far it stays from the recording.

    python scripts/real_recordings.py [--data ../shared/data] [--diagnose] [--write]

Prints the tables of docs/real_recordings.md; with --write puts them between its markers and draws its figures. With
--diagnose it prints (or writes) instead what the diagnosis says of each group. The data are read where they lie (see
docs/real_recordings.md); without them the script says so and ends.
"""

import argparse
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
from real_diagnoses import (
    HEADING,
    MOST,
    diagnose_group,
    different,
    forced_air,
    paragraphs,
    required,
    row,
    table_of_splits,
)
from real_figures import channel_of, draw_repeated

from tcp_muscle_ros.diagnosis.fitting.calibration import Calibration, Estimate, calibrate
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.csv_import import import_runs, lab_files
from tcp_muscle_ros.recording.import_map import read_import_map
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.marked import replace_marked
from tcp_muscle_ros.report.style import PREDICTED, RECORDED, canvas, save

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / 'docs' / 'real_recordings.md'
IMAGES = ROOT / 'docs' / 'images'
NOMINAL = Parameters.named('karami_tadesse_2017')


@dataclass(frozen=True)
class Group:
    """Runs that share a muscle's heat exchange and capacity; the gain is each run's own."""

    title: str
    rig: str
    starts: tuple[str, ...]
    leave_out: str = 'outlier'


GROUPS = (
    Group('bench rig, stroke', 'bench', ('stroke_',)),
    Group('bench rig, blocked force', 'bench', ('force_1W', 'force_2W', 'force_3W', 'force_4W')),
    Group('bench rig, blocked force, earlier set', 'bench', ('force_trial1',)),
    Group('video rig, mandrel-coiled, free air', 'video', ('mandrel_1W_free', 'mandrel_3W_free')),
    Group('video rig, mandrel-coiled, forced air', 'video', ('mandrel_3W_forced',)),
    Group('video rig, mandrel-coiled, step', 'video', ('mandrel_3W_step',)),
    Group('video rig, self-coiled, free air', 'video', ('self_coiled',)),
)


def experiments(data: Path, most: int | None = None) -> dict[str, Experiment]:
    """Every run of both rigs by name, ready for the model; of at most so many samples."""
    found = {}
    for rig in ('bench', 'video'):
        import_map = read_import_map(ROOT / 'config' / f'import_tca_{rig}_rig.yaml')
        for run in import_runs(import_map, lab_files([data / f'tca_{rig}_rig'])):
            found[run.name] = prepare(run.recording, NOMINAL, most=most)
    return found


def nrmse(calibration: Calibration, k: int) -> float:
    """RMSE of recording k over its recorded peak to peak."""
    experiment = calibration.fit.problem.experiments[k]
    name = channel_of(experiment)
    return calibration.rmse()[name][k] / float(np.ptp(experiment.observed[name].value))


def shown_estimate(found: Sequence[Estimate], name: str, recording: int | None = None) -> str:
    """A value with its interval, or that the data do not fix it."""
    for e in found:
        if e.name == name and e.recording in (recording, None):
            return f'{e.value:.3g} ({e.low:.3g} to {e.high:.3g})' if e.fixed else 'not fixed'
    return '-'


def group_rows(group: Group, all_runs: dict[str, Experiment]) -> tuple[list[str], Calibration, list[str]]:
    """Table rows of a group: each run by itself, and with heat exchange and capacity shared."""
    names = sorted(n for n in all_runs if n.startswith(group.starts) and not (group.leave_out and group.leave_out in n))
    runs = [all_runs[n] for n in names]
    together = calibrate(runs, NOMINAL, separate=('B',))
    rows = []
    for k, (name, run) in enumerate(zip(names, runs, strict=True)):
        print(f'  {name}', file=sys.stderr, flush=True)
        alone = calibrate([run], NOMINAL)
        observed = run.observed[channel_of(run)]
        unit, factor = ('mm', 1e3) if channel_of(run) == 'displacement' else ('mN', 1e3)
        rows.append(
            f'| {name} | {float(np.ptp(observed.value)) * factor:.3g} {unit} | {100 * nrmse(alone, 0):.1f} % '
            f'| {100 * nrmse(together, k):.1f} % | {shown_estimate(alone.combinations, "C/hA")} '
            f'| {"at the melting limit" if alone.held_by_melting else shown_estimate(alone.estimates, "hA")} |'
        )
    return rows, together, names


def draw(group: Group, together: Calibration, names: list[str]) -> Path:
    """Recorded and fitted, and what is left, one column a power (the first run of each)."""
    powers: dict[str, int] = {}
    for k, name in enumerate(names):
        powers.setdefault(name.rsplit('_', 1)[0], k)
    picked = list(powers.values())[:4]
    figure, axes = canvas(2, len(picked), width=3.2 * len(picked) + 1.0, height=2.4, sharex='col')
    for column, k in enumerate(picked):
        problem = together.fit.problem
        experiment = problem.experiments[k]
        name = channel_of(experiment)
        o = experiment.observed[name]
        left = together.fit.left[k][name]
        top, bottom = axes[column], axes[len(picked) + column]
        top.plot(o.time, shown(name, o.value), color=RECORDED, linewidth=1.1, label='recorded')
        top.plot(o.time, shown(name, o.value - left), color=PREDICTED, linewidth=1.2, label="the paper's model")
        bottom.plot(o.time, 100 * left / np.ptp(o.value), color=RECORDED, linewidth=0.9)
        bottom.axhline(0.0, color=PREDICTED, linewidth=0.8)
        on = experiment.imposed.drive > 0.0
        for axis in (top, bottom):
            low, high = axis.get_ylim()
            axis.fill_between(
                experiment.imposed.time, low, high, where=on, step='post', color='#CC79A7', alpha=0.12, linewidth=0
            )
            axis.set_ylim(low, high)
        top.set_title(names[k], fontsize=9)
        bottom.set_xlabel('time (s), shaded: heated')
        if column == 0:
            top.set_ylabel(CHANNEL_AXIS[name])
            bottom.set_ylabel('recorded - model\n(% of peak)')
    lines = axes[0].get_legend_handles_labels()
    figure.legend(*lines, loc='outside lower center', ncols=2, fontsize=8, frameon=False)
    path = IMAGES / f'real_{group.title.replace(",", "").replace(" ", "_")}.png'
    save(figure, path)
    return path


def diagnoses(all_runs: dict[str, Experiment], splits: int, write: bool, of: str = '') -> list[str]:
    """The table of errors and what the diagnosis says of each group, as lines of markdown, and the test whose answer is
    known; with ``write`` a figure of each group. ``of``: of the groups alone whose title has it."""
    rows, lines, every = [], [], []
    for group in [g for g in GROUPS if of in g.title]:
        begun = time.monotonic()
        names = [n for n in all_runs if n.startswith(group.starts) and group.leave_out not in n]
        mine = {n: all_runs[n] for n in names}
        found = [diagnose_group(group.title, mine, NOMINAL, split) for split in different(mine, splits)]
        rows.append(row(found))
        every += found
        lines += paragraphs(found[0])
        if len(found) > 1:
            lines += table_of_splits(found)
        if write:
            path = IMAGES / f'repeated_{group.title.replace(",", "").replace(" ", "_")}.png'
            draw_repeated(mine, found[0], path)
            lines += [f'![{group.title}: runs, band, models]({path.relative_to(PAGE.parent)})', '']
        print(f'{group.title}: {time.monotonic() - begun:.0f} s', file=sys.stderr, flush=True)
    free = [run for name, run in sorted(all_runs.items()) if name.startswith('mandrel_3W_free')]
    forced = [run for name, run in sorted(all_runs.items()) if name.startswith('mandrel_3W_forced')]
    made = (
        f'Made on {date.today()} on {os.cpu_count()} cores by `python scripts/real_recordings.py --diagnose --splits '
        f'{splits} --write`. {required(every)}'
    )
    known = [] if of else forced_air(free, forced, NOMINAL)
    return [made, '', HEADING, *rows, '', *lines, *known]


def main() -> int:
    """Print the tables; with --write update the page and the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--data', type=Path, default=ROOT.parent / 'shared' / 'data')
    parser.add_argument('--write', action='store_true')
    parser.add_argument('--diagnose', action='store_true', help='what the diagnosis says of each group')
    parser.add_argument('--splits', type=int, default=1, help='of training and unseen runs, with --diagnose')
    parser.add_argument('--group', default='', help='with --diagnose: print only those groups whose title has this')
    args = parser.parse_args()
    if args.group and args.write:
        parser.error('--group prints; the page has all groups')
    if not args.data.is_dir():
        print(f'{args.data}: not there, so nothing can be calibrated', file=sys.stderr)
        return 2
    if args.diagnose:
        text = '\n'.join(diagnoses(experiments(args.data, most=MOST), args.splits, args.write, args.group))
        if args.write:
            replace_marked(PAGE, 'diagnoses', text)
        else:
            print(text)
        return 0
    all_runs = experiments(args.data)
    lines = []
    for group in GROUPS:
        print(group.title, file=sys.stderr, flush=True)
        rows, together, names = group_rows(group, all_runs)
        lines += [
            f'### {group.title[0].upper()}{group.title[1:]}',
            '',
            f'Shared by the group: C/hA = {shown_estimate(together.combinations, "C/hA")} s, '
            f'hA = {shown_estimate(together.estimates, "hA")} W/K'
            f'{" (held by the melting limit)" if together.held_by_melting else ""}.',
            '',
            '| run | peak to peak | RMSE, run alone | RMSE, hA and C shared | C/hA alone, s | hA alone, W/K |',
            '|---|---|---|---|---|---|',
            *rows,
            '',
        ]
        if args.write:
            path = draw(group, together, names)
            lines += [f'![{group.title}]({path.relative_to(PAGE.parent)})', '']
    text = '\n'.join(lines)
    if args.write:
        replace_marked(PAGE, 'runs', text)
    else:
        print(text)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
