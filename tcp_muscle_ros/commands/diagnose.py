"""``tcp_muscle diagnose BAG... [--params P.yaml] --output DIR``: which physics the recordings show that is missing."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.experiment import Experiment
    from tcp_muscle_ros.diagnosis.findings import Diagnosis
    from tcp_muscle_ros.recording.recording import Recording

# More observations a channel than this are averaged in blocks: a muscle is slow, and time and memory stay bounded.
_MOST = 4000
_INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``diagnose``."""
    parser.add_argument('bags', nargs='+', metavar='BAG', help='recordings of one muscle')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='DIR', help='a new folder for the report')
    parser.add_argument('--seed', type=int, default=0, metavar='N', help='the same seed gives the same report (0)')
    add_bag_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write the report, print its summary. An interrupted diagnosis writes what it knows by then."""
    from dataclasses import replace

    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.commands.model_arguments import conditions
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.diagnosis.diagnose import Interrupted, diagnose
    from tcp_muscle_ros.diagnosis.experiment import prepare
    from tcp_muscle_ros.parameter_file import read
    from tcp_muscle_ros.report.terminal import summary
    from tcp_muscle_ros.report.write import refuse_report, write_report

    output = refuse_report(args.output)
    nominal = read(args.params)
    recordings = read_bags(args, *args.bags)
    experiments = [prepare(r, nominal.parameters, conditions(nominal), _MOST) for r in recordings]
    code = 0
    with Progress('diagnosing') as progress:
        try:
            diagnosis = diagnose(experiments, nominal.parameters, seed=args.seed, progress=progress.beat)
        except Interrupted as stop:
            diagnosis, code = replace(stop.partial, partial=True), _INTERRUPTED
        diagnosis = with_issues(diagnosis, recordings, experiments)
        progress.stage('writing the report')
        write_report(output, diagnosis, experiments, nominal.operating)
    print(summary(diagnosis, output / 'report.html'))
    return code


def with_issues(diagnosis: Diagnosis, recordings: Sequence[Recording], experiments: Sequence[Experiment]) -> Diagnosis:
    """The diagnosis with what the checks, the reader and the preparation say of each recording."""
    from dataclasses import replace

    from tcp_muscle_ros.recording.checks import check

    told = []
    for summary, recording, experiment in zip(diagnosis.recordings, recordings, experiments, strict=True):
        issues = [*summary.issues, *(issue.sentence for issue in check(recording))]
        issues += [*experiment.notes, *_averaged(experiment)]
        told.append(replace(summary, issues=tuple(dict.fromkeys(issues))))
    return replace(diagnosis, recordings=tuple(told))


def _averaged(experiment: Experiment) -> list[str]:
    """Which channels were averaged in blocks, and in how long ones."""
    widest = {name: int(o.count.max()) for name, o in experiment.observed.items() if o.count.max() > 1}
    told = ', '.join(f'{name} ({width})' for name, width in widest.items())
    return [f'averaged in blocks of up to so many samples: {told}'] if told else []
