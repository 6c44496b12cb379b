"""When messages were: as received, but for those that waited on the way.

While a publisher is being discovered, and after a stall, several messages are handed over at once and would be logged
within microseconds of each other. What the publisher's clock says of each tells how much longer than usual it waited:
however long that was, for a message that waited was sent after the one before it, and those behind it wait ever less.
Where a clock was set, neither holds.
"""

from collections.abc import Sequence
from itertools import pairwise

_USUAL_NS = 2_000_000  # more than a message is usually on its way beyond the quickest
_FOR_GOOD_NS = 10_000_000_000  # where all have been late for so long, a clock was set
_DRIFT = 1e-4  # of two clocks against each other, at most


class LogTimes:
    """The log times of one topic, which run on unless the clock of the log was set back. All in ns.

    What was said before a late subscription, and comes with it, is logged at ``since``: it is what holds then.
    """

    def __init__(self, since: int = 0) -> None:
        # Received less sent of the quickest message: delay and offset of the clocks.
        self._quickest: float | None = None
        self._received = self._sent = 0  # of the latest message
        self._logged = since  # likewise
        self._late_since: int | None = None  # since when none was in time

    def of(self, received: Sequence[int], sent: Sequence[int]) -> list[int]:
        """Log times of messages that were taken together, in the order in which they came; ``sent`` 0: not known."""
        known = [s for s in sent if s > 0]
        if _runs_back([self._received, *received]) or _runs_back([self._sent, *known]):
            self._quickest, self._late_since = None, None  # a clock was set: what was learnt is of before
            times = list(received)
            self._logged = times[-1]
        else:
            self._learn([r - s for r, s in zip(received, sent, strict=True) if s > 0], received)
            times = [self._log_time(r, s) for r, s in zip(received, sent, strict=True)]
        self._received, self._sent = [self._received, *received][-1], [self._sent, *known][-1]
        return times

    def _learn(self, delays: Sequence[int], received: Sequence[int]) -> None:
        if not delays:
            return
        now, quickest = received[-1], min(delays)
        if self._quickest is None:
            self._quickest = quickest
        usual = self._quickest + _DRIFT * (now - self._received)
        in_time = quickest <= usual + _USUAL_NS
        self._late_since = None if in_time else self._late_since or received[0]
        if self._late_since is not None and now - self._late_since > _FOR_GOOD_NS:
            usual, self._late_since = quickest, None
        self._quickest = min(usual, quickest)

    def _log_time(self, received: int, sent: int) -> int:
        late = received - sent - self._quickest if sent > 0 and self._quickest is not None else 0.0
        time = received - round(late) if late > _USUAL_NS else received
        self._logged = max(self._logged + 1, time)
        return self._logged


def _runs_back(times: Sequence[int]) -> bool:
    """By more than two messages that are sent at once may overtake each other."""
    return any(after < before - _USUAL_NS for before, after in pairwise(times))
