"""The arguments shared by all commands that read bags."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.order import by_number
from tcp_muscle_ros.files.outputs import IMPORT_MAP

if TYPE_CHECKING:
    from tcp_muscle_ros.recording.recording import Recording


class Bags(argparse.Action):
    """The bags that are named; of a folder that ``tcp_muscle import`` made, those in it."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """As argparse calls it."""
        named = [values] if isinstance(values, str) else list(values or ())
        bags = bags_among(named)
        one = isinstance(values, str)
        setattr(namespace, self.dest, (bags if len(bags) == 1 else named)[0] if one else bags)


def bags_among(named: Sequence[str]) -> list[str]:
    """The bags of a command line, each once; ``FOLDER/*`` of an imported folder names its map, too.

    A bag that counted twice would show how well a muscle repeats itself, and know it the more surely.
    """
    found: list[str] = []
    for path in named:
        if Path(path).name == IMPORT_MAP and len(named) > 1:
            continue
        runs = Path(path).iterdir() if (Path(path) / IMPORT_MAP).is_file() else ()
        found += [str(run) for run in sorted(runs, key=by_number) if run.is_dir()] or [path]
    once: dict[str, str] = {}
    for path in found:
        once.setdefault(os.path.realpath(path), path)
    return list(once.values())


def add_bag_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --namespace, --channel and --unit."""
    parser.add_argument(
        '--namespace', metavar='NS', help="where the muscle's topics are, if several namespaces have some"
    )
    add_channel_argument(parser)
    add_unit_argument(parser)


def add_channel_argument(parser: argparse.ArgumentParser) -> None:
    """Add --channel."""
    parser.add_argument(
        '--channel',
        action='append',
        default=[],
        metavar='NAME=TOPIC[.FIELD]',
        help='take a channel (temperature, resistance, current ...) from any numeric field of any topic, e.g. '
        'displacement=/laser/range.range (repeatable)',
    )


def add_unit_argument(parser: argparse.ArgumentParser) -> None:
    """Add --unit."""
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
    units = stated_units(args)
    return [read_bag(path, namespace=args.namespace, channels=channels, units=units) for path in paths]


def stated_units(args: argparse.Namespace) -> dict[str, str]:
    """What ``--unit`` says: channel -> unit, as they were typed."""
    return _pairs(args.unit, '--unit', 'NAME=UNIT')


def other_topics(args: argparse.Namespace) -> tuple[str, ...]:
    """The topics that ``--channel`` names."""
    named = _pairs(args.channel, '--channel', 'NAME=TOPIC[.FIELD]').values()
    return tuple(dict.fromkeys(topic.partition('.')[0] for topic in named))


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
