"""``tcp_muscle replay BAG --params P.yaml [--output BAG2] [--figure PNG]``: the model under recorded inputs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, NamedTuple

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
    from tcp_muscle_ros.muscle import Parameters
    from tcp_muscle_ros.recording.recording import Recording
    from tcp_muscle_ros.settings.parameter_file import ParameterFile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``replay``."""
    parser.add_argument('bag', action=Bags, metavar='BAG', help='the recording')
    add_parameter_argument(parser, required=True)
    parser.add_argument('--output', metavar='BAG2', help='a new bag with the recording and the predictions')
    parser.add_argument('--figure', metavar='PNG', help='draw recorded against predicted')
    parser.add_argument('--rig', metavar='RIG.yaml', help='properties of the instruments, as written by diagnose')
    parser.add_argument(
        '--as-given',
        action='store_true',
        help='fit nothing: take room and zeros as stated (default: they are fitted to the recording)',
    )
    add_force_argument(parser)
    add_bag_arguments(parser)


class Admitted(NamedTuple):
    """What a replay needs, once all of it is known to be good: ``others`` are muscles within the intervals."""

    output: Path | None
    figure: Path | None
    file: ParameterFile
    muscle: Parameters
    others: Mapping[int, Parameters] | None
    recording: Recording
    experiment: Experiment


def admit(args: argparse.Namespace) -> Admitted:
    """All that can be refused before anything is replayed."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.diagnosis.observation.observe import whole
    from tcp_muscle_ros.files.outputs import refuse_among, writable_folder
    from tcp_muscle_ros.settings.ages import as_recorded
    from tcp_muscle_ros.settings.intervals import variants
    from tcp_muscle_ros.settings.parameter_file import read
    from tcp_muscle_ros.settings.rig import read_rig

    output = figure = None
    inputs = [args.bag, args.params, *([args.rig] if args.rig else [])]
    if args.output:
        refuse_among(args.output, inputs)
        output = writable_folder(args.output, force=args.force)
    if args.figure:
        from tcp_muscle_ros.report.style import picture_path

        refuse_among(args.figure, inputs)
        figure = picture_path(args.figure, force=args.force)
    file = read(args.params)
    rig = read_rig(args.rig) if args.rig else None
    (recording,) = read_bags(args, args.bag)
    muscle = as_recorded(file.parameters, args.params, rig, recording)
    (experiment,) = whole([recording], file)
    return Admitted(output, figure, file, muscle, variants(args.params, muscle), recording, experiment)


def run(args: argparse.Namespace) -> int:
    """Replay, print the table, write what was asked for."""
    from tcp_muscle_ros.diagnosis.answer.replaying import SETTLED_BY, own_of, replay
    from tcp_muscle_ros.diagnosis.observation.observe import conditions
    from tcp_muscle_ros.diagnosis.observation.prepare import prepare
    from tcp_muscle_ros.files.outputs import in_place_of
    from tcp_muscle_ros.process.compiling import tell_of_compiling
    from tcp_muscle_ros.report.overlay import write_overlay
    from tcp_muscle_ros.report.tables import comparison_table, own_note

    tell_of_compiling()
    output, figure, file, muscle, others, recording, experiment = admit(args)
    settled = None if args.as_given else prepare(recording, file.parameters, conditions(file), SETTLED_BY)
    own = None if settled is None else own_of(settled, muscle)
    compared = replay(experiment, muscle, others, own)
    for note in experiment.notes:
        print(f'note: {note}')
    print(comparison_table(compared))
    if own is not None and own.fitted:
        print(own_note(own))
        if own.strayed:
            print(f'warning: {own.warning} (--as-given takes the room as stated)')
    if output:
        with in_place_of(output) as draft:
            write_overlay(draft, experiment, compared)
        band = ', with its band /predicted_low to /predicted_high' if others else ''
        print(f'{args.output}: /recorded and /predicted{band}')
    if figure:
        from tcp_muscle_ros.report.comparison import draw_comparison

        with in_place_of(figure) as draft:
            draw_comparison(draft, experiment, compared)
        print(f'{args.figure}: recorded against predicted')
    return 0
