"""91 speeds by one worker and by two, beside version 0.1, and by simulated ones."""

from __future__ import annotations

import heapq
import tempfile
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any
from unittest.mock import patch

from common import arguments, reference_task, robot_of, save
from process import run

from gaitopt.design.process import tune_process
from gaitopt.model.robot import Robot
from gaitopt.sweep import scheduler
from gaitopt.sweep.executor import Job, JobOutcome, LocalWorkers
from gaitopt.sweep.grid import parse_axis

SPEEDS, QUICK = {"speed": "0.4:1.3:0.01"}, {"speed": "0.9:1.0:0.02"}
GRID = {"speed": "0.7:1.2:0.05", "duration": "0.36:0.44:0.01"}
COUNTS = (1, 2, 4, 10)
REPEATS = 3

Known = dict[tuple[object, ...], tuple[JobOutcome, float]]


class SimulatedWorkers(LocalWorkers):
    """Workers in simulated time: their jobs are done here, one after the other.

    A job takes the processor time that it took here, once for all counts of workers; the sweep
    itself takes its own. Messages take no time.

    Args:
        count: of workers.
        known: outcomes of jobs with the seconds they took; grows.
    """

    def __init__(self, count: int, known: Known) -> None:
        super().__init__(count)
        self.now, self._last, self._known = 0.0, time.process_time(), known
        self._free = [0.0] * count  # when each worker is
        self._asked: deque[tuple[float, Future[Any], Job]] = deque()
        self._ends: dict[Future[Any], tuple[float, JobOutcome]] = {}

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Put a job behind those that wait for a worker."""
        self._pass_time()
        future: Future[Any] = Future()
        self._asked.append((self.now, future, args[0]))
        return future

    def wait(self, futures: set[Future[Any]], return_when: str) -> Any:
        """Let time pass until one of some jobs is done."""
        del return_when
        self._pass_time()
        while self._asked:
            asked, future, job = self._asked.popleft()
            outcome, seconds = self._done(job)
            end = max(asked, heapq.heappop(self._free)) + seconds
            heapq.heappush(self._free, end)
            self._ends[future] = end, outcome
        first = min(futures, key=lambda one: self._ends[one][0])
        end, outcome = self._ends[first]
        self.now = max(self.now, end)
        if not first.done():
            first.set_result(outcome)
        self._last = time.process_time()
        return type("Done", (), {"done": {first}})

    def _pass_time(self) -> None:
        """Let the time pass that the sweep itself took since it was last looked at."""
        now = time.process_time()
        self.now, self._last = self.now + now - self._last, now

    def _done(self, job: Job) -> tuple[JobOutcome, float]:
        walk, near = job.walk, [(one.name, one.walk.cost) for one in job.neighbours]
        key = (job.kind, job.point, *near, job.cold_start, None if walk is None else walk.cost)
        if key not in self._known:
            outcome = scheduler.run_job(job)
            self._known[key] = outcome, outcome.seconds
        return self._known[key]


def simulated(robot: Robot, quantities: dict[str, str]) -> dict[str, Any]:
    """Return the seconds that a sweep takes by workers of each count, and its gaits."""
    axes = [parse_axis(name, text) for name, text in quantities.items()]
    known: Known = {}
    seconds, certified = {}, set()
    for count in COUNTS:
        workers = SimulatedWorkers(count, known)
        with tempfile.TemporaryDirectory() as folder, patch.object(scheduler, "wait", workers.wait):
            library = scheduler.sweep(
                robot, reference_task(), axes, Path(folder) / "library", executor=workers
            )
            certified.add(sum(row["certified"] for row in library.rows))
        seconds[count] = workers.now
    return {"quantities": quantities, "certified": sorted(certified), "seconds": seconds}


def measured(text: str, old: str | None, repeats: int) -> dict[str, list[dict[str, float]]]:
    """Return wall and processor time of the command with one worker and two, in turns."""
    words = ("sweep", "--quiet", "--speeds", text)
    sources = {"gaitopt": (None, ("--torsional-friction", "none"))}
    if old:
        sources["0.1"] = (old, ())
    found: dict[str, list[dict[str, float]]] = {}
    with tempfile.TemporaryDirectory() as compiled:
        for turn in range(repeats + 1):
            for name, (path, more) in sources.items():
                for count in (1, 2):
                    command = (*words, *more, "--workers", str(count), "--output")
                    taken = run(command, f"{compiled}/{name}", path)
                    if turn:  # the first time its modules are compiled
                        found.setdefault(f"{name}, {count}", []).append(taken)
    return found


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--old", help="directory of a clone of version 0.1")
    options = parser.parse_args()
    tune_process()
    robot, quick = robot_of(), options.quick
    sweeps, repeats = ((QUICK,), 1) if quick else ((SPEEDS, GRID), REPEATS)
    data = {
        "commands": measured(sweeps[0]["speed"], options.old, repeats),
        "simulated": [simulated(robot, quantities) for quantities in sweeps],
    }
    save("workers", data, quick)


if __name__ == "__main__":
    main()
