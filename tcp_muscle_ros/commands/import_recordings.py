"""``tcp_muscle import FILE... --map MAP.yaml --output DIR``: a lab's CSV to bags, one per run of the map."""

from __future__ import annotations

import argparse

from tcp_muscle_ros.files.outputs import add_force_argument


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``import``."""
    parser.add_argument('files', nargs='+', metavar='FILE', help='CSV files, or directories of CSV files')
    parser.add_argument('--map', required=True, metavar='MAP.yaml', help='the import map: what the files hold')
    parser.add_argument('--output', required=True, metavar='DIR', help='a new directory for the bags')
    add_force_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Import all runs; nothing is written unless all of them can be read."""
    from tcp_muscle_ros.files.outputs import in_place_of, refuse_among, writable_folder
    from tcp_muscle_ros.recording.bag_writer import write_recording
    from tcp_muscle_ros.recording.csv_import import csv_files, import_runs, unclaimed
    from tcp_muscle_ros.recording.import_map import read_import_map

    refuse_among(args.output, [*args.files, args.map])
    output = writable_folder(args.output, force=args.force)
    import_map = read_import_map(args.map)
    files = csv_files(args.files)
    runs = list(import_runs(import_map, files))
    with in_place_of(output) as draft:
        for run in runs:
            write_recording(draft / run.name, run.recording)
    for run in runs:
        channels = ', '.join(run.recording.channels)
        print(f'{output / run.name}: {run.recording.duration:.1f} s of {channels}')
        for note in run.recording.notes:
            print(f'  note: {note}')
    for file in unclaimed(import_map, files):
        print(f'note: {file} is no run of {args.map} and was left out')
    print(f'{len(runs)} run(s) imported to {output}')
    return 0
