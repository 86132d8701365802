"""Jobs of a sweep, and who does them: processes on this machine, or workers of Dask on others.

Only the sweep itself writes; workers take a job and send back what came of it. A job whose worker
dies is given to another.
"""

from __future__ import annotations

import gc
import math
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

from gaitopt.bounds import WORKERS, at_most, shown
from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import active_rows
from gaitopt.design.design import design
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.design.process import (
    kill,
    serve_parent,
    shut_down,
    small_matrices,
    starting_processes,
    tune_process,
    without_ctrl_c,
    worker_context,
)
from gaitopt.errors import (
    GaitoptError,
    InputError,
    MissingExtraError,
    NoGaitFoundError,
    UnreachableError,
    plugins_told,
)
from gaitopt.gait.gait_file import gait_bytes
from gaitopt.settings import checked_arguments
from gaitopt.sweep.continuation import Line, Neighbour, WarmStart, continue_from, finish
from gaitopt.sweep.grid import Index, Scenario
from gaitopt.sweep.table import Row, gait_row

ATTEMPTS = 3  # of a job whose worker dies
_DEADLY = "a job ended with the death of every worker that took it; is there enough memory?"
_COLLECTED_AFTER = 20_000
"""Objects after which a worker looks for cycles; Python's 700 come with every evaluation, and the
search takes a thirtieth of the time."""


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

        Raises:
            GaitoptError: no worker can be started.
        """
        future: Future[Any] = Future()
        self._hand_on(future, partial(fn, *args, **kwargs), 1)
        return future

    def _hand_on(self, future: Future[Any], call: Callable[[], Any], attempt: int) -> None:
        while True:
            with self._lock, starting_processes():
                pool = self._pool = self._pool or self._started()
            try:
                with without_ctrl_c(), starting_processes():
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
                try:
                    self._hand_on(future, call, attempt + 1)
                    return
                except GaitoptError as none_to_be_had:  # raised here it would be lost
                    error = none_to_be_had
            else:
                error = BrokenExecutor(_DEADLY)
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
        """Have no more to do with a pool of which a worker has died."""
        # If that one was waiting for a job, the others wait for its lock, for ever.
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
    gc.freeze()  # what the copied process had is not looked through again
    gc.set_threshold(_COLLECTED_AFTER)


@checked_arguments
def local_workers(workers: int, on_start: Callable[[], None] = lambda: None) -> LocalWorkers:
    """Return processes on this machine, one thread each, started when there is work for them.

    A script must start its work under `if __name__ == "__main__":`, because where processes cannot
    be copied each of them imports it.

    Args:
        on_start: called before they are started.

    Raises:
        InputError: fewer than one worker.
    """
    if workers < 1:
        raise InputError(f"{shown(workers)} workers are too few; give at least 1")
    at_most(workers, WORKERS, "workers")
    return LocalWorkers(workers, on_start)


CONTINUE, FINISH, DIAGNOSE = "continue", "finish", "diagnose"

REACH_SECONDS = 8.0  # to reach a scheduler that is there


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be done for a point; the answer depends on nothing else.

    Attributes:
        kind: CONTINUE to a walk from its neighbours, FINISH a walk as a gait, or DIAGNOSE why there
            is none.
        point: which.
        scenario: its robot and task.
        axes: swept quantities with their values there.
        options: as of `design`.
        neighbours, substeps, cold_start, cost_limit, line: see `continue_from`.
        walk: to be finished.
    """

    kind: str
    point: Index
    scenario: Scenario
    axes: tuple[tuple[str, float], ...]
    options: DesignOptions
    neighbours: tuple[Neighbour, ...] = ()
    substeps: bool = False
    cold_start: bool = False
    cost_limit: float = math.inf
    line: Line = ()
    walk: WarmStart | None = None


@dataclass(frozen=True, eq=False)
class JobOutcome:
    """What came of a job.

    Attributes:
        job: which.
        walk: if one was found or known.
        file, row: the finished gait, as its file holds it, and its line of the table.
        refusal: why there is no gait, one thought each, JSON-able.
        seconds: of processor.
    """

    job: Job
    walk: WarmStart | None
    file: bytes | None = None
    row: Row | None = None
    refusal: dict[str, object] | None = None
    seconds: float = 0.0


@plugins_told()
def run_job(job: Job) -> JobOutcome:
    """Do a job.

    Raises:
        InputError: a plugin fails in it.
    """
    began = time.process_time()
    try:
        outcome = _WORK[job.kind](job)
    except InputError as error:  # a robot or task that cannot be, at this point of the grid
        outcome = JobOutcome(job, None, refusal={"sentences": [str(error)]})
    return replace(outcome, seconds=time.process_time() - began)


