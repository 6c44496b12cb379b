"""Text that people give: a file, or a pipe that something writes to."""

import errno
import os
import select
import stat
from pathlib import Path

_PATIENCE_S = 5.0  # for the first and each further byte of a pipe


def read_text(path: str | Path) -> str:
    """The UTF-8 text of a file, or of a pipe such as ``<(command)``.

    Raises:
        OSError: not there, not readable, neither a file nor a pipe, or a pipe that stays silent for some seconds.
        UnicodeDecodeError: no text.
    """
    # Without blocking: a pipe that nobody opens for writing would otherwise never open.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, 'O_NONBLOCK', getattr(os, 'O_BINARY', 0)))
    with open(descriptor, 'rb', buffering=0) as file:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISREG(mode):
            return file.readall().decode('utf-8')
        if not stat.S_ISFIFO(mode):
            raise OSError(errno.EINVAL, os.strerror(errno.EISDIR) if stat.S_ISDIR(mode) else 'not a file')
        return _drained(descriptor).decode('utf-8')


def _drained(pipe: int) -> bytes:
    """All that comes through a pipe until its writers are gone."""
    content = bytearray()
    while select.select([pipe], [], [], _PATIENCE_S)[0]:
        piece = os.read(pipe, 1 << 16)
        if not piece:
            if content:
                return bytes(content)
            break  # nobody has it open
        content += piece
    raise OSError(errno.ETIMEDOUT, 'a pipe that nothing comes through')
