"""The end of a process that was asked to stop before it has begun: it just ends, with nothing said."""

import os
import signal


def end_quietly_when_asked() -> None:
    """SIGINT and SIGTERM end the process with exit code 0, until other handlers are in force."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: os._exit(0))
