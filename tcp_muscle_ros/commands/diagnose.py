"""``tcp_muscle diagnose BAG... [--params P.yaml] --output DIR``: which physics the recordings show that is missing.

``--manifest RUNS.yaml`` instead of bags: many runs, each as above (``campaign.py``).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis

_INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``diagnose``."""
    parser.add_argument('bags', nargs='*', metavar='BAG', help='recordings of one muscle')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='DIR', help='a new folder for the report')
    add_force_argument(parser)
    parser.add_argument('--seed', type=int, default=0, metavar='N', help='the same seed gives the same report (0)')
    add_bag_arguments(parser)
    many = parser.add_argument_group('many runs')
    many.add_argument('--manifest', metavar='RUNS.yaml', help='diagnose each run of this list to DIR/NAME, not BAG...')
    many.add_argument('--jobs', type=int, metavar='N', help='how many processes at once (one for each core)')
    many.add_argument('--scheduler', metavar='HOST:PORT', help='run on the workers of this dask scheduler instead')


def run(args: argparse.Namespace) -> int:
    """Diagnose, write the report, print its summary. An interrupted diagnosis writes what it knows by then."""
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.errors import BadInput
    from tcp_muscle_ros.files.outputs import refuse_among
    from tcp_muscle_ros.report.terminal import summary
    from tcp_muscle_ros.report.write import refuse_report

    if args.manifest is not None:
        from tcp_muscle_ros.commands.campaign import run_campaign

        return run_campaign(args)
    if not args.bags:
        raise BadInput('nothing to diagnose: expected BAG..., or --manifest RUNS.yaml')
    for option in ('jobs', 'scheduler'):
        if getattr(args, option) is not None:
            raise BadInput(f'--{option} goes with --manifest RUNS.yaml only')
    refuse_among(args.output, [*args.bags, args.params])
    output = refuse_report(args.output, force=args.force)
    with Progress('diagnosing') as progress:
        diagnosis = diagnose_bags(args, args.bags, args.params, output, progress, force=args.force)
    print(summary(diagnosis, output / 'report.html'))
    return _INTERRUPTED if diagnosis.partial else 0


def diagnose_bags(
    options: argparse.Namespace,
    bags: Sequence[str],
    params: str,
    output: Path,
    progress: Progress | None = None,
    *,
    force: bool = False,
) -> Diagnosis:
    """Diagnose bags of one muscle and write the report; partial where it was interrupted.

    ``options``: the seed and how bags are read (``add_bag_arguments``). ``force``: an older report is replaced.
    Raises BadInput.
    """
    from dataclasses import replace

    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.diagnosis.answer.improved import with_replay
    from tcp_muscle_ros.diagnosis.answer.issues import with_faults, with_issues
    from tcp_muscle_ros.diagnosis.diagnose import Interrupted, diagnose
    from tcp_muscle_ros.diagnosis.observation.observe import prepared
    from tcp_muscle_ros.report.write import write_report
    from tcp_muscle_ros.settings.parameter_file import read

    nominal = read(params)
    recordings = read_bags(options, *bags)
    mended, experiments = prepared(recordings, nominal)
    beat = progress.beat if progress else None
    try:
        diagnosis = diagnose(experiments, nominal.parameters, seed=options.seed, progress=beat)
    except Interrupted as stop:
        diagnosis = replace(stop.partial, partial=True)
    diagnosis = with_faults(with_issues(diagnosis, recordings, mended, experiments), mended)
    del mended
    diagnosis = with_replay(diagnosis, recordings, nominal.operating)
    if progress:
        progress.stage('writing the report')
    write_report(output, diagnosis, experiments, nominal.operating, force=force)
    return diagnosis
