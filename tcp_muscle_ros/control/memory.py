"""The last minutes of a muscle, in an array whose size never changes."""

from collections.abc import Collection

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array


class Memory:
    """The last ``rows`` samples of the columns ``names``; NaN where a column was not measured.

    A column that ``holds`` keeps its value until the next, as a load that is said where it changes: what was said
    before the oldest sample holds there.
    """

    def __init__(self, names: tuple[str, ...], rows: int, holds: Collection[str] = ()) -> None:
        self.names, self._holds = names, holds
        self._before = np.full(len(names), np.nan)  # what was last said of each column before the oldest sample
        self._rows = np.full((rows, 1 + len(names)), np.nan)
        self._next, self._full = 0, False

    def add(self, time: float, values: list[float]) -> None:
        """One sample; ``time`` s."""
        if self._full:
            falls_out = self._rows[self._next, 1:]
            np.copyto(self._before, falls_out, where=np.isfinite(falls_out))
        self._rows[self._next, 0] = time
        self._rows[self._next, 1:] = values
        self._next += 1
        if self._next == len(self._rows):
            self._next, self._full = 0, True

    def forget(self) -> None:
        """Begin anew, without a sample: only what holds stays said."""
        for name, (_, value) in self.columns().items():
            self._before[self.names.index(name)] = value[-1]
        self._next, self._full = 0, False

    def columns(self) -> dict[str, tuple[Array, Array]]:
        """Time (s) and value of each column that was measured, oldest first, without what is missing."""
        rows = np.roll(self._rows, -self._next, axis=0) if self._full else self._rows[: self._next]
        found = {}
        for k, name in enumerate(self.names):
            value = rows[:, 1 + k].copy()
            if name in self._holds and len(value) and np.isnan(value[0]):
                value[0] = self._before[k]
            there = np.isfinite(value)
            if there.any():
                found[name] = rows[there, 0], value[there]
        return found
