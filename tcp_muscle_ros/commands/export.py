"""``tcp_muscle export BAG --csv [FILE]`` or ``--parquet [FILE]``: a bag as a table."""

from __future__ import annotations

import argparse
from pathlib import Path

from tcp_muscle_ros.commands.bag_arguments import Bags, add_bag_arguments
from tcp_muscle_ros.files.outputs import add_force_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``export``."""
    parser.add_argument('bag', action=Bags, metavar='BAG', help='the recording')
    kind = parser.add_mutually_exclusive_group(required=True)
    kind.add_argument('--csv', nargs='?', const='', metavar='FILE', help='as CSV (default: BAG.csv in this folder)')
    kind.add_argument(
        '--parquet', nargs='?', const='', metavar='FILE', help='as Parquet (default: BAG.parquet in this folder)'
    )
    add_force_argument(parser)
    add_bag_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Write the table: a row each time, a column each channel with its unit, empty where it has no sample; what is
    stated in words, in each row."""
    from tcp_muscle_ros.commands.bag_arguments import read_bags
    from tcp_muscle_ros.files.outputs import in_place_of, refuse_among, writable_file
    from tcp_muscle_ros.recording.frames import aligned, stated
    from tcp_muscle_ros.recording.table_files import write_csv, write_parquet

    kind, given = ('csv', args.csv) if args.csv is not None else ('parquet', args.parquet)
    path = given or f'{Path(args.bag).resolve().stem}.{kind}'
    refuse_among(path, [args.bag])
    output = writable_file(path, force=args.force, option=f'--{kind}')
    (recording,) = read_bags(args, args.bag)
    time, columns = aligned(recording)
    columns |= stated(recording, len(time))
    with in_place_of(output) as draft:
        (write_csv if kind == 'csv' else write_parquet)(draft, time, columns)
    print(f'{output}: {len(time)} rows, time_s, {", ".join(columns)}')
    return 0
