"""The board at the other end of a serial line, and whether what it says can be built on. Pure but for the port."""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from tcp_muscle_ros.control.watches import Latest
from tcp_muscle_ros.nodes.serial_line import NUMBERS, Lines, Sample, command, sample

_KEPT = 1000  # commands whose time is remembered
_REOPEN = 1.0  # s between attempts to open a port that went away
_TOLERANCE = 0.2, 0.01  # share and A by which the board's current may exceed what was asked for


class Port(Protocol):
    """As much of pyserial's ``Serial`` as is used here."""

    @property
    def in_waiting(self) -> int:
        """Bytes that wait."""

    def read(self, size: int) -> bytes:
        """So many bytes."""

    def write(self, data: bytes) -> object:
        """Send."""

    def flush(self) -> None:
        """Return when all is sent."""

    def close(self) -> None:
        """Let go."""


class Board:
    """Sends one command a tick and judges the answers.

    ``timeout`` s: a command that is not answered within it, or answered later, makes the board silent. ``problem`` is
    why no current may flow, '' where it may; ``fault`` what must be looked at before any current flows again.
    """

    def __init__(self, open_port: Callable[[], Port], timeout: float) -> None:
        self._open, self.timeout = open_port, timeout
        self._port: Port | None = None
        self._tried = float('-inf')
        self._lines = Lines()
        self._number = 0
        self._sent: deque[tuple[int, float, float]] = deque(maxlen=_KEPT)  # number, when, current
        self._answered: float | None = None  # when the newest answered command was sent
        self._too_much_since: float | None = None
        self.latest: Sample | None = None
        self.temperature = Latest()  # K: a thermometer may be slower than the answers, most of which are without it
        self.garbage = 0
        self.problem = 'no answer from the board yet'
        self.fault = ''

    def begin(self) -> None:
        """Open the port. Raises OSError where that fails; one that goes away later is opened again."""
        self._port = self._open()

    def hear(self, now: float) -> Sample | None:
        """Take what has come; the newest whole sample, if any came."""
        newest = None
        for line in self._lines.feed(self._received(now)):
            heard = sample(line)
            if heard is None:
                self.garbage += 1
            else:
                self._judge(heard, now)
                if heard.temperature is not None:
                    self.temperature.take(heard.temperature, now)
                newest = heard
        self.latest = newest or self.latest
        if self._port is not None:
            self._find_problem(now)
        return newest

    def tell(self, current: float, now: float) -> None:
        """Ask for a current, A."""
        if self._port is None:
            return
        self._number = (self._number + 1) % NUMBERS
        self._sent.append((self._number, now, current))
        try:
            self._port.write(command(self._number, current))
        except OSError as error:
            self._lose(error)

    def end(self) -> None:
        """0 A, sent before this returns, and let go of the port."""
        self.tell(0.0, float('inf'))
        if self._port is not None:
            with suppress(OSError):  # gone: the board's own watchdog stops it
                self._port.flush()
                self._port.close()
            self._port = None

    def _received(self, now: float) -> bytes:
        try:
            if self._port is None:
                if now - self._tried < _REOPEN:
                    return b''
                self._tried = now
                self._port, self._lines = self._open(), Lines()
                self._answered = None
                self.problem = 'no answer from the board yet'
            waiting = self._port.in_waiting
            return self._port.read(waiting) if waiting else b''
        except OSError as error:  # pyserial's SerialException is one
            self._lose(error)
            return b''

    def _lose(self, error: OSError) -> None:
        port, self._port = self._port, None
        self.problem = f'the serial port is gone: {" ".join(str(error).split())}'
        if port is not None:
            with suppress(OSError):
                port.close()

    def _judge(self, heard: Sample, now: float) -> None:
        if self.latest is not None and heard.uptime < self.latest.uptime:
            self.fault = 'the board started again in the middle of its work'
        asked = 0.0  # by the command that it answers: a late answer shows what was asked for then
        for number, when, current in reversed(self._sent):
            if number == heard.command:
                self._answered = max(when, self._answered or when)
                asked = current
                break
        share, most = _TOLERANCE
        if abs(heard.current) <= asked * (1.0 + share) + most:  # either way round it heats
            self._too_much_since = None
        elif self._too_much_since is None:
            self._too_much_since = now
        elif now - self._too_much_since > self.timeout:
            self.fault = f'the board gives {heard.current:.3f} A where {asked:.3f} A was asked for'

    def _find_problem(self, now: float) -> None:
        if self._answered is None:
            self.problem = 'no answer from the board yet'
        elif now - self._answered > self.timeout:
            self.problem = f'no answer from the board to what was asked in the last {self.timeout:g} s'
        else:
            self.problem = ''
