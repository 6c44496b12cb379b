"""The last minutes of a muscle, in an array whose size never changes."""

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array


class Memory:
    """The last ``rows`` samples of the columns ``names``; NaN where a column was not measured."""

    def __init__(self, names: tuple[str, ...], rows: int) -> None:
        self.names = names
        self._rows = np.full((rows, 1 + len(names)), np.nan)
        self._next, self._full = 0, False

    def add(self, time: float, values: list[float]) -> None:
        """One sample; ``time`` s."""
        self._rows[self._next, 0] = time
        self._rows[self._next, 1:] = values
        self._next += 1
        if self._next == len(self._rows):
            self._next, self._full = 0, True

    def forget(self) -> None:
        """Begin anew, without a sample."""
        self._next, self._full = 0, False

    def columns(self) -> dict[str, tuple[Array, Array]]:
        """Time (s) and value of each column that was measured, oldest first, without what is missing."""
        rows = np.roll(self._rows, -self._next, axis=0) if self._full else self._rows[: self._next]
        found = {}
        for k, name in enumerate(self.names, 1):
            there = np.isfinite(rows[:, k])
            if there.any():
                found[name] = rows[there, 0].copy(), rows[there, k].copy()
        return found
