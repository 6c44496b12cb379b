"""How fast a setpoint moves, from the setpoints alone."""

_LONGEST = 0.3  # s; setpoints further apart than this are steps, not a path
_FASTEST = 0.1  # m/s; what moves faster is a step as well


class Slope:
    """The setpoint's speed (m/s): known while setpoints follow one another on a path, zero after a step.

    It looks at the time between two changes, so a path that comes at a lower rate than the updates is seen as one.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forget the path."""
        self._last: float | None = None
        self._since = self._between = 0.0
        self._speed = 0.0

    def update(self, setpoint: float) -> float:
        """The speed now, given this period's setpoint (m)."""
        self._since += self._period
        if self._last is None or setpoint != self._last:
            moved = 0.0 if self._last is None else setpoint - self._last
            isolated = self._since > max(_LONGEST, 1.5 * self._period) or abs(moved) > _FASTEST * self._since
            self._speed = 0.0 if self._last is None or isolated else moved / self._since
            self._between, self._since, self._last = self._since, 0.0, setpoint
        elif self._since > 1.5 * self._between + 0.5 * self._period:
            self._speed = 0.0
        return self._speed
