"""``tcp_muscle record --output BAG``: a muscle's topics to a bag, until Ctrl-C."""

from __future__ import annotations

import argparse
import math

from tcp_muscle_ros.errors import BadInput, needs_ros
from tcp_muscle_ros.files.outputs import add_force_argument, writable_folder


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``record``."""
    parser.add_argument('--output', required=True, metavar='BAG', help='a new bag, which is a folder')
    parser.add_argument('--duration', type=float, metavar='S', help='stop this many seconds after the first message')
    parser.add_argument('--namespace', default='', metavar='NS', help="where the muscle's topics are (default: /)")
    add_force_argument(parser)
    add_topic_argument(parser)
    parser.add_argument('--use-sim-time', action='store_true', help='take log times from /clock')


def add_topic_argument(parser: argparse.ArgumentParser) -> None:
    """Add --topic."""
    parser.add_argument(
        '--topic',
        action='append',
        default=[],
        metavar='TOPIC',
        help="one more topic, of a message type that comes with ROS 2, relative to the muscle's namespace or absolute; "
        'may be repeated',
    )


def admit(args: argparse.Namespace) -> None:
    """All that can be refused before a node is there."""
    if args.duration is not None and not (math.isfinite(args.duration) and args.duration > 0):
        raise BadInput(f'--duration {args.duration:g}: expected a number of seconds > 0')
    writable_folder(args.output, force=args.force)


def run(args: argparse.Namespace) -> int:
    """Record."""
    admit(args)
    try:
        from tcp_muscle_ros.nodes.recorder import record
    except ImportError as error:
        raise needs_ros(error) from None
    return record(
        args.output,
        namespace=args.namespace,
        duration=args.duration,
        use_sim_time=args.use_sim_time,
        force=args.force,
        topics=args.topic,
        say=lambda sentence: print(sentence, flush=True),
    )
