"""Compile the model's functions with numba, and keep the machine code between starts.

Numba alone decides by one file's date whether its cache is stale, and so misses a change in a file
that the cached function calls. Here the cache folder is named after the content of every file of the
model: a change anywhere compiles anew, an unchanged model loads in a fraction of a second.

An installation may bring machine code along (``machine_code/`` in this folder, made by ``colcon build``). It is copied
to the user's cache at the first start, because numba uses a cache only where it could write: so an installation
that nobody may write to starts at once too.
"""

import contextlib
import hashlib
import os
import shutil
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


SHIPPED = Path(__file__).parent / 'machine_code'  # what the installation brought along, by digest as in the cache


def _take_over(shipped: Path, cache: Path) -> None:
    """Copy what the cache lacks. Several processes may do it at once: each file appears whole."""
    for source in sorted(shipped.rglob('*')):
        target = cache / source.relative_to(shipped)
        if source.is_file() and not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            beside = target.with_name(f'{target.name}.{os.getpid()}')
            shutil.copyfile(source, beside)
            beside.replace(target)


CACHE = _writable_cache()  # where machine code is kept; None: nowhere
if CACHE is not None:
    with contextlib.suppress(OSError):  # a full disk: compiled again, as without it
        _take_over(SHIPPED / CACHE.name, CACHE)


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
