"""The arguments shared by the commands that run the model."""

from __future__ import annotations

import argparse

from tcp_muscle_ros.settings.operating import DEFAULT_SET


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
