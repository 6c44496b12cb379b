"""A table of docs/real_recordings.md, made from the public recordings, which stay outside the project."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path

from real_recordings import PAGE, ROOT

from tcp_muscle_ros.report.marked import replace_marked


def made_today() -> list[str]:
    """When, on what and by which script a table is made, to stand above it."""
    script = Path(sys.argv[0]).name
    return [f'Made on {date.today()} on {os.cpu_count()} cores by `python scripts/{script} --write`.', '']


def show(about: str, block: str, lines: Callable[[Path], Sequence[str]]) -> None:
    """The command: prints what ``lines`` makes of the folder with both rigs; or writes it where ``block`` is marked."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--data', type=Path, default=ROOT.parent / 'shared' / 'data', help='folder with the two rigs')
    parser.add_argument('--write', action='store_true', help='put the table into docs/real_recordings.md')
    given = parser.parse_args()
    if not (given.data / 'tca_bench_rig').is_dir():
        sys.exit(f'{given.data}: no tca_bench_rig here; see docs/real_recordings.md for where the recordings are from')
    text = '\n'.join(lines(given.data))
    if given.write:
        replace_marked(PAGE, block, text)
    else:
        print(text)
