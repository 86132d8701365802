"""Jobs of a sweep, and who does them: this process, or workers of Dask here or elsewhere.

Only the sweep itself writes; workers take a job and send back what came of it. A job whose worker
dies is given to another.
"""

from __future__ import annotations

import math
import signal
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import resource_tracker
from typing import Any

from gaitopt.bounds import WORKERS, at_most, shown
from gaitopt.design.active_set import pressures
from gaitopt.design.design import Design, design
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import leave_ctrl_c, small_matrices
from gaitopt.errors import (
    GaitoptError,
    InputError,
    MissingExtraError,
    NoGaitFoundError,
    UnreachableError,
)
from gaitopt.gait.result import Gait
from gaitopt.sweep.continuation import Near, travel
from gaitopt.sweep.grid import Index
from gaitopt.sweep.scenario import Setting
from gaitopt.sweep.semi_infinite import finish, stop_if_interrupted
from gaitopt.sweep.table import Row, index_row
from gaitopt.sweep.warm_start import Footing

TRAVEL, FINISH, DIAGNOSE = "travel", "finish", "diagnose"


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be done for a point; the answer depends on nothing else.

    Attributes:
        kind: TRAVEL to a walk from its neighbours, FINISH a walk as a gait, or DIAGNOSE why there
            is none.
        point: which.
        setting: its robot and task.
        axes: swept quantities with their values there.
        options: as of `design`.
        near: neighbours to travel from.
        patient, cold: what else to try, see `travel`.
        below: cost of a walk that would not be wanted, see `travel`.
        walk: to be finished.
    """

    kind: str
    point: Index
    setting: Setting
    axes: tuple[tuple[str, float], ...]
    options: DesignOptions
    near: tuple[Near, ...] = ()
    patient: bool = False
    cold: bool = False
    below: float = math.inf
    walk: Footing | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came of a job.

    Attributes:
        job: which.
        footing: a walk, if one was found or known.
        gait, row: the finished gait and its line of the index.
        refusal: why there is no gait, one thought each, JSON-able.
        seconds: of processor.
    """

    job: Job
    footing: Footing | None
    gait: Gait | None = None
    row: Row | None = None
    refusal: dict[str, object] | None = None
    seconds: float = 0.0


class Crew(ABC):
    """Does jobs.

    Attributes:
        room: jobs it can usefully hold at a time.
    """

    room: int

    @abstractmethod
    def submit(self, job: Job) -> None:
        """Take a job."""

    @abstractmethod
    def next(self) -> Outcome:
        """Return the next outcome, whichever job it is of; wait if there is none yet."""

    @abstractmethod
    def close(self) -> None:
        """Give up what is not done and leave."""


class Alone(Crew):
    """This process, one job after another."""

    def __init__(self) -> None:
        self.room = 1
        self._jobs: deque[Job] = deque()

    def submit(self, job: Job) -> None:
        """Take a job."""
        self._jobs.append(job)

    def next(self) -> Outcome:
        """Do the oldest job."""
        return run_job(self._jobs.popleft())

    def close(self) -> None:
        """Forget the rest."""
        self._jobs.clear()


