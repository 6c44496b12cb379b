"""Threads of linear algebra: one.

The diagnosis runs simulations on its own threads, and its matrices are small. Threads of BLAS that wait for each other
by spinning then cost several times what they save, most of all beside other work.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

LINEAR_ALGEBRA = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')


def one_of_linear_algebra() -> None:
    """Ask for one thread, unless the user has asked for another number. To be called before numpy is loaded."""
    for variable in LINEAR_ALGEBRA:
        os.environ.setdefault(variable, '1')


@contextmanager
def with_one_of_linear_algebra() -> Iterator[None]:
    """One thread for as long as this lasts, where numpy was loaded before, as in a notebook.

    As far as threadpoolctl is installed (extra ``labs``); else as it was.
    """
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        yield
        return
    with threadpool_limits(1, user_api='blas'):
        yield
