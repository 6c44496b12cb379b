"""``tcp_muscle replay BAG --params P.yaml [--output BAG2] [--figure PNG]``: the model under recorded inputs."""

from __future__ import annotations

import argparse

from tcp_muscle_ros.commands.bag_arguments import add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``replay``."""
    parser.add_argument('bag', metavar='BAG', help='the recording')
    add_parameter_argument(parser, required=True)
    parser.add_argument('--output', metavar='BAG2', help='a new bag: the recording, and the predictions beside it')
    parser.add_argument('--figure', metavar='PNG', help='draw recorded against predicted')
    add_force_argument(parser)
    add_bag_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Replay, print the table, write what was asked for."""
    from tcp_muscle_ros.commands.model_arguments import read_experiments
    from tcp_muscle_ros.diagnosis.answer.replaying import replay
    from tcp_muscle_ros.files.outputs import in_place_of, refuse_among, writable_folder
    from tcp_muscle_ros.report.intervals_file import variants
    from tcp_muscle_ros.report.overlay import write_overlay
    from tcp_muscle_ros.report.tables import comparison_table
    from tcp_muscle_ros.settings.parameter_file import read

    if args.output:
        refuse_among(args.output, [args.bag, args.params])
        output = writable_folder(args.output, force=args.force)
    if args.figure:
        from tcp_muscle_ros.report.comparison import draw_comparison
        from tcp_muscle_ros.report.style import picture_path

        refuse_among(args.figure, [args.bag, args.params])
        figure = picture_path(args.figure, force=args.force)
    parameters = read(args.params).parameters
    (experiment,) = read_experiments(args, [args.bag])
    compared = replay(experiment, parameters, variants(args.params, parameters))
    for note in experiment.notes:
        print(f'note: {note}')
    print(comparison_table(compared))
    if args.output:
        with in_place_of(output) as draft:
            write_overlay(draft, experiment, compared)
        print(f'{args.output}: /recorded and /predicted')
    if args.figure:
        with in_place_of(figure) as draft:
            draw_comparison(draft, experiment, compared)
        print(f'{args.figure}: recorded against predicted')
    return 0
