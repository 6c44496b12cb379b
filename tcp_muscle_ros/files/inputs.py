"""What people give to be read: text, from a file or a pipe that something writes to; and files that are no text."""

import errno
import os
import select
import stat
from pathlib import Path

from tcp_muscle_ros.errors import BadInput, nearest

_NAMED = 4  # files of a folder, at most
_PATIENCE_S = 5.0  # for the first and each further byte of a pipe


def read_text(path: str | Path) -> str:
    """The UTF-8 text of a file, or of a pipe such as ``<(command)``.

    Raises:
        OSError: not there, not readable, neither a file nor a pipe, or a pipe that stays silent for some seconds.
        UnicodeDecodeError: no text.
    """
    path = Path(path)
    if path.is_dir():
        raise OSError(errno.EISDIR, _folder(path))
    # Without blocking: a pipe that nobody opens for writing would otherwise never open.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, 'O_NONBLOCK', getattr(os, 'O_BINARY', 0)))
    with open(descriptor, 'rb', buffering=0) as file:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISREG(mode):
            return file.readall().decode('utf-8')
        if not stat.S_ISFIFO(mode):
            raise OSError(errno.EINVAL, 'not a file')
        return _drained(descriptor).decode('utf-8')


def why_unread(error: OSError | UnicodeDecodeError) -> str:
    """Why ``read_text`` could not read, in a few words."""
    return error.strerror if isinstance(error, OSError) and error.strerror else 'not UTF-8 text'


def not_readable(path: Path, what: str) -> BadInput:
    """Why a path that is no regular file cannot be read as one. ``what`` was expected there, such as a bag."""
    if path.is_fifo():
        return BadInput(f'{path}: is a pipe, not a regular file; write what comes through it to a file and give that')
    if path.exists():
        return BadInput(f'{path}: is not a regular file; expected a {what}')
    if path.is_symlink():
        return BadInput(f'{path}: is a link to {os.readlink(path)}, which does not exist')
    siblings = [each.name for each in path.parent.iterdir()] if path.parent.is_dir() else []
    return BadInput(f'{path}: no such {what}{nearest(path.name, siblings)}')


def _folder(path: Path) -> str:
    """That a folder is one, and which parameter files are in it: of a report's, one of them was meant."""
    held = sorted(each.name for each in path.glob('*.yaml'))[:_NAMED]
    return os.strerror(errno.EISDIR) + (f', which holds {", ".join(held)}' if held else '')


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
