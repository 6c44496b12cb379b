"""``tcp_muscle info BAG...``: what is in bags."""

from __future__ import annotations

import argparse

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``info``."""
    parser.add_argument('bags', action=Bags, nargs='+', metavar='BAG', help='recordings')
    add_bag_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Print a table of each bag's channels, what is known of the run, and what the checks say."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.report.recording_summary import described

    for bag in args.bags:
        for recording in read_bags(args, bag):
            print(described(recording))
    return 0
