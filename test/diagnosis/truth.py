"""Recordings of the independent truth generator."""

import sys
from dataclasses import replace
from pathlib import Path

from tcp_muscle_ros.recording.bag import read_bag

sys.path.insert(0, str(Path(__file__).parents[2]))

from proof.cases import make_case
from proof.generate import write_case
from proof.recordings import DRIVE


def recordings(folder, suite, seed, number, kind, what, change=None):
    """Those of one case, written to a folder and read; ``change`` may alter the case before. The input is shown as it
    was imposed: what a noisy reading of it does is a matter of its own."""
    case = make_case(suite, seed, number, kind, what)
    case.noise[DRIVE] = replace(case.noise[DRIVE], sigma=0.0, quantum=0.0)
    if change:
        change(case)
    write_case(case, folder)
    return [read_bag(bag) for bag in sorted((folder / case.name).glob('recording_*'))]
