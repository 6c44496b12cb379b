"""What is watched beside the safety machine: whether a measured signal is alive, and whether the current is taken.

Pure, as ``safety.py``: time is passed in, in seconds of a clock that never stops (steady time).
"""

from math import isfinite

from tcp_muscle_ros.control.forward_clock import ForwardClock

REPEATED = 2  # times the same before a value can be called frozen
STILL = 1.0  # s, a model that moves by less than a quantum for so long has come to rest
ASKED, FLOWS = 0.02, 0.005  # A: so much is asked for, and less than that flows: nothing does
UNTAKEN = 1.0  # s, twice a receiver's watchdog: who is still being discovered has heard the command by then

THERMOMETER = 3.0  # s, for which a reading counts: usual readers give one to four a second


class Latest:
    """The last good value of a signal, and when it came."""

    def __init__(self) -> None:
        self.value: float | None = None
        self.came = 0.0

    def take(self, value: float, now: float) -> None:
        """One that came."""
        self.value, self.came = value, now

    def fresh(self, now: float, age: float) -> float | None:
        """The value, unless it is older than ``age`` s."""
        return self.value if now - self.came <= age else None


class FeedbackWatch:
    """Whether a measured signal is alive: it comes, it is a number, and it moves when the muscle must.

    ``timeout`` s without a good value and it is lost. It is frozen once the model has moved by more than ``quanta``
    quanta of the sensor since the value last changed by so much as a bit, and messages have said the same again
    meanwhile: a message that is late, or a sensor slower than the controller, is not frozen. It thaws with the next
    change, or when the model has come to rest too: then nothing contradicts it any more, and a driver that was merely
    off gets its chance.
    """

    def __init__(self, name: str, timeout: float, quantum: float, quanta: float = 5.0) -> None:
        self.name = name
        self.timeout = timeout
        self.quantum = quantum
        self.quanta = quanta
        self.value: float | None = None  # the last good one
        self._clock = ForwardClock()
        self._received_at: float | None = None
        self._predicted_then: float | None = None  # when the value last changed
        self._repeated = 0  # messages since then that said the same
        self._frozen = False
        self._still_at = self._still_since = 0.0

    def receive(self, value: float, now: float) -> bool:
        """A message. False where it is no number: it does not count as a sign of life."""
        time = self._clock.at(now)
        if not isfinite(value):
            return False
        if value != self.value:
            self.value = value
            self.expect_anew()
        else:
            self._repeated += 1
        self._received_at = time
        return True

    def expect_anew(self) -> None:
        """The model was set to another state: what it said before is not to be compared with."""
        self._predicted_then = None
        self._repeated = 0
        self._frozen = False

    def problem(self, now: float, predicted: float | None) -> str:
        """'' while the signal is alive, else what is wrong; ``predicted`` is what the model says it reads."""
        time = self._clock.at(now)
        if self._received_at is None:
            return f'no {self.name} yet'
        if time - self._received_at > self.timeout:
            self.expect_anew()
            return f'no {self.name} for {self.timeout:g} s'
        if predicted is not None and isfinite(predicted):
            self._frozen = self._contradicted(predicted, time)
        return f'{self.name} frozen at {self.value:g} while the model moves' if self._frozen else ''

    def _contradicted(self, predicted: float, time: float) -> bool:
        if self._predicted_then is None:
            self._predicted_then = predicted
        moved = abs(predicted - self._predicted_then) > self.quanta * self.quantum
        if not self._frozen or abs(predicted - self._still_at) > self.quantum:
            self._still_at, self._still_since = predicted, time
        if self._frozen and time - self._still_since >= STILL:
            self._predicted_then = predicted
            return False
        return self._frozen or (moved and self._repeated >= REPEATED)


class CurrentWatch:
    """Whether the current that is asked for flows: its receiver may be disabled, or in a fault, without a word.

    It does not once at least ``ASKED`` was asked for and less than ``FLOWS`` was applied for ``UNTAKEN`` s, until it
    flows again or nobody says any more what does. While less is asked for, nothing is concluded.
    """

    def __init__(self) -> None:
        self.untaken = False
        self._since: float | None = None

    def update(self, now: float, asked: float, applied: float | None) -> None:
        """``now`` steady time, s; ``asked`` A; ``applied`` A, measured; None where that is not known."""
        if applied is None or applied >= FLOWS:
            self._since, self.untaken = None, False
        elif asked < ASKED:
            self._since = None
        elif self._since is None:
            self._since = now
        elif now - self._since > UNTAKEN:
            self.untaken = True
