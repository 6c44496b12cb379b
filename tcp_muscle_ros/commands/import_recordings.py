"""``tcp_muscle import FILE... --map MAP.yaml --output DIR``: a lab's CSV to bags, one per run of the map."""

from __future__ import annotations

import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``import``."""
    parser.add_argument('files', nargs='+', metavar='FILE', help='CSV files, or directories of CSV files')
    parser.add_argument('--map', required=True, metavar='MAP.yaml', help='the import map: what the files hold')
    parser.add_argument('--output', required=True, metavar='DIR', help='a new directory for the bags')


def run(args: argparse.Namespace) -> int:
    """Import all runs; nothing is written unless all of them can be read."""
    from tcp_muscle_ros.outputs import writable_folder
    from tcp_muscle_ros.recording.bag_writer import refuse_existing, write_recording
    from tcp_muscle_ros.recording.csv_import import csv_files, import_runs, unclaimed
    from tcp_muscle_ros.recording.import_map import read_import_map

    output = writable_folder(refuse_existing(args.output))
    import_map = read_import_map(args.map)
    files = csv_files(args.files)
    runs = list(import_runs(import_map, files))
    for run in runs:
        write_recording(output / run.name, run.recording)
        channels = ', '.join(run.recording.channels)
        print(f'{output / run.name}: {run.recording.duration:.1f} s of {channels}')
        for note in run.recording.notes:
            print(f'  note: {note}')
    for file in unclaimed(import_map, files):
        print(f'note: {file} is no run of {args.map} and was left out')
    print(f'{len(runs)} run(s) imported to {output}')
    return 0
