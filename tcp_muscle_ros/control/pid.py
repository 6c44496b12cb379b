"""A plain PID on position, for comparison: what one writes without a model of the muscle."""

from math import exp


class Pid:
    """Position error (m) to current (A). Derivative on the measurement, filtered; anti-windup by back-calculation.

    Args:
        kp: A/m.
        ki: A/(m s).
        kd: A s/m.
        period: s.
        filter_time: s, of the derivative; 0 = none.
    """

    def __init__(self, kp: float, ki: float, kd: float, period: float, filter_time: float) -> None:
        self._kp, self._ki, self._kd, self._period = kp, ki, kd, period
        self._keep = exp(-period / filter_time) if filter_time > 0.0 else 0.0
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next update starts from where the muscle is."""
        self._integral = 0.0
        self._last: float | None = None
        self._speed = 0.0

    def update(self, setpoint: float, displacement: float, limit: float) -> float:
        """The current for the next period, A, within 0 and ``limit``."""
        if self._last is not None:
            speed = (displacement - self._last) / self._period
            self._speed = self._keep * self._speed + (1.0 - self._keep) * speed
        self._last = displacement
        error = setpoint - displacement
        wish = self._kp * error + self._integral - self._kd * self._speed
        current = min(max(wish, 0.0), limit)
        # While clamped, the integral follows what is really given, at the rate of its own time constant.
        back = self._ki / self._kp if self._kp > 0.0 else 0.0
        self._integral += self._period * (self._ki * error + back * (current - wish))
        return current
