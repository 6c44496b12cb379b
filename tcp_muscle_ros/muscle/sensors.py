"""What a sensor makes of a quantity: a first-order lag, then noise, then steps."""

from math import exp

import numpy as np

BLOCK = 512  # ticks of noise drawn at a time; the sequence depends on the tick alone


class Sensor:
    """One channel. ``lag`` s, ``noise`` standard deviation and ``quantum`` in the channel's unit; 0 = none."""

    def __init__(self, lag: float = 0.0, noise: float = 0.0, quantum: float = 0.0) -> None:
        self.lag = lag
        self.noise = noise
        self.quantum = quantum
        self._followed: float | None = None

    @property
    def ideal(self) -> bool:
        """Whether it shows the quantity itself."""
        return self.lag == self.noise == self.quantum == 0.0

    def reset(self) -> None:
        """At rest with what comes next."""
        self._followed = None

    def read(self, value: float, dt: float, normal: float) -> float:
        """What it shows dt s after the last; ``normal`` is a draw from the standard normal distribution."""
        if self.lag > 0.0:
            if self._followed is not None:
                value += (self._followed - value) * exp(-dt / self.lag)  # exact for a value that was held
            self._followed = value
        value += self.noise * normal
        if self.quantum > 0.0:
            value = round(value / self.quantum) * self.quantum
        return value


class Noise:
    """Seeded standard normal draws, one row of ``channels`` a tick."""

    def __init__(self, seed: int, channels: int) -> None:
        self._random = np.random.default_rng(seed)
        self._channels = channels
        self._rows: list[list[float]] = []

    def row(self) -> list[float]:
        """The draws of one tick."""
        if not self._rows:
            self._rows = self._random.standard_normal((BLOCK, self._channels)).tolist()
            self._rows.reverse()
        return self._rows.pop()
