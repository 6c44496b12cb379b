"""A sequential test on residuals: do a muscle and its model still agree, with a stated rate of false alarms.

Residuals (measured minus predicted) are averaged over a second, and put over what may be expected of that mean: the
noise that the residuals themselves show, and the spread of the prediction, which lasts and is not averaged away:

    z = mean(r) / sqrt(noise^2 / n + spread^2)

Two one-sided cumulative sums (Page 1954) grow by what |z| is beyond an allowance. The allowance is 3.5 because a
calibrated model is not the true one: its error lasts, and is three standard deviations of the calibration now and then.

All arrays have any one shape: channels of a muscle, or of hundreds of muscles that are watched at once.
"""

from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.muscle.arrays import Array

_QUICKEST = 0.01  # share of a new sample in the variance of the noise, once it is known roughly
_WARM = 50  # samples until then
_SURPRISE = 25.0  # times the variance, more of which a sample does not count
_OVERSHOOT = 1.166  # of a Gaussian walk at its bound (Siegmund 1985, eq. 2.57, on both sides)


@dataclass(frozen=True)
class Rule:
    """When the test alarms. ``block`` s; the others in standard deviations of a block's mean."""

    block: float = 1.0
    allowance: float = 3.5
    threshold: float = 20.0
    largest: float = 10.0  # more a block counts as this much: a hiccup of three seconds is no alarm
    drift: float = 2.0  # of the mean z over `drift_time`: not yet an alarm, but no longer chance
    settled: float = 1.5
    drift_time: float = 60.0  # s


def hours_between_false_alarms(rule: Rule, bias: float, channels: int = 1) -> float:
    """The mean time (h) between false alarms where the model is off by ``bias`` standard deviations for good.

    Siegmund's approximation of the run length of a cumulative sum of independent Gaussian steps, in each direction.
    """
    height = rule.threshold + _OVERSHOOT

    def blocks(drift: float) -> float:
        exponent = min(2.0 * drift * height, 700.0)
        if abs(drift) < 1e-6:
            return height**2
        return float((np.exp(exponent) - exponent - 1.0) / (2.0 * drift**2))

    rate = 1.0 / blocks(rule.allowance - bias) + 1.0 / blocks(rule.allowance + bias)
    return rule.block / 3600.0 / (channels * rate)


class Sequential:
    """The test. ``shape`` of what it is given; ``now`` is s of a clock that never goes back."""

    def __init__(self, shape: tuple[int, ...], rule: Rule | None = None) -> None:
        self.rule = rule or Rule()
        self._one, self._two = np.full(shape, np.nan), np.full(shape, np.nan)
        self._variance, self._seen = np.zeros(shape), np.zeros(shape)
        self._begin: float | None = None
        self._sum, self._spread, self._count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self.z = np.zeros(shape)  # of the last block; 0 where nothing was measured
        self.mean_z = np.zeros(shape)  # over about `drift_time`
        self.sums = np.zeros((2, *shape))  # upwards and downwards
        self._since = np.zeros((2, *shape))
        self.alarm = np.zeros(shape, dtype=bool)  # latched
        self.alarmed_at = np.full(shape, np.nan)  # s

    @property
    def noise(self) -> Array:
        """Standard deviation of the noise in a residual."""
        return np.sqrt(self._variance)

    @property
    def since(self) -> Array:
        """When (s) the larger of both sums last began to grow: the estimate of when a difference began."""
        up = self.sums[0] >= self.sums[1]
        since: Array = np.where(up, self._since[0], self._since[1])
        return since

    def add(self, residual: Array, spread: Array, now: float) -> bool:
        """One sample; NaN where nothing was measured. True where a block has ended with it."""
        known = np.isfinite(residual)
        self._learn_noise(residual, known)
        self._sum += np.where(known, residual, 0.0)
        self._spread += np.where(known, spread, 0.0)
        self._count += known
        if self._begin is None:
            self._begin = now
        if now - self._begin < self.rule.block:
            return False
        self._end_block(now)
        return True

    def _learn_noise(self, residual: Array, known: Array) -> None:
        """From second differences: a difference of a model hardly bends from sample to sample, noise does."""
        bend = residual - 2.0 * self._one + self._two
        usable = np.isfinite(bend)
        surprise = np.where(usable, bend, 0.0) ** 2 / 6.0
        warm = self._seen >= _WARM
        surprise = np.where(warm, np.minimum(surprise, _SURPRISE * self._variance), surprise)
        share = np.where(warm, _QUICKEST, 1.0 / (self._seen + 1.0))
        self._variance += np.where(usable, share * (surprise - self._variance), 0.0)
        self._seen += usable
        self._two = np.where(known, self._one, self._two)
        self._one = np.where(known, residual, self._one)

    def _end_block(self, now: float) -> None:
        rule = self.rule
        some = self._count > 0
        count = np.maximum(self._count, 1.0)
        scale = np.sqrt(self._variance / count + (self._spread / count) ** 2)
        ready = some & (self._seen >= _WARM) & (scale > 0.0)
        self.z = np.where(ready, self._sum / count / np.where(scale > 0.0, scale, 1.0), 0.0)
        step = np.clip(self.z, -rule.largest, rule.largest)
        share = min(rule.block / rule.drift_time, 1.0)
        self.mean_z += np.where(ready, share * (step - self.mean_z), 0.0)
        grown = np.maximum(self.sums + np.stack([step, -step]) - rule.allowance, 0.0)
        grown = np.where(ready, grown, self.sums)
        self._since = np.where((self.sums == 0.0) & (grown > 0.0), now - rule.block, self._since)
        self.sums = grown
        new = ~self.alarm & np.any(grown > rule.threshold, axis=0)
        self.alarmed_at = np.where(new, now, self.alarmed_at)
        self.alarm = self.alarm | new
        self._begin = now
        self._sum, self._spread, self._count = np.zeros_like(count), np.zeros_like(count), np.zeros_like(count)

    def forget(self) -> None:
        """Begin anew: no alarm, no sums. What is known of the noise stays."""
        shape = self.alarm.shape
        self.sums, self._since = np.zeros((2, *shape)), np.zeros((2, *shape))
        self.mean_z, self.z = np.zeros(shape), np.zeros(shape)
        self.alarm, self.alarmed_at = np.zeros(shape, dtype=bool), np.full(shape, np.nan)
        self._begin = None
        self._sum, self._spread, self._count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
