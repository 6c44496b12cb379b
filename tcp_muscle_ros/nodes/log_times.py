"""When messages were: as received, but for those that waited on the way.

While a publisher is being discovered, and after a stall, several messages are handed over at once and would be logged
within microseconds of each other. What the publisher's clock says of each tells how much longer than usual it waited.
"""

_USUAL_NS = 2_000_000  # more than a message is usually on its way beyond the quickest
_CLOCK_SET_NS = 2_000_000_000  # a message is not so late: the publisher's clock was set
_DRIFT = 1e-4  # of two clocks against each other, at most


class LogTimes:
    """The log times of one topic. All in ns."""

    def __init__(self) -> None:
        self._quickest: float | None = (
            None  # received less sent of the quickest message: delay and offset of the clocks
        )
        self._at = 0

    def of(self, received: list[int], sent: list[int]) -> list[int]:
        """Log times of messages that were taken together, in the order in which they came; ``sent`` 0: not known."""
        times = []
        delays = [r - s for r, s in zip(received, sent, strict=True) if s > 0]
        self._learn(delays, received[-1] if received else 0)
        for r, s in zip(received, sent, strict=True):
            late = r - s - self._quickest if s > 0 and self._quickest is not None else 0.0
            times.append(r - round(late) if _USUAL_NS < late < _CLOCK_SET_NS else r)
        return times

    def _learn(self, delays: list[int], now: int) -> None:
        if not delays:
            return
        if self._quickest is None or min(delays) - self._quickest > _CLOCK_SET_NS:
            self._quickest = min(delays)
        else:
            self._quickest = min(self._quickest + _DRIFT * max(now - self._at, 0), *delays)
        self._at = now
