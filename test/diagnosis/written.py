"""Recordings of muscles whose law is written in proof.written, and that the truth generator integrates."""

import sys
from pathlib import Path

from diagnosis.made import NOMINAL

from tcp_muscle_ros.diagnosis.observation.prepare import prepare
from tcp_muscle_ros.recording.bag import read_bag

sys.path.insert(0, str(Path(__file__).parents[2]))

from proof.generate import write_recording
from proof.truth import observe


def as_read(case, number, experiment, folder, most=500):
    """One experiment of a case, written down and read."""
    shown = observe(case.bench, experiment, number)
    return prepare(read_bag(write_recording(case, number, experiment, shown, folder)), NOMINAL, most=most)


def recorded(case, folder):
    """Those that a method is given."""
    return [as_read(case, k, experiment, folder) for k, experiment in enumerate(case.experiments)]
