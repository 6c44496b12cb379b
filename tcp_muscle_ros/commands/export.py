"""``tcp_muscle export BAG --csv [FILE]`` or ``--parquet [FILE]``, or ``--output FILE``: a bag as a table."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tcp_muscle_ros.recording.recording import Array, Recording

_KINDS = ('csv', 'parquet')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``export``."""
    parser.add_argument('bag', action=Bags, metavar='BAG', help='the recording')
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument('--csv', nargs='?', const='', metavar='FILE', help='as CSV (default: BAG.csv in this folder)')
    kind.add_argument(
        '--parquet', nargs='?', const='', metavar='FILE', help='as Parquet (default: BAG.parquet in this folder)'
    )
    parser.add_argument(
        '--output', metavar='FILE', help='the table; its kind is that of its name where neither --csv nor --parquet is'
    )
    add_force_argument(parser)
    add_bag_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Write the table: a row each time, a column each channel with its unit, empty where it has no sample; what holds
    until the next is said, and what is stated in words, in each row."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.files.outputs import OUTPUT, in_place_of, refuse_among, writable_file
    from tcp_muscle_ros.recording.frames import aligned, stated
    from tcp_muscle_ros.recording.table_files import write_csv, write_parquet

    kind, path = _table(args)
    refuse_among(path, [args.bag])
    output = writable_file(path, force=args.force, option=OUTPUT if args.output else f'--{kind}')
    (recording,) = read_bags(args, args.bag)
    time, columns = aligned(recording)
    columns |= _held(recording, time, columns) | stated(recording, len(time))
    with in_place_of(output) as draft:
        (write_csv if kind == 'csv' else write_parquet)(draft, time, columns)
    print(f'{output}: {len(time)} rows, time_s, {", ".join(columns)}')
    return 0


def _table(args: argparse.Namespace) -> tuple[str, str]:
    """Of which kind the table is, and its path. BadInput: neither is said, or two paths."""
    said = [kind for kind in _KINDS if getattr(args, kind) is not None]
    kind = said[0] if said else Path(args.output or '').suffix[1:].lower()
    if kind not in _KINDS:
        raise BadInput(f'{args.output or args.bag}: which table? expected --csv, --parquet, or --output FILE.csv')
    given = getattr(args, kind)
    if given and args.output:
        raise BadInput(f'--{kind} {given} --output {args.output}: two names for one table; expected one')
    return kind, given or args.output or f'{_plain_name(Path(args.bag).resolve())}.{kind}'


def _plain_name(bag: Path) -> str:
    """Of a bag, which is a folder and may have a dot in its name, or of its only file."""
    return bag.name if bag.is_dir() else bag.stem


def _held(recording: Recording, time: Array, columns: Mapping[str, Array]) -> dict[str, Array]:
    """By column name, what holds until the next is said: a command, the load, the room. It may be said when it changes,
    and a column of some cells would be none at import. What an instrument reads of the drive is left as it was read."""
    import numpy as np

    from tcp_muscle_ros.recording.frames import column_name
    from tcp_muscle_ros.recording.recording import CHANNELS, DRIVES

    names = [name for name in recording if CHANNELS[name].role != 'output' and name not in DRIVES]
    held = {}
    for name in names:
        cells = columns[column_name(name)]
        last = np.maximum.accumulate(np.where(np.isfinite(cells), np.arange(len(time)), 0))
        held[column_name(name)] = cells[last]  # empty before the first
    return held
