"""A fixed rate that keeps to its clock: ticks are due at absolute times, so that nothing adds up.

``TickLoop`` runs in a thread of its own beside the executor: an executor's wait set costs more than all
publishing, and above some hundred hertz its timers drop periods in silence. Here a late tick is made up for
and counted.
"""

import threading
import time
from collections.abc import Callable

from rclpy.clock import Clock, JumpThreshold
from rclpy.duration import Duration

SECOND = 1_000_000_000  # ns
NO_CLOCK, STANDS_STILL = 'use_sim_time is true, but no /clock has come', '/clock stands still'
BACKLOG = 10  # ticks; the depth of the state topics' queues
_NOTICED = 1_000_000  # ns by which the stamps may differ from the system's clock
_COARSE = 0.02  # s: above it a wait can be interrupted, below it one sleep is the most punctual


class TimeBase:
    """A clock to keep a rate by. Times in ns."""

    def now(self) -> int:
        """The time."""
        raise NotImplementedError

    def wait(self, until: int, stop: threading.Event) -> None:
        """Return when it is ``until``, when ``stop`` is set, or when the clock was set back."""
        raise NotImplementedError

    def lateness(self, due: int) -> int:
        """How late a tick due then would be published, as far as this clock can tell."""
        return 0

    def shift(self) -> int:
        """By how much the clock was set since last asked: what is due moves with it."""
        return 0

    def begin(self, stop: threading.Event) -> None:
        """Return when there is a time to start from."""

    @property
    def collects(self) -> bool:
        """Whether it has the node's inputs taken itself."""
        return False

    def seconds(self) -> float:
        """The time that watchdogs go by, s: steady, whatever the clock does."""
        return time.monotonic()

    def stands_still(self) -> bool:
        """Whether the clock has stopped, so that nobody may count on the next tick. Asked once a second."""
        return False

    def held_up(self) -> str:
        """What it has waited for longer than anybody expects, and what disturbs it; '' where nothing."""
        return ''


class SteadyTime(TimeBase):
    """The system's time, kept by the steady clock so that setting the system's clock stretches no tick."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._offset = clock.now().nanoseconds - time.monotonic_ns()

    def now(self) -> int:
        """The time."""
        return time.monotonic_ns() + self._offset

    def wait(self, until: int, stop: threading.Event) -> None:
        """Return when it is ``until``; see TimeBase."""
        _sleep(until, self.now, stop)

    def lateness(self, due: int) -> int:
        """Time since ``due``."""
        return self.now() - due

    def shift(self) -> int:
        """How the system's clock was set against the steady one: nothing, until it is more than a millisecond."""
        before = time.monotonic_ns()
        system = self._clock.now().nanoseconds
        after = time.monotonic_ns()
        shift = system - (before + after) // 2 - self._offset
        if abs(shift) < _NOTICED or after - before > _NOTICED:  # or interrupted between the two looks
            return 0
        self._offset += shift
        return shift


class ScaledTime(TimeBase):
    """Simulated time from zero, up to ``factor`` times as fast as the steady clock; 0: as fast as it goes.

    It is a clock of its own, so a machine that cannot keep the pace makes it slower, and no tick is ever
    late. Watchdogs go by what has passed less of, tick by tick, steady or simulated time: neither a hurried simulation
    nor a machine that stands still makes a commander late.
    """

    def __init__(self, factor: float) -> None:
        self._factor = factor
        self._reached = 0
        self._elapsed, self._looked = 0.0, time.monotonic_ns()
        self._anchor = time.monotonic_ns(), 0  # steady time and simulated time that belong together

    def now(self) -> int:
        """The time."""
        return self._reached

    def wait(self, until: int, stop: threading.Event) -> None:
        """Return when it is ``until``; see TimeBase."""
        if self._factor > 0.0:
            then, reached = self._anchor
            wake = then + round((until - reached) / self._factor)
            if time.monotonic_ns() - wake > 0.1 * SECOND:
                self._anchor = time.monotonic_ns(), until  # what was lost is not run after
            _sleep(wake, time.monotonic_ns, stop)
        now = time.monotonic_ns()
        self._elapsed += min(now - self._looked, until - self._reached) / SECOND
        self._looked, self._reached = now, until

    def seconds(self) -> float:
        """See the class."""
        return self._elapsed


