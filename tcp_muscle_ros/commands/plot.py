"""``tcp_muscle plot BAG... [--output PICTURE]``: the channels of bags, one above the other, in a file or a window."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from pathlib import Path

    from tcp_muscle_ros.recording.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``plot``."""
    parser.add_argument(
        'bags', action=Bags, nargs='+', metavar='BAG', help='recordings; several are drawn into one figure'
    )
    parser.add_argument('--output', metavar='PICTURE', help='a new .png, .pdf or .svg (default: a window)')
    add_force_argument(parser)
    add_bag_arguments(parser)


def admit(args: argparse.Namespace) -> tuple[list[Recording], Path | None]:
    """All that can be refused before anything is drawn: the recordings, and where the picture goes."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.files.outputs import OUTPUT, refuse_among
    from tcp_muscle_ros.report.style import picture_path

    output = None
    if args.output is not None:
        refuse_among(args.output, args.bags)
        output = picture_path(args.output, force=args.force, option=OUTPUT)
    return read_bags(args, *args.bags), output


def run(args: argparse.Namespace) -> int:
    """Draw to a file, or in a window until it is closed."""
    from tcp_muscle_ros.files.outputs import in_place_of
    from tcp_muscle_ros.report.recording_figure import draw_recordings
    from tcp_muscle_ros.report.style import save
    from tcp_muscle_ros.report.window import show, window

    if args.output is None:
        figure = window()
        draw_recordings(admit(args)[0], figure)
        show(figure)
        return 0
    recordings, output = admit(args)
    assert output is not None
    drawn = draw_recordings(recordings)
    with in_place_of(output) as draft:
        save(drawn, draft)
    print(f'{output}: {len(args.bags)} recording(s)')
    return 0