def run_job_alone(job: Job) -> JobOutcome:
    """Do a job in a process that has no other work than jobs: with one BLAS thread."""
    with small_matrices():
        return run_job(job)


def _continue(job: Job) -> JobOutcome:
    how = {n: getattr(job, n) for n in ("substeps", "cold_start", "cost_limit", "line")}
    walk = continue_from(job.scenario, job.neighbours, job.options, job.axes, **how)
    return JobOutcome(job, walk)


def _finish(job: Job) -> JobOutcome:
    began = time.process_time()
    found = None if job.walk is None else finish(job.scenario, job.walk, job.options)
    if job.walk is None or found is None:
        return JobOutcome(job, None)
    return _finished(job, job.walk, found, began)


def _diagnose(job: Job) -> JobOutcome:
    """Design in the usual way, which explains a failure; sometimes it is none after all."""
    began = time.process_time()
    try:
        found = design(job.scenario.robot.build(), job.scenario.task, job.options)
    except (NoGaitFoundError, UnreachableError) as error:
        known = error.diagnosis
        record: dict[str, object] = {"sentences": [str(error)]}
        if isinstance(known, Diagnosis):
            record = {**known.record(), "sentences": [str(error), *known.sentences]}
        return JobOutcome(job, None, refusal=record)
    solution = found.solution
    active, slopes = active_rows(found.problem, solution.multipliers), (None,) * len(job.axes)
    walk = WarmStart(solution.x, solution.cost, active, slopes, 0, 0, 0, 0.0, "diagnosis")
    return _finished(job, walk, found, began)


def _finished(job: Job, walk: WarmStart, found: Design, began: float) -> JobOutcome:
    seconds = walk.seconds + time.process_time() - began
    row = gait_row(found, walk, dict(job.axes), seconds)
    place = {"sweep": {"values": dict(job.axes), "origin": walk.origin}}
    return JobOutcome(job, walk, file=gait_bytes(found.gait, place), row=row)


_WORK = {CONTINUE: _continue, FINISH: _finish, DIAGNOSE: _diagnose}


class DaskExecutor(Executor):
    """Workers of a Dask scheduler.

    Args:
        client: of the scheduler; closed by `shutdown`.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._remote: set[Any] = set()  # Dask forgets a job of which nobody holds the future

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send a call to the scheduler.

        The future raises BrokenExecutor where the call brought down one worker after another, or
        where the scheduler is gone.
        """
        future: Future[Any] = Future()
        remote = self._client.submit(fn, *args, pure=False, **kwargs)
        self._remote.add(remote)
        remote.add_done_callback(partial(self._pass_on, future))
        return future

    def _pass_on(self, future: Future[Any], remote: Any) -> None:
        from distributed import CancelledError, KilledWorker

        self._remote.discard(remote)
        if not future.set_running_or_notify_cancel():
            return
        try:
            outcome = remote.result()
        except KilledWorker:
            error: BaseException = BrokenExecutor(_DEADLY)
        except (CancelledError, OSError):
            error = BrokenExecutor("the connection to the scheduler was lost")
        except BaseException as raised:  # whatever the call raised is raised here
            error = raised
        else:
            future.set_result(outcome)
            return
        future.set_exception(error)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel what is not done, and leave the scheduler."""
        del wait, cancel_futures
        with suppress(Exception):  # whatever state it is in, it is no longer needed
            self._client.cancel(list(self._remote))
        with suppress(Exception):
            self._client.close()


@checked_arguments
def joined_scheduler(address: str) -> DaskExecutor:
    """Return the workers of a Dask scheduler, as tcp://10.0.0.1:8786.

    Raises:
        InputError: there is none at the address, or it has no workers.
        MissingExtraError: Dask distributed is not installed.
    """
    try:
        import distributed
    except ImportError as error:
        raise MissingExtraError("a sweep on several workers", "cluster") from error
    try:
        dask: Any = distributed
        client: Any = dask.Client(address, timeout=REACH_SECONDS)
    except Exception as error:  # a server of another kind may answer anything
        raise InputError(
            f"no Dask scheduler answers at '{address}' within {REACH_SECONDS:g} s; start one by "
            "'dask scheduler' and give the address that it prints, as tcp://10.0.0.1:8786, or use "
            "this machine: --workers N"
        ) from error
    if not client.nthreads():
        client.close()
        raise InputError(f"the scheduler at '{address}' has no workers; start some: dask worker")
    return DaskExecutor(client)
