"""The arguments shared by the commands that run the model, and recordings prepared for it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.experiment import Experiment
    from tcp_muscle_ros.diagnosis.holding import Conditions
    from tcp_muscle_ros.parameter_file import ParameterFile

DEFAULT_SET = 'karami_tadesse_2017'


def add_parameter_argument(parser: argparse.ArgumentParser, *, required: bool = False) -> None:
    """Add --params."""
    parser.add_argument(
        '--params',
        metavar='PARAMS.yaml',
        required=required,
        default=None if required else DEFAULT_SET,
        help='a ROS parameter file of the muscle, or the name of a shipped set'
        + ('' if required else f' ({DEFAULT_SET})'),
    )


def conditions(file: ParameterFile) -> Conditions:
    """What the parameter file says of the run: load, ambient, end. Only what stands in it."""
    from tcp_muscle_ros.diagnosis.holding import Conditions
    from tcp_muscle_ros.muscle import ZERO_CELSIUS

    given = file.operating
    return Conditions(
        load=file.number('load_n') if 'load_n' in given else None,
        ambient=file.number('ambient_temperature_c') + ZERO_CELSIUS if 'ambient_temperature_c' in given else None,
        end=file.text('end') if 'end' in given else None,
        held_length=file.number('held_length_m'),
        spring_rate=file.number('spring_rate_n_per_m'),
        spring_rest_length=file.number('spring_rest_length_m'),
    )


def read_experiments(args: argparse.Namespace, paths: list[str], most: int | None = None) -> list[Experiment]:
    """Read bags as the shared arguments say and make them ready for the model."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.diagnosis.prepare import prepare
    from tcp_muscle_ros.parameter_file import read

    file = read(args.params)
    return [
        prepare(recording, file.parameters, conditions(file), most)
        for path in paths
        for recording in read_bags(args, path)
    ]
