"""The arguments shared by all commands that read bags."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tcp_muscle_ros.errors import BadInput

if TYPE_CHECKING:
    from tcp_muscle_ros.recording.recording import Recording


def add_bag_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --namespace, --channel and --unit."""
    parser.add_argument(
        '--namespace', metavar='NS', help="where the muscle's topics are, if several namespaces have some"
    )
    parser.add_argument(
        '--channel',
        action='append',
        default=[],
        metavar='NAME=TOPIC[.FIELD]',
        help='take a channel (temperature, resistance, current ...) from any numeric field of any topic, e.g. '
        'displacement=/laser/range.range (repeatable)',
    )
    parser.add_argument(
        '--unit',
        action='append',
        default=[],
        metavar='NAME=UNIT',
        help='the unit in which a channel was recorded, e.g. displacement=mm or temperature=degF; a minus turns the '
        'sign, as in displacement=-mm (repeatable)',
    )


def read_bags(args: argparse.Namespace, *paths: str) -> list[Recording]:
    """The bags at `paths`, read as the shared arguments say."""
    from tcp_muscle_ros.recording.bag import read_bag

    channels = _pairs(args.channel, '--channel', 'NAME=TOPIC[.FIELD]')
    units = _pairs(args.unit, '--unit', 'NAME=UNIT')
    return [read_bag(path, namespace=args.namespace, channels=channels, units=units) for path in paths]


def reading_options(args: argparse.Namespace) -> tuple[str, ...]:
    """The shared arguments as they would be typed again."""
    namespace = ['--namespace', args.namespace] if args.namespace else []
    named = [('--channel', item) for item in args.channel] + [('--unit', item) for item in args.unit]
    return (*namespace, *(word for pair in named for word in pair))


def _pairs(items: list[str], option: str, form: str) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for item in items:
        name, equals, value = item.partition('=')
        if not (name and equals and value):
            raise BadInput(f'{option} {item}: expected {option} {form}')
        if name in pairs:
            raise BadInput(f"{option} {item}: '{name}' is given twice")
        pairs[name] = value
    return pairs
