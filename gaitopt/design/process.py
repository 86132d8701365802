"""What a process does that has no other work than gaits: the command line and workers.

No function of the library changes its process; these are for programs that want it.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from gaitopt.errors import GaitoptError, reason_of

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing.process import BaseProcess
    from types import FrameType

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of glibc's mallopt
_THREADS = "OPENBLAS_NUM_THREADS"  # read by a BLAS that is loaded later: SciPy brings its own
_KEPT = 32 * 2**20  # bytes; glibc refuses a larger threshold for mmap
_POLL = 0.1  # s between two looks at processes that are to end


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):  # not on every system
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def small_matrices() -> Iterator[None]:
    """Run a block with one BLAS thread and without giving memory back between evaluations.

    Threads cost more than matrices of 43 columns are worth. And an allocator that returns half a
    megabyte to the system after every evaluation spends a quarter of the time on page faults; on
    glibc it is told to keep what it has, for the rest of the process.
    """
    before = os.environ.get(_THREADS)
    try:
        with tune_process():
            yield
    finally:
        if before is None:
            os.environ.pop(_THREADS, None)
        else:
            os.environ[_THREADS] = before


def tune_process() -> Any:
    """Do what `small_matrices` does for the rest of the process, or until what is returned ends."""
    from threadpoolctl import threadpool_limits

    if sys.platform.startswith("linux"):
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            mallopt(_TRIM_THRESHOLD, _KEPT)
            mallopt(_MMAP_THRESHOLD, _KEPT)
    os.environ[_THREADS] = "1"
    return threadpool_limits(limits=1, user_api="blas")


def can_be_copied() -> bool:
    """Return whether this process can be copied safely.

    A copy of a process with several threads may find locks held for good, and macOS copies none.
    """
    return sys.platform.startswith("linux") and threading.active_count() == 1


def worker_context() -> Any:
    """Return how to start processes: copied, which takes no time, where that is safe."""
    import multiprocessing  # which most commands do without

    return multiprocessing.get_context("fork" if can_be_copied() else "spawn")


@contextmanager
def starting_processes() -> Iterator[None]:
    """Tell in words that the system has no further process, pipe or lock to give.

    Raises:
        GaitoptError: it has none.
    """
    try:
        yield
    except OSError as error:
        raise GaitoptError(
            f"no worker can be started: {reason_of(error)}; ask for fewer workers, or end other "
            "programs"
        ) from error


def copy_that_does(work: Callable[[], object]) -> BaseProcess | None:
    """Return a copy of this process that works and ends, its exit code not 0 if it fails.

    Whether that is safe is for the caller to know, see `can_be_copied`.

    Returns:
        None where no process is to be had.
    """
    import multiprocessing

    copy = multiprocessing.get_context("fork").Process(target=_work, args=(work,))
    with warnings.catch_warnings(), suppress(OSError), without_ctrl_c():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads, by Python 3.12
        copy.start()
        return copy
    return None


def _work(work: Callable[[], object]) -> None:
    serve_parent()
    try:
        work()
    except Exception:  # told by the parent, which fails likewise when it does this itself
        sys.exit(1)


@contextmanager
def without_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C wait for the end of a block: amid the copying of a process it would be lost.

    Processes and threads started meanwhile never receive it.
    """
    if not hasattr(signal, "pthread_sigmask"):  # no POSIX
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    handler = signal.getsignal(signal.SIGINT)
    # Threads of BLAS take signals too, and Python then interrupts the main thread all the same.
    put_off = callable(handler) and threading.current_thread() is threading.main_thread()
    if put_off:
        signal.signal(signal.SIGINT, lambda number, frame: came.append((number, frame)))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if put_off:
            signal.signal(signal.SIGINT, handler)
            if came and callable(handler):
                handler(*came[0])


def serve_parent() -> None:
    """Leave Ctrl-C and its like to the parent process, and end when it ends, however that happens.

    A worker that waits for work would not notice: it holds an end of the pipe itself.
    """
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):  # sent to all processes of a terminal or service
        if hasattr(signal, name):
            with suppress(ValueError):  # not the main thread, which would not get it either
                signal.signal(getattr(signal, name), signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def kill(pool: ProcessPoolExecutor) -> None:
    """End the processes of a pool, which heed nothing else (see `serve_parent`)."""
    for process in [*(getattr(pool, "_processes", None) or {}).values()]:
        with suppress(Exception):  # it has ended
            process.kill()


def shut_down(pool: ProcessPoolExecutor, *, at_once: bool = False) -> None:
    """Wait until the processes of a pool have ended, also where some of them died amid their work.

    Python before 3.11.5 waits for ever where a process dies before it has read its job, if that is
    longer than a pipe holds: nobody reads it, and a thread goes on writing it (CPython's gh-94777).

    Args:
        at_once: kill its processes, whatever they do.
    """
    facts = vars(pool)  # taken before the shutdown, which forgets them
    thread, jobs = facts["_executor_manager_thread"], facts["_call_queue"]._reader
    processes = [*facts["_processes"].values()]
    if at_once:
        kill(pool)
    pool.shutdown(wait=False, cancel_futures=True)
    while thread is not None and thread.is_alive():
        thread.join(_POLL)
        if not (thread.pending_work_items or any(process.is_alive() for process in processes)):
            jobs.close()  # nobody will read it: who writes to it learns that now


def _end_with_parent() -> None:
    import multiprocessing

    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
