"""A crew on Dask: workers of this machine, or those of any scheduler there is.

Only the sweep itself writes; workers take a job and send back what came of it. A job whose worker
dies is given to another.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from multiprocessing import resource_tracker
from typing import Any

from gaitopt.bounds import WORKERS, at_most, shown
from gaitopt.design.worker import leave_ctrl_c
from gaitopt.errors import GaitoptError, InputError, MissingExtraError
from gaitopt.study.jobs import Crew, Job, Outcome, run_job

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
