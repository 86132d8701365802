"""What a process does that has no other work than gaits: the command line and workers.

No function of the library changes its process; these are for programs that want it.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of glibc's mallopt
_THREADS = "OPENBLAS_NUM_THREADS"  # read by a BLAS that is loaded later: SciPy brings its own
_KEPT = 32 * 2**20  # bytes; glibc refuses a larger threshold for mmap


@contextmanager
def small_matrices() -> Iterator[None]:
    """Run a block with one BLAS thread and without giving memory back between evaluations.

    Threads cost more than matrices of 43 columns are worth. And an allocator that returns half a
    megabyte to the system after every evaluation spends a quarter of the time on page faults; on
    glibc it is told to keep what it has, for the rest of the process.
    """
    from threadpoolctl import threadpool_limits

    _keep_memory()
    before = os.environ.get(_THREADS)
    os.environ[_THREADS] = "1"
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            yield
    finally:
        if before is None:
            os.environ.pop(_THREADS, None)
        else:
            os.environ[_THREADS] = before


def tune_process() -> None:
    """Do what `small_matrices` does for the rest of the process."""
    from threadpoolctl import threadpool_limits

    _keep_memory()
    os.environ[_THREADS] = "1"
    threadpool_limits(limits=1, user_api="blas")


def _keep_memory() -> None:
    if sys.platform.startswith("linux"):
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            mallopt(_TRIM_THRESHOLD, _KEPT)
            mallopt(_MMAP_THRESHOLD, _KEPT)


def worker_context() -> Any:
    """Return how to start processes: copied, which takes no time, where that is safe.

    A copy of a process with several threads may find locks held for good, and macOS copies none.
    """
    import multiprocessing  # which most commands do without

    copied = sys.platform.startswith("linux") and threading.active_count() == 1
    return multiprocessing.get_context("fork" if copied else "spawn")


@contextmanager
def without_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C wait for the end of a block: amid the copying of a process it would be lost.

    Processes and threads started meanwhile never receive it.
    """
    if not hasattr(signal, "pthread_sigmask"):  # no POSIX
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve_parent() -> None:
    """Leave Ctrl-C and its like to the parent process, and end when it ends, however that happens.

    A worker that waits for work would not notice: it holds an end of the pipe itself.
    """
    leave_ctrl_c()
    for name in ("SIGTERM", "SIGHUP"):  # sent to all processes of a service or a terminal
        if hasattr(signal, name):
            with suppress(ValueError):
                signal.signal(getattr(signal, name), signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def leave_ctrl_c() -> None:
    """Do not take Ctrl-C, which a terminal sends to all processes of a command."""
    with suppress(ValueError):  # not the main thread: then it would not get the signal either
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end_with_parent() -> None:
    import multiprocessing

    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
