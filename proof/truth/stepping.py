"""The muscle on its bench, a tick at a time: what is done to it at a tick need not be known before.

In the end it has done what ``observe`` does with all of it, number for number.
"""

from dataclasses import replace

import numpy as np

from proof.truth.bench import Bench, Experiment, Signals, around, shown, substeps
from proof.truth.integrate import integrate
from proof.truth.plant import CURRENT, Array
from proof.truth.state import begin


class Stepping:
    """One recording with a current as its input.

    Args:
        bench: the muscle and its instruments.
        time: all ticks that there may be, s; the room does what it does over all of them.
        ambient: degC.
        recording: its number.
        dose: cycles that the muscle has behind it.
        load: under which it is at rest at the first tick, N.
    """

    def __init__(self, bench: Bench, time: Array, ambient: float, recording: int, dose: float, load: float) -> None:
        self._bench, self._recording = bench, recording
        self._room = around(bench, time, ambient, recording)
        self._substeps = substeps(bench, float(time[1] - time[0]))
        self._state, self._arrays = begin(bench.plant, self._room[0][0], 0.0, load, dose)
        self._out = np.empty((len(time), 8))
        self._done = Experiment('run', time, np.zeros(len(time)), CURRENT, np.full(len(time), load), ambient)
        self.ticks = 0

    def tick(self, drive: float, load: float) -> None:
        """On to the next tick, under what held until then; from it on flows ``drive`` (A), hangs ``load`` (N).

        IndexError: after the last tick that there may be.
        """
        k, begun, done = self.ticks, self.ticks > 0, self._done
        done.drive[k], done.load[k] = drive, load
        since = slice(max(k - 1, 0), k + 1)
        integrate(
            self._bench.plant, self._state, self._arrays, begun, done.time[since], done.drive[since],
            CURRENT, done.load[since], *(one[since] for one in self._room), self._substeps, False, self._out[since],
        )  # fmt: skip
        self.ticks = k + 1

    @property
    def dose(self) -> float:
        """Cycles that the muscle has behind it now."""
        return float(self._state.dose)

    def signals(self) -> Signals:
        """What ideal instruments have shown so far; one that looks at a whole recording looks at what there is."""
        so_far = slice(0, self.ticks)
        done = self._done
        until_now = replace(done, time=done.time[so_far], drive=done.drive[so_far], load=done.load[so_far])
        room = self._room[0][so_far]
        return shown(
            self._bench, until_now, self._recording, self._out[so_far], float(self._state.zero), room, self.dose
        )
