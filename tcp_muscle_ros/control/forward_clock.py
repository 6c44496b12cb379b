"""Time that only goes forward, whatever the clock that it is read from does."""

from math import isfinite


class ForwardClock:
    """The forward steps of a clock, summed: setting it back cannot prolong the life of what came before."""

    def __init__(self) -> None:
        self.time = 0.0  # s
        self._last: float | None = None

    def at(self, now: float) -> float:
        """The time (s) at a reading of the clock; one that is no number leaves it where it was."""
        if isfinite(now):
            if self._last is not None:
                self.time += max(now - self._last, 0.0)
            self._last = now
        return self.time
