"""What the studies of physics without a name have in common: what counts as a gap, and the page that they write."""

import argparse
from datetime import date
from pathlib import Path

from proof.prove import commit, machine

LEFT = 1.0  # noises: the error of a prediction that is right
REACH = 1.5  # noises, that a recalibrated muscle must miss for there to be a gap


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """Where the page goes, and that nothing else is done."""
    parser.add_argument('--document', type=Path, help='write the tables of what is done so far')
    parser.add_argument('--only-document', action='store_true', help='diagnose nothing more')


def made_by(module: str, seed: int) -> str:
    """How a page was made, when, from which revision and on what, in two lines."""
    command = f'python -m {module} --output DIR'
    return f'Made by `{command}` (seed {seed}) on {date.today()}, revision {commit()}, on\n{machine()}.'


def say(page: str, path: Path | None) -> None:
    """Print a page, and write it where that is asked for."""
    print(page)
    if path is not None:
        path.write_text(page, encoding='utf-8')
