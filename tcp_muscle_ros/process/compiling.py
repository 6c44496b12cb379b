"""What is said where the model is compiled first: half a minute in which nothing else happens."""

import sys
import threading
import time
from typing import Any

from numba.core import event

SAID = 'compiling the model for this machine, 15 to 40 s; later starts find it'
_PATIENCE = 1.0  # s of compiling, all in all, that need no word


class _Teller(event.Listener):
    """Says once that the process compiles; one compilation may lie in another."""

    def __init__(self) -> None:
        self._depth, self._spent, self._begun = 0, 0.0, 0.0
        self._timer: threading.Timer | None = None
        self._told = False

    def on_start(self, event: Any) -> None:
        """A function is not in the cache, and is compiled."""
        self._depth += 1
        if self._depth == 1 and not self._told:
            self._begun = time.monotonic()
            self._timer = threading.Timer(max(_PATIENCE - self._spent, 0.0), self._tell)
            self._timer.daemon = True
            self._timer.start()

    def on_end(self, event: Any) -> None:
        """It is compiled."""
        self._depth -= 1
        if self._depth == 0 and self._timer is not None:
            self._timer.cancel()
            self._timer = None
            self._spent += time.monotonic() - self._begun

    def _tell(self) -> None:
        if not self._told:
            self._told = True
            print(SAID, file=sys.stderr, flush=True)


_teller: list[_Teller] = []


def tell_of_compiling() -> None:
    """From now on the process says on standard error, once, that it compiles."""
    if not _teller:
        _teller.append(_Teller())
        event.register('numba:compile', _teller[0])