def run_job(job: Job) -> Outcome:
    """Do a job, with one BLAS thread.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    began = time.process_time()
    with small_matrices():
        try:
            outcome = _WORK[job.kind](job)
        except InputError as error:  # a robot or task that cannot be, at this point of the grid
            outcome = Outcome(job, None, refusal={"sentences": [str(error)]})
    return replace(outcome, seconds=time.process_time() - began)


def _travel(job: Job) -> Outcome:
    found = travel(
        job.setting,
        job.near,
        job.options,
        job.axes,
        patient=job.patient,
        cold=job.cold,
        below=job.below,
    )
    return Outcome(job, found)


def _finish(job: Job) -> Outcome:
    began = time.process_time()
    found = None if job.walk is None else finish(job.setting, job.walk, job.options)
    if job.walk is None or found is None:
        return Outcome(job, None)
    return _told(job, job.walk, found, began)


def _diagnose(job: Job) -> Outcome:
    """Design in the usual way, which explains a failure; sometimes it is none after all."""
    began = time.process_time()
    try:
        found = design(job.setting.robot.build(), job.setting.task, job.options)
    except (NoGaitFoundError, UnreachableError) as error:
        stop_if_interrupted(getattr(error, "solution", None))
        known = error.diagnosis
        record: dict[str, object] = {"sentences": [str(error)]}
        if isinstance(known, Diagnosis):
            record = {**known.record(), "sentences": [str(error), *known.sentences]}
        return Outcome(job, None, refusal=record)
    stop_if_interrupted(found.solution)
    footing = Footing(
        x=found.solution.x,
        cost=found.solution.cost,
        active=pressures(found.problem, found.solution.multipliers),
        slopes=(None,) * len(job.axes),
        journey=0,
        iterations=0,
        evaluations=0,
        seconds=0.0,
        origin="diagnosis",
    )
    return _told(job, footing, found, began)


def _told(job: Job, footing: Footing, found: Design, began: float) -> Outcome:
    seconds = footing.seconds + time.process_time() - began
    row = index_row(found, footing, dict(job.axes), seconds)
    meta = {**found.gait.meta, "sweep": {"values": dict(job.axes), "origin": footing.origin}}
    return Outcome(job, footing, gait=replace(found.gait, meta=meta), row=row)


_WORK = {TRAVEL: _travel, FINISH: _finish, DIAGNOSE: _diagnose}


AHEAD = 3  # jobs in hand per worker, so that none waits for the next
START = 60.0  # s for local workers to come up
REACH = 8.0  # s to reach a scheduler that is there


class DaskCrew(Crew):
    """Workers of a Dask scheduler."""

    def __init__(self, client: Any, cluster: Any = None) -> None:
        """Take over a client, and the cluster that was started for it if any; both are closed."""
        self.client, self._cluster = client, cluster
        threads = sum(client.nthreads().values())
        self.room = AHEAD * max(1, threads)
        self._flying: Any = _distributed().as_completed([])

    def submit(self, job: Job) -> None:
        """Send a job to the scheduler."""
        self._flying.add(self.client.submit(run_job, job, pure=False))

    def next(self) -> Outcome:
        """Wait for the next outcome.

        Raises:
            GaitoptError: a job brought down one worker after another, or the scheduler is gone.
        """
        from distributed import CancelledError, KilledWorker

        future = next(self._flying)
        try:
            outcome: Outcome = future.result()
        except KilledWorker as error:
            raise GaitoptError(
                "a job ended with the death of every worker that took it; is there enough memory? "
                "what was finished is kept, and the same command goes on"
            ) from error
        except (CancelledError, OSError) as error:
            raise GaitoptError(
                "the connection to the scheduler was lost; what was finished is kept, and the same "
                "command goes on"
            ) from error
        return outcome

    def close(self) -> None:
        """Cancel what is not done; leave the scheduler, and stop it if it was started here."""
        with suppress(Exception):  # whatever state it is in, it is no longer needed
            self.client.cancel(self._flying.futures.keys())
        with suppress(Exception):
            self.client.close()
        if self._cluster is not None:
            with suppress(Exception):
                self._cluster.close()


class LaterCrew(Crew):
    """Processes on this machine that are started when there is work for them, see `local_crew`."""

    def __init__(self, workers: int, on_start: Callable[[], None]) -> None:
        """Promise some workers.

        Args:
            workers: how many.
            on_start: told before they are started, which takes seconds.

        Raises:
            InputError: fewer than one worker.
            MissingExtraError: Dask distributed is not installed.
        """
        _require_workers(workers)
        _distributed()
        self.room = AHEAD * workers
        self._workers, self._on_start = workers, on_start
        self._crew: DaskCrew | None = None

    def submit(self, job: Job) -> None:
        """Send a job to the workers; start them before the first."""
        if self._crew is None:
            self._on_start()
            self._crew = local_crew(self._workers)
        self._crew.submit(job)

    def next(self) -> Outcome:
        """Wait for the next outcome, as `DaskCrew` does."""
        if self._crew is None:
            raise GaitoptError("no job was given to the workers yet")
        return self._crew.next()

    def close(self) -> None:
        """Stop the workers, if they were started."""
        if self._crew is not None:
            self._crew.close()


def local_crew(workers: int) -> DaskCrew:
    """Start processes on this machine, one thread each.

    A script must start its work under `if __name__ == "__main__":`, because each process imports
    it.

    Raises:
        InputError: fewer than one worker.
        MissingExtraError: Dask distributed is not installed.
        KeyboardInterrupt: Ctrl-C was pressed meanwhile; the workers are stopped again.
    """
    _require_workers(workers)
    _distributed()
    # Ctrl-C amid its start leaves Dask in disorder, so that it starts in a thread of its own, whose
    # processes inherit that they never receive it.
    with ThreadPoolExecutor(1, initializer=_block_ctrl_c) as pool:
        starting = pool.submit(_started, workers)
        try:
            return starting.result()
        except KeyboardInterrupt:
            _stop(starting)
            raise


def _stop(starting: Future[DaskCrew]) -> None:
    """Stop workers once they are there, whatever is pressed meanwhile."""
    while not starting.done():
        with suppress(KeyboardInterrupt):
            wait([starting])
    if starting.exception() is None:
        starting.result().close()


def _block_ctrl_c() -> None:
    if hasattr(signal, "pthread_sigmask"):  # POSIX
        resource_tracker.ensure_running()  # else it starts with the first process, and unblocks
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _require_workers(workers: int) -> None:
    if workers < 1:
        raise InputError(f"{shown(workers)} workers are too few; give at least 1")
    at_most(workers, WORKERS, "workers")


def _started(workers: int) -> DaskCrew:
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
    client = distributed.Client(cluster, timeout=START)
    return DaskCrew(client, cluster)


def joined_crew(address: str) -> DaskCrew:
    """Join a scheduler, as tcp://10.0.0.1:8786.

    Raises:
        InputError: there is none at the address, or it has no workers.
        MissingExtraError: Dask distributed is not installed.
    """
    distributed = _distributed()
    try:
        client = distributed.Client(address, timeout=REACH)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"no Dask scheduler answers at '{address}' within {REACH:g} s; start one by 'dask "
            "scheduler' and give the address that it prints, as tcp://10.0.0.1:8786, or use this "
            "machine: --workers N"
        ) from error
    if not client.nthreads():
        client.close()
        raise InputError(f"the scheduler at '{address}' has no workers; start some: dask worker")
    return DaskCrew(client)


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
