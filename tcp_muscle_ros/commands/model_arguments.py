"""The arguments shared by the commands that run the model, and recordings prepared for it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tcp_muscle_ros.settings.operating import DEFAULT_SET

if TYPE_CHECKING:
    from tcp_muscle_ros.diagnosis.observation.experiment import Experiment


def add_parameter_argument(parser: argparse.ArgumentParser, *, required: bool = False) -> None:
    """Add --params."""
    parser.add_argument(
        '--params',
        metavar='PARAMS.yaml',
        required=required,
        default=None if required else DEFAULT_SET,
        help='a ROS parameter file of the muscle, or the name of a shipped set'
        + (f', e.g. {DEFAULT_SET}' if required else f' (default: {DEFAULT_SET})'),
    )


def read_experiments(args: argparse.Namespace, paths: list[str], most: int | None = None) -> list[Experiment]:
    """Read bags as the shared arguments say and make them ready for the model; BadInput as the gate says."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.diagnosis.observation.observe import whole
    from tcp_muscle_ros.settings.parameter_file import read

    return whole(read_bags(args, *paths), read(args.params), most)
