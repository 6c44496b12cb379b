"""``tcp_muscle calibrate BAG... [--params P.yaml] --output MUSCLE.yaml``: the paper's parameters of a given muscle."""

from __future__ import annotations

import argparse

from tcp_muscle_ros.commands.bag_arguments import add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument

# More observations a channel than this are averaged in blocks: a muscle is slow, and the fit stays within seconds.
_MOST = 4000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``calibrate``."""
    parser.add_argument('bags', nargs='+', metavar='BAG', help='recordings of one muscle')
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='MUSCLE.yaml', help='the parameter file to write')
    parser.add_argument(
        '--separate',
        action='append',
        default=[],
        metavar='NAME',
        help='a parameter that each recording has for itself, e.g. B where every run is another specimen (repeatable)',
    )
    add_force_argument(parser)
    add_bag_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, print the table, write the parameter file and its intervals."""
    from tcp_muscle_ros.commands.model_arguments import read_experiments
    from tcp_muscle_ros.commands.progress import Progress
    from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
    from tcp_muscle_ros.diagnosis.hypothesis.unknowns import SEPARABLE
    from tcp_muscle_ros.diagnosis.observation.admission import refuse_still
    from tcp_muscle_ros.errors import BadInput, nearest
    from tcp_muscle_ros.files.outputs import in_place_of, refuse_among, writable_file
    from tcp_muscle_ros.report.intervals_file import path_beside, write_intervals
    from tcp_muscle_ros.report.tables import calibration_note, calibration_table
    from tcp_muscle_ros.settings.parameter_file import read, write

    for name in args.separate:
        if name not in SEPARABLE:
            raise BadInput(f'--separate {name}: expected one of {", ".join(SEPARABLE)}{nearest(name, SEPARABLE)}')
    refuse_among(args.output, [*args.bags, args.params])
    output = writable_file(args.output, force=args.force)
    intervals = writable_file(path_beside(output), force=args.force)
    nominal = read(args.params)
    experiments = read_experiments(args, args.bags, _MOST)
    refuse_still(experiments)
    with Progress('calibrating') as progress:
        calibration = calibrate(experiments, nominal.parameters, separate=args.separate, progress=progress.beat)
    for experiment in experiments:
        for note in experiment.notes:
            print(f'note: {experiment.name}: {note}')
    print(calibration_table(calibration))
    heading = f'Calibrated by tcp_muscle calibrate on {len(experiments)} recording(s), from {args.params}.'
    says = calibration_note(calibration)
    with in_place_of(intervals) as beside, in_place_of(output) as draft:
        write(draft, calibration.parameters, operating=nominal.operating, heading=(heading,), note=says)
        write_intervals(beside, calibration)
    print(f'{output}: loads into sim_node and replay; its intervals are beside it')
    return 0
