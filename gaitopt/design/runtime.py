"""Process settings for many small matrices: one BLAS thread, and memory that is kept."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of glibc's mallopt
_KEPT = 32 * 2**20  # bytes; glibc refuses a larger threshold for mmap


@contextmanager
def small_matrices() -> Iterator[None]:
    """Run a block with one BLAS thread and without giving memory back between evaluations.

    Threads cost more than matrices of 43 columns are worth. And an allocator that returns half a
    megabyte to the system after every evaluation spends a quarter of the time on page faults; on
    glibc it is told to keep what it has, for the rest of the process.
    """
    import scipy.optimize  # noqa: F401  its BLAS must be loaded to be limited
    from threadpoolctl import threadpool_limits

    if sys.platform.startswith("linux"):
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            mallopt(_TRIM_THRESHOLD, _KEPT)
            mallopt(_MMAP_THRESHOLD, _KEPT)
    with threadpool_limits(limits=1, user_api="blas"):
        yield
