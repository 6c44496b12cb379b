"""``tcp_muscle import FILE... [--map MAP.yaml] [--output DIR]``: a lab's files to bags, one per run.

Without a map the files are looked at, and what was understood is shown. The map, given or made so, is written beside
the bags.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from shutil import copyfile
from typing import TYPE_CHECKING

from tcp_muscle_ros.commands.bag_arguments import add_unit_argument, stated_units
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.recording.checks import Issue
    from tcp_muscle_ros.recording.csv_import import Imported
    from tcp_muscle_ros.recording.lab.draft import DraftRun


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``import``."""
    parser.add_argument(
        'files', nargs='+', metavar='FILE', help='CSV, text, .xlsx, .mat, .parquet; of a folder no other text than .csv'
    )
    parser.add_argument('--map', metavar='MAP.yaml', help='what the columns are (default: found from the files)')
    parser.add_argument('--output', metavar='DIR', help='a new folder for the bags (default: named as the first file)')
    add_unit_argument(parser)
    add_force_argument(parser)


def run(args: argparse.Namespace) -> int:
    """Import all runs; nothing is written unless all of them can be read."""
    from tcp_muscle_ros.files.outputs import IMPORT_MAP, in_place_of, refuse_among, writable_folder
    from tcp_muscle_ros.recording.bag_writer import write_recording
    from tcp_muscle_ros.recording.checks import check
    from tcp_muscle_ros.recording.csv_import import import_runs, lab_files, unclaimed
    from tcp_muscle_ros.recording.import_map import read_import_map
    from tcp_muscle_ros.recording.lab.draft_map import map_text, told_apart

    if args.map and args.unit:
        raise BadInput(f'--unit {args.unit[0]}: the map says what is in which unit; change it there: {args.map}')
    import_map = None if args.map is None else read_import_map(args.map)
    files = lab_files(args.files)
    refuse_among(args.output or files[0].stem, [*args.files, *([args.map] if args.map else [])])
    output = writable_folder(args.output or files[0].stem, force=args.force)
    with in_place_of(output) as draft:
        drafts: dict[Path, Sequence[DraftRun]] = {}
        draft.mkdir(parents=True, exist_ok=True)
        if import_map is not None:
            copyfile(args.map, draft / IMPORT_MAP)  # says how they came about, and what belongs together
        else:
            drafts = {**_in_units(told_apart(_guessed(files)), stated_units(args))}
            (draft / IMPORT_MAP).write_text(map_text(drafts, output / IMPORT_MAP), encoding='utf-8')
            import_map = read_import_map(draft / IMPORT_MAP)
        runs = list(import_runs(import_map, files))
        for each in runs:
            write_recording(draft / each.name, each.recording)
    _say_understood(drafts, runs)
    for each in runs:
        channels = ', '.join(each.recording.channels)
        print(f'{output / each.name}: {each.recording.duration:.1f} s of {channels}')
        for note in each.recording.notes:
            print(f'  note: {note}')
        for issue in check(each.recording):
            print(f'  check: {_told(issue, output / IMPORT_MAP, args.map)}')
    for file in unclaimed(import_map, files):
        print(f'note: {file} matches no run of {args.map} and was left out')
    print(f'{len(runs)} run(s) imported to {output}')
    if drafts:
        told = ' '.join(map(str, args.files))
        print(
            f'If that is wrong, change {output / IMPORT_MAP} and: tcp_muscle import {told} --map ... --output NEW_DIR'
        )
    return 0


def _guessed(files: Sequence[Path]) -> dict[Path, list[DraftRun]]:
    """What was understood of each file. BadInput says why the first cannot be, and names the others."""
    from tcp_muscle_ros.recording.lab.guess import guess

    def understood(file: Path) -> list[DraftRun] | BadInput:
        try:
            return guess(file)
        except BadInput as mistake:
            return mistake

    found = {file: understood(file) for file in files}
    mistakes = {str(file): mistake for file, mistake in found.items() if isinstance(mistake, BadInput)}
    if mistakes:
        why, *others = mistakes
        raise BadInput(*mistakes[why].args, *([f'; nor can {", ".join(others)} be read'] if others else []))
    return {file: runs for file, runs in found.items() if not isinstance(runs, BadInput)}


def _say_understood(drafts: dict[Path, Sequence[DraftRun]], runs: list[Imported]) -> None:
    """What was understood of each file: how it is written, its columns, its first rows."""
    from tcp_muscle_ros.report.import_summary import understood

    by_name = {each.name: each.recording for each in runs}
    for file, found in drafts.items():
        print(understood(file, found, by_name[found[0].name]))


def _in_units(drafts: Mapping[Path, Sequence[DraftRun]], units: Mapping[str, str]) -> Mapping[Path, Sequence[DraftRun]]:
    """The drafts with the numbers of some channels in another unit than was understood. BadInput: no such channel in
    any, no such unit, or a share of a length, which has none."""
    from tcp_muscle_ros.recording import options
    from tcp_muscle_ros.recording.recording import channel_kind
    from tcp_muscle_ros.recording.units import UNITS, unit_of

    stated = {}
    columns = [column for runs in drafts.values() for run in runs for column in run.columns]
    for name, unit in units.items():
        kind = channel_kind(name, options.UNIT)
        of_channel = [column for column in columns if column.channel == kind.name]
        if not of_channel:
            known = [column.channel for column in columns]
            raise BadInput(f'--unit {name}: no column is a channel of this name{nearest(name, known)}')
        if any(column.scale != 1.0 for column in of_channel):
            raise BadInput(f'--unit {name}: it is a share, scaled by a length; change that in the map (--map)')
        stated[kind.name] = unit_of(unit, UNITS[kind.unit].quantity, options.unit(name)).name

    def changed(run: DraftRun) -> DraftRun:
        return replace(run, columns=tuple(replace(c, unit=stated.get(c.channel, c.unit)) for c in run.columns))

    return {file: [changed(run) for run in runs] for file, runs in drafts.items()}


def _told(issue: Issue, made: Path, given: str | None) -> str:
    """What a check says. Here the map, ``made`` or ``given``, names the columns; one that was given the units, too."""
    found = issue.misread
    if found is None:
        return issue.sentence
    unit = f'say so in {given}, unit: {" or ".join(found.guesses)}' if given else ''
    return ''.join(map(str, found.told(unit, channel=f'name the right column in {given or made} (--map)')))
