"""Compile the model's functions with numba, and keep the machine code between starts.

Numba alone decides by one file's date whether its cache is stale, and so misses a change in a file
that the cached function calls. Here the cache folder is named after the content of every file of the
model: a change anywhere compiles anew, an unchanged model loads in a fraction of a second.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba

_F = TypeVar('_F', bound=Callable[..., Any])
# No compiled function allocates, so none needs numba's memory runtime (nrt): its reference counts on every array that
# is passed cost three times what the physics does.
_OPTIONS: dict[str, Any] = {'error_model': 'numpy', 'nogil': True, '_nrt': False}


def _digest() -> str:
    digest = hashlib.sha256(f'{numba.__version__}'.encode())
    for file in sorted(Path(__file__).parent.rglob('*.py')):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _writable_cache() -> Path | None:
    """The first folder that takes files: the user's cache, else a temporary one, else none (no cache)."""
    base = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache')
    for root in (base, Path(tempfile.gettempdir())):
        folder = root / 'tcp_muscle_ros' / _digest()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return None


CACHE = _writable_cache()  # where machine code is kept; None: nowhere


def inner(function: _F) -> _F:
    """Compile a function that compiled functions call. Without the wrappers for Python, half of the time to compile."""
    compiled: _F = numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **_OPTIONS)(function)
    return compiled


def inlined(function: _F) -> _F:
    """As ``inner``, and written into its caller: for the few lines that a call would cost more than.

    A call hands over seven words an array; between an entry and the stages that is half of the paper model's time.
    """
    compiled: _F = numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True, **_OPTIONS)(function)
    return compiled


def entry(function: _F) -> _F:
    """Compile a function that Python calls; its machine code is kept on disk where possible."""
    if CACHE is None:
        return inner(function)
    elsewhere = numba.config.CACHE_DIR  # numba reads it while decorating only; other users keep theirs
    numba.config.CACHE_DIR = str(CACHE)
    try:
        compiled: _F = numba.njit(cache=True, **_OPTIONS)(function)
    finally:
        numba.config.CACHE_DIR = elsewhere
    return compiled
