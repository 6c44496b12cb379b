"""``tcp_muscle diagnose BAG... [--params P.yaml] --output DIR``: which physics the recordings show that is missing.

``--manifest RUNS.yaml`` instead of bags: many runs, each as above (``campaign.py``).
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments
from tcp_muscle_ros.commands.calibrate import add_separate_argument, refuse_unknown
from tcp_muscle_ros.commands.exit_codes import DONE, INTERRUPTED
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``diagnose``."""
    parser.add_argument('bags', action=Bags, nargs='*', metavar='BAG', help='recordings of one muscle')
    add_parameter_argument(parser)
    add_separate_argument(parser)
    parser.add_argument(
        '--rig',
        metavar='RIG.yaml',
        help='what is known of the rig: its instruments, and the currents, temperatures and loads that it can do',
    )
    parser.add_argument('--output', required=True, metavar='DIR', help='a new folder for the report')
    add_force_argument(parser)
    add_bag_arguments(parser)
    many = parser.add_argument_group('many runs')
    many.add_argument('--manifest', metavar='RUNS.yaml', help='diagnose each run of this list, into DIR/NAME')
    many.add_argument('--jobs', type=int, metavar='N', help='number of parallel processes (default: one for each core)')
    many.add_argument('--scheduler', metavar='HOST:PORT', help='run on the workers of this dask scheduler instead')


def admit(args: argparse.Namespace) -> None:
    """All that can be refused before the diagnosis; of a manifest, what stands in it."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.diagnosis.observation.observe import prepared
    from tcp_muscle_ros.settings.parameter_file import read

    _refuse_rig(args)
    if args.manifest is not None:
        from tcp_muscle_ros.commands.campaign import admit_campaign

        admit_campaign(args)
        return
    _output(args)
    prepared(read_bags(args, *args.bags), read(args.params))


def _refuse_rig(args: argparse.Namespace) -> None:
    """BadInput where what is known of the rig cannot be read, or does what no model of an instrument describes."""
    from tcp_muscle_ros.settings.rig import read_rig

    if args.rig:
        read_rig(args.rig).sensor_effects()


def _output(args: argparse.Namespace) -> Path:
    """The folder of the report. BadInput for options that do not go together, or where nothing can be written."""
    from tcp_muscle_ros.errors import BadInput
    from tcp_muscle_ros.files.outputs import refuse_among
    from tcp_muscle_ros.report.write import refuse_report

    if not args.bags:
        raise BadInput('nothing to diagnose: expected BAG..., or --manifest RUNS.yaml')
    for option in ('jobs', 'scheduler'):
        if getattr(args, option) is not None:
            raise BadInput(f'--{option} goes with --manifest RUNS.yaml only')
    refuse_unknown(args.separate)
    refuse_among(args.output, [*args.bags, args.params, *filter(None, [args.rig])])
    return refuse_report(args.output, force=args.force)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write the report, print its summary. An interrupted diagnosis writes what it knows by then."""
    from tcp_muscle_ros.commands.one_diagnosis import diagnose_bags
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.process.compiling import tell_of_compiling
    from tcp_muscle_ros.report.terminal import summary

    tell_of_compiling()
    _refuse_rig(args)
    if args.manifest is not None:
        from tcp_muscle_ros.commands.campaign import run_campaign

        return run_campaign(args)
    output = _output(args)
    with Progress('diagnosing') as progress:
        diagnosis = diagnose_bags(args, args.bags, args.params, output, progress, force=args.force)
    print(summary(diagnosis, output / 'report.html'))
    return INTERRUPTED if diagnosis.partial else DONE
