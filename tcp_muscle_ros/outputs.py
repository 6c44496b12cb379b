"""Where a command writes: looked at before the work, so that none is done in vain."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tcp_muscle_ros.errors import BadInput


def writable_folder(path: str | Path) -> Path:
    """The path of a folder that is still to be made. BadInput where that is not possible."""
    path = Path(path)
    above = next(folder for folder in path.absolute().parents if folder.exists())
    if not above.is_dir():
        raise BadInput(f'{path}: {above} is a file; expected a folder')
    if not os.access(above, os.W_OK | os.X_OK):
        raise BadInput(f'{path}: nothing can be written in {above}; give another --output')
    return path


def writable_file(path: str | Path) -> Path:
    """The path of a file that is still to be written. BadInput where that is not possible."""
    path = Path(path)
    if path.is_dir():
        raise BadInput(f'{path}: is a folder; expected the name of a file')
    if not path.parent.is_dir():
        raise BadInput(f'{path}: its folder does not exist')
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise BadInput(f'{path}: cannot be written')
    return path


@contextmanager
def writing(path: str | Path, kept: str = '') -> Iterator[None]:
    """What the system says against writing there, as BadInput; ``kept`` is what is not lost for all that."""
    try:
        yield
    except OSError as error:
        raise BadInput(f'{path}: cannot be written ({error.strerror or error}){kept}') from None
