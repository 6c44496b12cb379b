"""How fast a setpoint moves, from the setpoints alone."""

from collections import deque

_LONGEST = 0.3  # s; setpoints further apart than this are steps, not a path
_FASTEST = 0.1  # m/s; what moves faster is a step as well
_WINDOW = 0.2  # s; the mean over so long: setpoints do not come as evenly as they were sent


class Slope:
    """The setpoint's speed (m/s): known while setpoints follow one another on a path, zero after a step.

    It looks at the time between changes, so a path that comes at a lower rate than the updates, or two of its points
    in one period and none in the next, is seen as the path that it is.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forget the path."""
        self._tick = 0
        self._path: deque[tuple[int, float]] = deque()  # when it changed (in periods), and to what

    def update(self, setpoint: float) -> float:
        """The speed now, given this period's setpoint (m)."""
        self._tick += 1
        if not self._path:
            self._path.append((self._tick, setpoint))
        last_tick, last = self._path[-1]
        since = (self._tick - last_tick) * self._period
        if setpoint != last:
            if since > max(_LONGEST, 1.5 * self._period) or abs(setpoint - last) > _FASTEST * since:
                self._path.clear()
            self._path.append((self._tick, setpoint))
            while len(self._path) > 2 and (self._tick - self._path[0][0]) * self._period > _WINDOW:
                self._path.popleft()
        elif self._tick - last_tick > 2.0 * self._ticks_between() + 1.0:
            self._path = deque([self._path[-1]])  # the path has ended
        return self._speed()

    def _ticks_between(self) -> float:
        if len(self._path) < 2:
            return 0.0
        return (self._path[-1][0] - self._path[0][0]) / (len(self._path) - 1)

    def _speed(self) -> float:
        if len(self._path) < 2:
            return 0.0
        (first_tick, first), (last_tick, last) = self._path[0], self._path[-1]
        return (last - first) / ((last_tick - first_tick) * self._period)
