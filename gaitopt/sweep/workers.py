"""Processes on this machine that do the jobs of a sweep, one each."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from functools import partial
from typing import Any

from gaitopt.bounds import WORKERS, at_most, shown
from gaitopt.design.process import (
    kill,
    serve_parent,
    shut_down,
    tune_process,
    without_ctrl_c,
    worker_context,
)
from gaitopt.errors import InputError

ATTEMPTS = 3  # of a job whose worker dies


class LocalWorkers(Executor):
    """Processes on this machine, started for the first job.

    A job whose worker dies is given to another.

    Args:
        count: how many.
        on_start: called before they are started.

    Attributes:
        count: how many.
    """

    def __init__(self, count: int, on_start: Callable[[], None] = lambda: None) -> None:
        self.count, self._on_start = count, on_start
        self._pool: ProcessPoolExecutor | None = None
        self._broken: list[ProcessPoolExecutor] = []
        self._begun = False
        self._lock = threading.Lock()
        self._closed = False

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Have a call made by the next worker that is free.

        The future raises BrokenExecutor where the call brought down one worker after another.
        """
        future: Future[Any] = Future()
        self._hand_on(future, partial(fn, *args, **kwargs), 1)
        return future

    def _hand_on(self, future: Future[Any], call: Callable[[], Any], attempt: int) -> None:
        while True:
            with self._lock:
                pool = self._pool = self._pool or self._started()
            try:
                with without_ctrl_c():
                    inner = pool.submit(call)  # the first one starts the processes
                break
            except BrokenExecutor:  # a worker has died while nobody looked
                self._forget(pool)
        inner.add_done_callback(partial(self._pass_on, future, pool, call, attempt))

    def _pass_on(
        self,
        future: Future[Any],
        pool: ProcessPoolExecutor,
        call: Callable[[], Any],
        attempt: int,
        inner: Future[Any],
    ) -> None:
        if inner.cancelled() or self._closed:
            future.cancel()
            return
        error = inner.exception()
        if isinstance(error, BrokenExecutor):
            self._forget(pool)
            if attempt < ATTEMPTS:
                self._hand_on(future, call, attempt + 1)
                return
            error = BrokenExecutor(
                "a job ended with the death of every worker that took it; is there enough memory?"
            )
        if not future.set_running_or_notify_cancel():
            return
        if error is None:
            future.set_result(inner.result())
        else:
            future.set_exception(error)

    def _started(self) -> ProcessPoolExecutor:
        if not self._begun:
            self._begun = True
            with without_ctrl_c():  # amid a print it would have the same line printed again
                self._on_start()
        return ProcessPoolExecutor(self.count, worker_context(), initializer=_prepare)

    def _forget(self, pool: ProcessPoolExecutor) -> None:
        """Have no more to do with a pool of which a worker has died.

        If that one was waiting for a job, the others wait for its lock, for ever.
        """
        with self._lock:
            if self._pool is pool:
                self._pool = None
                self._broken.append(pool)
        kill(pool)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop the workers, whatever they do."""
        del wait, cancel_futures
        self._closed = True
        with self._lock:
            pools = [*self._broken, *([self._pool] if self._pool else [])]
            self._pool, self._broken = None, []
        for pool in reversed(pools):  # later processes may hold pipes of earlier ones
            shut_down(pool, at_once=True)


def _prepare() -> None:
    serve_parent()
    tune_process()


def local_workers(workers: int, on_start: Callable[[], None] = lambda: None) -> LocalWorkers:
    """Return processes on this machine, one thread each, started when there is work for them.

    A script must start its work under `if __name__ == "__main__":`, because where processes cannot
    be copied each of them imports it.

    Args:
        workers: how many.
        on_start: called before they are started.

    Raises:
        InputError: fewer than one worker.
    """
    if workers < 1:
        raise InputError(f"{shown(workers)} workers are too few; give at least 1")
    at_most(workers, WORKERS, "workers")
    return LocalWorkers(workers, on_start)
