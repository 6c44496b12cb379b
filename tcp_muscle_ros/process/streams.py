"""Standard output and error that may go away: `| head` has seen enough, the disk under a log is full.

What a command does counts for more than what it says meanwhile: the rest is said to nobody, and the work goes on.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from typing import Any, TextIO, cast


class Forgiving:
    """A text stream; ``failure`` is what ended it, after which everything goes to os.devnull."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.failure: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, as long as there is somewhere to."""
        try:
            return self._stream.write(text)
        except OSError as error:
            self._give_up(error)
            return len(text)

    def flush(self) -> None:
        """Hand on what was written."""
        try:
            self._stream.flush()
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self.failure = self.failure or error
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())  # what the stream still holds goes there too, at the latest at exit
        os.close(nowhere)


@contextmanager
def forgiving() -> Iterator[list[OSError]]:
    """Within it, sys.stdout and sys.stderr are forgiving.

    The list that it yields holds, once left, why standard output was lost other than by a reader who has seen enough.
    """
    lost: list[OSError] = []
    if sys.stdout is None or sys.stderr is None:  # closed from the start: print() says nothing then
        yield lost
        return
    out, error = Forgiving(sys.stdout), Forgiving(sys.stderr)
    try:
        with redirect_stdout(cast('TextIO', out)), redirect_stderr(cast('TextIO', error)):
            yield lost
    finally:
        out.flush()
        error.flush()
        if out.failure is not None and not isinstance(out.failure, BrokenPipeError):
            lost.append(out.failure)
