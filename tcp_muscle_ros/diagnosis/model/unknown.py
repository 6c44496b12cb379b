"""One unknown of a fit.

Every unknown has a weak prior around its nominal value, so that a direction which the data do not fix stays where it
was and is reported as not fixed, instead of running away.
"""

from dataclasses import dataclass

import numpy as np

AMBIENT, START = 'ambient', 'initial_temperature'  # what each recording has for itself: its surroundings, its state
# Fixed by the data: the interval is half the prior's at most, and spans less than a factor of two.
_NARROWED, FACTOR = 0.5, 0.2
LOG_SPREAD = 1.5  # prior standard deviation of a positive parameter's logarithm: a factor of 4.5 either way


@dataclass(frozen=True)
class Unknown:
    """One unknown. ``log``: fitted as a logarithm. ``recording``: the one it belongs to, None for all.

    ``state``: it says what the machine was in where that recording begins, and is no property of either.
    ``start``, ``low``, ``high`` are in the parameter's own unit; ``spread`` is the prior's standard deviation, of the
    logarithm where ``log``.
    """

    name: str
    start: float
    low: float
    high: float
    spread: float
    log: bool = False
    recording: int | None = None
    state: bool = False

    def to_fit(self, value: float) -> float:
        """The coordinate that the fit moves."""
        return float(np.log(value)) if self.log else value / self.spread

    def from_fit(self, z: float) -> float:
        """The value at a coordinate, kept inside the bounds against rounding."""
        value = float(np.exp(z)) if self.log else z * self.spread
        return min(max(value, self.low), self.high)

    @property
    def prior_spread(self) -> float:
        """The prior's standard deviation in the fit's coordinate."""
        return self.spread if self.log else 1.0

    def fixed_by(self, spread: float) -> bool:
        """Whether data that leave this spread (fit's coordinate) fix it: well within the prior, and to a factor."""
        return spread < min(_NARROWED * self.prior_spread, FACTOR if self.log else np.inf)

    @property
    def each_has(self) -> bool:
        """Whether it is a parameter of an effect that each recording has for itself."""
        return self.recording is not None and '.' in self.name and not self.state

    @property
    def key(self) -> tuple[str, int | None]:
        """What identifies it."""
        return self.name, self.recording
