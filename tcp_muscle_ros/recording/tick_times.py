"""On which tick of its muscle an unstamped message was published: told from when it was logged."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from tcp_muscle_ros.recording.cdr import Index

OTHER_CLOCK_NS = 10_000_000_000  # stamps this far from the log time were made by another clock
_AT_ONCE = 1_000_000  # messages
_SOME = 10_000  # by which what is typical of them is known
_RHYTHM = 101  # messages over which a topic's rhythm among the ticks is judged
_ASIDE = 0.2  # of a period: typically nearer to a tick are messages that were published with it
_BETWEEN = 0.3  # of a period: and three of four are nearer than this. At twice the rate every second is further away


def clock_offset(log: Index, stamp: Index) -> int:
    """What to add to a log time to be on the stamps' clock: 0 unless they are clocks of their own."""
    offset = int(np.median(stamp - log))
    return offset if abs(offset) > OTHER_CLOCK_NS else 0


@dataclass(frozen=True)
class Ticks:
    """The stamped messages of a muscle, in the order they were logged."""

    log: Index
    stamp: Index

    @property
    def clock_offset(self) -> int:
        """What to add to a log time to be on the stamps' clock: 0 unless they are clocks of their own."""
        return clock_offset(self.log, self.stamp)

    def of(self, log: Index) -> Index:
        """The time of a topic's unstamped messages: that of their tick (within half a period), else the log time.

        Messages of one tick leave together, but each arrives with its own delay, and after a stall several ticks
        arrive at once: the nearest in log time is then sometimes a neighbour's. But a topic keeps its rhythm: it has
        one message every tick, or every tenth. Where two messages are nearest to one tick, each message goes to the
        tick that its neighbours' rhythm says, unless that is further than half a period. A tick takes one message, and
        the order of the log stays. Where all was logged at its very stamp, as in what was imported, nothing was on the
        way, and each log time is the message's own: an input may switch between two samples. A topic that keeps a
        rhythm of its own, as a laser beside a slow thermometer, has no ticks: its messages stay at their log times.
        """
        if np.array_equal(self.log, self.stamp):
            return log
        given, order = log, np.argsort(log, kind='stable') if np.any(log[1:] < log[:-1]) else None
        log = log if order is None else log[order]
        half_period = float(np.median(np.diff(self.stamp))) / 2
        # Some at a time: a long recording's many steps on the way to this would be larger than it is.
        parts = [self._nearest(log[at : at + _AT_ONCE]) for at in range(0, len(log), _AT_ONCE)]
        nearest_tick = tick = np.concatenate([np.empty(0, np.int64), *parts])
        del parts
        if self._has_own_rhythm(log, tick, half_period):
            return given + self.clock_offset
        if np.any(tick[1:] <= tick[:-1]):  # two messages nearest to one tick
            count = np.arange(len(log))
            rhythm = count + median_filter(nearest_tick - count, size=_RHYTHM, mode='reflect')
            rhythm = np.clip(rhythm, 0, len(self.log) - 1)
            tick = np.where(np.abs(self.log[rhythm] - log) <= half_period, rhythm, nearest_tick)
        fits = np.abs(self.log[tick] - log) <= half_period
        first = np.append(True, np.maximum.accumulate(np.where(fits, tick, -1))[:-1] < tick[1:])
        fits &= first
        time = self.stamp[tick]
        time[~fits] = log[~fits] + self.clock_offset
        time = _between_neighbours(time, fits)
        if order is None:
            return time
        in_order = np.empty_like(time)
        in_order[order] = time
        return in_order

    def _has_own_rhythm(self, log: Index, tick: Index, half_period: float) -> bool:
        """Whether messages, each with its nearest tick, were not published with the ticks: of those near any."""
        # Drawn, as every tenth of a topic at twice the rate would always be on a tick, or never.
        some = np.random.default_rng(0).choice(len(log), min(len(log), _SOME), replace=False, shuffle=False)
        apart = np.abs(self.log[tick[some]] - log[some]) / (2.0 * half_period)
        apart = apart[apart <= 0.5]  # what came while the muscle was silent tells nothing
        return bool(apart.size) and bool(np.any(np.quantile(apart, (0.5, 0.75)) > (_ASIDE, _BETWEEN)))

    def _nearest(self, log: Index) -> Index:
        """The tick that was logged nearest to each of these."""
        after = np.clip(np.searchsorted(self.log, log), 1, len(self.log) - 1)
        return np.where(log - self.log[after - 1] <= self.log[after] - log, after - 1, after)


def _between_neighbours(time: Index, sure: NDArray[np.bool_]) -> Index:
    """Times in the order of the log: those that are not `sure` and break it are spread between those that are kept."""
    if sure.all() or not sure.any():
        return time
    before = np.maximum.accumulate(np.where(sure, time, np.iinfo(np.int64).min))
    after = np.minimum.accumulate(np.where(sure, time, np.iinfo(np.int64).max)[::-1])[::-1]
    kept = sure | ((before < time) & (time < after))
    count = np.arange(len(time))
    start = time[kept][0]
    spread = start + np.interp(count, count[kept], (time[kept] - start).astype(np.float64)).astype(np.int64)
    spread += count - np.clip(count, count[kept][0], count[kept][-1])  # beyond the kept ones: 1 ns apart
    return np.where(kept, time, spread)