class RosTime(TimeBase):
    """The time on /clock. It moves in steps; all ticks due by the latest step are in time."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._moved = threading.Event()
        self._seen = 0
        self._last_look = -1
        every_step = JumpThreshold(
            min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1), on_clock_change=True
        )
        self._handle = clock.create_jump_callback(every_step, post_callback=lambda _: self._moved.set())

    def now(self) -> int:
        """The time."""
        return self._clock.now().nanoseconds

    def begin(self, stop: threading.Event) -> None:
        """Return when /clock has come: zero is no time."""
        self.wait(1, stop)

    def stands_still(self) -> bool:
        """Whether /clock says the same as a second ago."""
        before, self._last_look = self._last_look, self.now()
        return self._last_look == before

    def wait(self, until: int, stop: threading.Event) -> None:
        """Return when it is ``until``; see TimeBase."""
        while not stop.is_set() and not self._look_at_clock(until):
            pass

    def _look_at_clock(self, until: int) -> bool:
        """Whether it is ``until`` or was set back; if not, something has moved or 0.1 s have passed."""
        self._moved.clear()
        now = RosTime.now(self)
        set_back = now < self._seen
        self._seen = now
        if now >= until or set_back:
            return True
        self._moved.wait(0.1)
        return False


def _sleep(until: int, now: Callable[[], int], stop: threading.Event) -> None:
    remaining = (until - now()) * 1e-9
    while remaining > _COARSE:
        if stop.wait(remaining - 0.5 * _COARSE):
            return
        remaining = (until - now()) * 1e-9
    if remaining > 0.0:
        time.sleep(remaining)


class TickLoop:
    """Calls ``tick(stamp, dt, publish)`` at a fixed rate in a thread: stamp in ns, dt in s since the tick before.

    A tick that is late by a period or more is counted in ``missed``, made all the same, and published with its own
    stamp: a recording stays complete over a hiccup. Late by more than BACKLOG periods, which is more than subscribers
    keep, it is made but not published (counted in ``unpublished``), so that a machine that cannot keep up stays in the
    present. After a jump of the clock, back or by more than ``longest_step`` s ahead, there is one tick whose dt says
    so (<= 0 or too long), and the rate starts anew from there.
    """

    def __init__(
        self,
        base: TimeBase,
        rate_hz: float,
        tick: Callable[[int, float, bool], None],
        *,
        longest_step: float,
        on_failure: Callable[[], None],
    ) -> None:
        self.ticks = 0
        self.missed = 0
        self.unpublished = 0
        self.jumps = 0
        self.failure: BaseException | None = None
        self._base = base
        self._rate = rate_hz
        self._tick = tick
        self._longest = round(longest_step * SECOND)
        self._on_failure = on_failure
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name='ticks', daemon=True)

    def start(self) -> None:
        """Begin; the first tick is due one period from now."""
        self._thread.start()

    def stop(self) -> None:
        """No tick begins after this returns."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()

    @property
    def waiting_for_clock(self) -> bool:
        """True while the clock has not begun to run (/clock is silent)."""
        return self.ticks == 0 and self._base.now() == 0 and isinstance(self._base, RosTime)

    def _run(self) -> None:
        try:
            self._keep_time()
        except BaseException as failure:  # whatever it was, the process must end with the current off
            self.failure = failure
            self._on_failure()

    def _keep_time(self) -> None:
        base, stop, tick = self._base, self._stop, self._tick
        base.begin(stop)
        period = SECOND / self._rate
        origin, k = base.now(), 0
        before = origin
        while not stop.is_set():
            k += 1
            due = origin + round(k * period)
            base.wait(due, stop)
            gap = base.now() - due
            while -period < gap < 0 and not stop.is_set():  # set back by less than a tick: it is merely not due yet
                base.wait(due, stop)
                gap = base.now() - due
            if stop.is_set():
                return
            if gap < 0 or gap > self._longest:
                self.jumps += 1
                origin, k = base.now(), 0
                tick(origin, (origin - before) * 1e-9, True)
                before = origin
                continue
            late = base.lateness(due)
            publish = late < BACKLOG * period
            self.missed += late >= period
            self.unpublished += not publish
            tick(due, period * 1e-9, publish)
            self.ticks += 1
            before = due
            if due % SECOND < period:  # about once a second
                shift = base.shift()
                origin += shift
                before += shift
                self.jumps += abs(shift) > period
