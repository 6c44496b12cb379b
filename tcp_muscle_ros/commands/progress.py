"""A sign of life on standard error for work longer than two seconds."""

import sys
import time
from types import TracebackType

_FIRST, _BETWEEN = 2.0, 1.0  # s


class Progress:
    """``with Progress('fitting') as p: p.beat()``: after two seconds, a line that counts and is wiped at the end."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._count = 0
        self._start = self._shown = time.monotonic()

    def beat(self) -> None:
        """One more step was done."""
        self._count += 1
        self.tell(f'{self._count} runs of the model')

    def tell(self, how_far: str) -> None:
        """How far the work has come, in words."""
        now = time.monotonic()
        if now - self._start > _FIRST and now - self._shown > _BETWEEN:
            self._shown = now
            self._say(f'{self._what}: {how_far}, {now - self._start:.0f} s')

    def stage(self, what: str) -> None:
        """The work has come to its next part."""
        self._what = what

    @staticmethod
    def _say(line: str) -> None:
        again = sys.stderr.isatty() or _in_notebook()
        print(f'{line:<78}' if again else line, end='\r' if again else '\n', file=sys.stderr, flush=True)

    def __enter__(self) -> 'Progress':
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if (sys.stderr.isatty() or _in_notebook()) and self._shown > self._start:
            self._say('')


def _in_notebook() -> bool:
    """Does a notebook show what is written? It is no terminal, but a carriage return begins its line anew as well."""
    return 'ipykernel' in sys.modules
