"""Memory that was used and is free again, back to the system."""

import ctypes
import sys


def give_back() -> None:
    """Return what is free between pieces that are still in use, as far as the C library can (glibc's).

    It returns by itself only what is free at the end of its heap: a process that diagnoses one recording after another,
    a notebook or the proof, would keep the most that any search has held, and more each time.
    """
    if sys.platform != 'linux':  # elsewhere there may be no C library to ask by no name
        return
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
