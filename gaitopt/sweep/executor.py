"""Jobs of a sweep, and executors that do them: any of `concurrent.futures`, or workers of Dask.

Only the sweep itself writes; workers take a job and send back what came of it. A job of a Dask
worker that dies is given to another.
"""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import resource_tracker
from typing import Any

from gaitopt.bounds import WORKERS, at_most, shown
from gaitopt.design.active_set import active_rows
from gaitopt.design.design import Design, design
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import leave_ctrl_c, small_matrices
from gaitopt.errors import InputError, MissingExtraError, NoGaitFoundError, UnreachableError
from gaitopt.gait.result import Gait
from gaitopt.sweep.continuation import Neighbour, continue_from
from gaitopt.sweep.grid import Index
from gaitopt.sweep.scenario import Scenario
from gaitopt.sweep.semi_infinite import finish
from gaitopt.sweep.table import Row, gait_row
from gaitopt.sweep.warm_start import WarmStart

CONTINUE, FINISH, DIAGNOSE = "continue", "finish", "diagnose"

START_SECONDS = 60.0  # for local workers to come up
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
        neighbours, substeps, cold_start, cost_limit: see `continue_from`.
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
    walk: WarmStart | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came of a job.

    Attributes:
        job: which.
        walk: if one was found or known.
        gait, row: the finished gait and its line of the table.
        refusal: why there is no gait, one thought each, JSON-able.
        seconds: of processor.
    """

    job: Job
    walk: WarmStart | None
    gait: Gait | None = None
    row: Row | None = None
    refusal: dict[str, object] | None = None
    seconds: float = 0.0


def run_job(job: Job) -> Outcome:
    """Do a job."""
    began = time.process_time()
    try:
        outcome = _WORK[job.kind](job)
    except InputError as error:  # a robot or task that cannot be, at this point of the grid
        outcome = Outcome(job, None, refusal={"sentences": [str(error)]})
    return replace(outcome, seconds=time.process_time() - began)


def run_job_alone(job: Job) -> Outcome:
    """Do a job in a process that has no other work than jobs: with one BLAS thread."""
    with small_matrices():
        return run_job(job)


def _continue(job: Job) -> Outcome:
    found = continue_from(
        job.scenario,
        job.neighbours,
        job.options,
        job.axes,
        substeps=job.substeps,
        cold_start=job.cold_start,
        cost_limit=job.cost_limit,
    )
    return Outcome(job, found)


def _finish(job: Job) -> Outcome:
    began = time.process_time()
    found = None if job.walk is None else finish(job.scenario, job.walk, job.options)
    if job.walk is None or found is None:
        return Outcome(job, None)
    return _finished(job, job.walk, found, began)


def _diagnose(job: Job) -> Outcome:
    """Design in the usual way, which explains a failure; sometimes it is none after all."""
    began = time.process_time()
    try:
        found = design(job.scenario.robot.build(), job.scenario.task, job.options)
    except (NoGaitFoundError, UnreachableError) as error:
        known = error.diagnosis
        record: dict[str, object] = {"sentences": [str(error)]}
        if isinstance(known, Diagnosis):
            record = {**known.record(), "sentences": [str(error), *known.sentences]}
        return Outcome(job, None, refusal=record)
    walk = WarmStart(
        x=found.solution.x,
        cost=found.solution.cost,
        active=active_rows(found.problem, found.solution.multipliers),
        cost_gradient=(None,) * len(job.axes),
        first_iterations=0,
        iterations=0,
        evaluations=0,
        seconds=0.0,
        origin="diagnosis",
    )
    return _finished(job, walk, found, began)


def _finished(job: Job, walk: WarmStart, found: Design, began: float) -> Outcome:
    seconds = walk.seconds + time.process_time() - began
    row = gait_row(found, walk, dict(job.axes), seconds)
    meta = {**found.gait.meta, "sweep": {"values": dict(job.axes), "origin": walk.origin}}
    return Outcome(job, walk, gait=replace(found.gait, meta=meta), row=row)


_WORK = {CONTINUE: _continue, FINISH: _finish, DIAGNOSE: _diagnose}


class DaskExecutor(Executor):
    """Workers of a Dask scheduler, reached or started for the first job.

    Args:
        connect: returns a client, and the cluster that was started for it if any; both are closed
            by `shutdown`.
    """

    def __init__(self, connect: Callable[[], tuple[Any, Any]]) -> None:
        self._connect = connect
        self._connected: tuple[Any, Any] | None = None
        self._remote: set[Any] = set()  # Dask forgets a job of which nobody holds the future

    def client(self) -> Any:
        """Return the client of Dask, connected by the first call."""
        if self._connected is None:
            self._connected = self._connect()
        return self._connected[0]

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send a call to the scheduler.

        The future raises BrokenExecutor where the call brought down one worker after another, or
        where the scheduler is gone.
        """
        future: Future[Any] = Future()
        remote = self.client().submit(fn, *args, pure=False, **kwargs)
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
            error: BaseException = BrokenExecutor(
                "a job ended with the death of every worker that took it; is there enough memory?"
            )
        except (CancelledError, OSError):
            error = BrokenExecutor("the connection to the scheduler was lost")
        except BaseException as raised:  # whatever the call raised is raised here
            error = raised
        else:
            future.set_result(outcome)
            return
        future.set_exception(error)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel what is not done; leave the scheduler, and stop it if it was started here."""
        del wait, cancel_futures
        if self._connected is None:
            return
        client, cluster = self._connected
        with suppress(Exception):  # whatever state it is in, it is no longer needed
            client.cancel(list(self._remote))
        for one in (client, cluster):
            if one is not None:
                with suppress(Exception):
                    one.close()


def local_workers(workers: int, on_start: Callable[[], None] = lambda: None) -> DaskExecutor:
    """Return processes on this machine, one thread each, started when there is work for them.

    A script must start its work under `if __name__ == "__main__":`, because each process imports
    it. Ctrl-C while they start stops them again.

    Args:
        workers: how many.
        on_start: called before they are started, which takes seconds.

    Raises:
        InputError: fewer than one worker.
        MissingExtraError: Dask distributed is not installed.
    """
    if workers < 1:
        raise InputError(f"{shown(workers)} workers are too few; give at least 1")
    at_most(workers, WORKERS, "workers")
    _distributed()

    def connect() -> tuple[Any, Any]:
        on_start()
        # Ctrl-C amid its start leaves Dask in disorder, so that it starts in a thread of its own,
        # whose processes inherit that they never receive it.
        with ThreadPoolExecutor(1, initializer=_block_ctrl_c) as pool:
            starting = pool.submit(_local_cluster, workers)
            try:
                return starting.result()
            except KeyboardInterrupt:
                _stop(starting)
                raise

    return DaskExecutor(connect)


def _stop(starting: Future[tuple[Any, Any]]) -> None:
    """Stop workers once they are there, whatever is pressed meanwhile."""
    while not starting.done():
        with suppress(KeyboardInterrupt):
            wait([starting])
    if starting.exception() is None:
        for one in starting.result():
            with suppress(Exception):
                one.close()


def _block_ctrl_c() -> None:
    if hasattr(signal, "pthread_sigmask"):  # POSIX
        resource_tracker.ensure_running()  # else it starts with the first process, and unblocks
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _local_cluster(workers: int) -> tuple[Any, Any]:
    distributed = _distributed()
    cluster = distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        dashboard_address="127.0.0.1:0",  # any free port; with None it warns if 8787 is taken
        host="127.0.0.1",
        silence_logs=50,
        preload=[__name__],
    )
    return distributed.Client(cluster, timeout=START_SECONDS), cluster


def joined_scheduler(address: str) -> DaskExecutor:
    """Return the workers of a Dask scheduler, as tcp://10.0.0.1:8786.

    Raises:
        InputError: there is none at the address, or it has no workers.
        MissingExtraError: Dask distributed is not installed.
    """
    distributed = _distributed()
    try:
        client = distributed.Client(address, timeout=REACH_SECONDS)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"no Dask scheduler answers at '{address}' within {REACH_SECONDS:g} s; start one by "
            "'dask scheduler' and give the address that it prints, as tcp://10.0.0.1:8786, or use "
            "this machine: --workers N"
        ) from error
    if not client.nthreads():
        client.close()
        raise InputError(f"the scheduler at '{address}' has no workers; start some: dask worker")
    executor = DaskExecutor(lambda: (client, None))
    executor.client()  # so that `shutdown` leaves it
    return executor


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the sweep; Dask calls this in each local worker as it starts."""
    del worker
    leave_ctrl_c()


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise MissingExtraError("a sweep on several workers", "cluster") from error
    return distributed
