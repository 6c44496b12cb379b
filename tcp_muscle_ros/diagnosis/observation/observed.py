"""What was seen of a muscle: one channel, perhaps averaged in blocks."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tcp_muscle_ros.diagnosis.observation.reading import average
from tcp_muscle_ros.muscle.arrays import Array, Mask, Places

_CONTIGUOUS = 1.5  # times the width of two blocks: what lies farther apart has a gap between


@dataclass(frozen=True, eq=False)
class Observed:
    """One output channel: ``value`` (SI) at ``time`` (s), both shape (m,); ``count`` samples were averaged in each.

    ``spacing``: s between these samples; ``stretch``: which stretch without a step of an input each value lies in,
    shape (m,), None where nothing was averaged.
    ``swinging``: which were taken while a weight may swing, shape (m,), None: none of them.
    ``within``: variance (SI squared) of single samples about the mean of their block.
    ``steady``: what single readings weigh beside a usual one of the recording, at most 1, shape (m,); None: all alike.
    ``beside``: what its values weigh beside those of other recordings, which may be means of more samples, or of fewer.
    """

    time: Array
    value: Array
    count: Array
    swinging: Mask | None = None
    spacing: float = 0.0
    stretch: Array | None = None
    within: float = 0.0
    steady: Array | None = None
    beside: float = 1.0

    @property
    def apart(self) -> float:
        """How far apart its single samples are, s."""
        if self.spacing or self.time.size < 2:
            return self.spacing
        return float(np.median(np.diff(self.time)))

    @cached_property
    def highest(self) -> float:
        """The largest of its values, of which there is one."""
        return float(self.value.max())

    def averaged(self, shown: Array) -> Array:
        """What the mean over each block is where ``shown`` is what a model shows in its middle, both shape (m,).

        They differ by a 24th of the second difference over its width. The first and last of a stretch have that of
        their neighbour, which grows towards a step of the drive as it does from one to the next.
        """
        inner, first, last, width = self._bends
        if not inner.size:
            return shown
        mean = np.zeros(shown.size)
        average(np.ascontiguousarray(shown), self.time, inner, first, last, width, mean)
        return mean

    @cached_property
    def _bends(self) -> tuple[Places, Places, Places, Array]:
        """The places of values between two others of their stretch, of those that follow a step, and of those before
        one; and the squared width of each (s^2)."""
        none = np.empty(0, dtype=int)
        if self.stretch is None or self.time.size < 4:
            return none, none, none, np.empty(0)
        wide = self.spacing * self.count
        near = np.diff(self.time) < _CONTIGUOUS * 0.5 * (wide[1:] + wide[:-1])
        joined = near & (np.diff(self.stretch) == 0)
        before, after = np.append(False, joined), np.append(joined, False)
        inside = before & after
        first = after & ~before & np.append(inside[1:], False) & np.append(inside[2:], [False, False])
        last = before & ~after & np.append(False, inside[:-1])
        width = self.spacing**2 * np.maximum(self.count**2 - 1.0, 0.0)
        return inside.nonzero()[0], first.nonzero()[0], last.nonzero()[0], width

    @cached_property
    def weight(self) -> Array:
        """What one value weighs beside a usual one: means of fewer samples are noisier, and so may be readings."""
        if not self.count.size:
            return self.count
        weight = np.minimum(np.sqrt(self.count / np.median(self.count)), 1.0) * self.beside
        return weight if self.steady is None else weight * self.steady

    def only(self, keep: Mask) -> 'Observed':
        """Some of the values."""
        each = ('time', 'value', 'count', 'swinging', 'stretch', 'steady')
        kept = {name: getattr(self, name) for name in each if getattr(self, name) is not None}
        return replace(self, **{name: entry[keep] for name, entry in kept.items()})
