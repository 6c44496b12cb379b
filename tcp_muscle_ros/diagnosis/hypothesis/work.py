"""How much a diagnosis has simulated, so that it ends within a minute or so whatever is tried; counted, not timed, for
the same recordings give the same report on every machine."""

from threading import Lock

LIMIT = 1.2e8  # steps of the model; with all that goes with them a minute on one core


class Work:
    """Counts steps of the model; refits of one diagnosis share it."""

    def __init__(self, limit: float = LIMIT) -> None:
        self.steps, self.limit = 0, limit
        self._lock = Lock()

    def __getstate__(self) -> tuple[int, float]:
        return self.steps, self.limit  # a lock is no one's but this process's

    def __setstate__(self, state: tuple[int, float]) -> None:
        self.steps, self.limit = state
        self._lock = Lock()

    def add(self, steps: float) -> None:
        """Count; whole numbers, so that the order of threads does not matter."""
        with self._lock:
            self.steps += round(steps)

    @property
    def left(self) -> bool:
        """Whether more may be tried."""
        return self.within(1.0)

    def within(self, times: float) -> bool:
        """Whether no more than so many times the limit was simulated."""
        return self.steps < times * self.limit
