"""Recordings of the independent truth generator."""

import sys
from pathlib import Path

from tcp_muscle_ros.recording.bag import read_bag

sys.path.insert(0, str(Path(__file__).parents[2]))

from proof.cases import make_case
from proof.generate import write_case


def recordings(folder, suite, seed, number, kind, what, change=None):
    """Those of one case, written to a folder and read; ``change`` may alter the case before."""
    case = make_case(suite, seed, number, kind, what)
    if change:
        change(case)
    write_case(case, folder)
    return [read_bag(bag) for bag in sorted((folder / case.name).glob('recording_*'))]
