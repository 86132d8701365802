"""One of many starts, and how several of them are made side by side."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from multiprocessing.synchronize import Event

import numpy as np

from gaitopt.design.attempt import attempt, is_walk
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import serve_parent, tune_process
from gaitopt.design.refine import with_work
from gaitopt.errors import GaitoptError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, ProgressCallback, Solution, Status, Stop, never

MakeProgress = Callable[[WalkProblem], ProgressCallback]

SLOWER = 0.75  # of the speed: where the second start comes from; measured
SECOND = 1  # number of the start that comes from there
ASKED_EVERY = 0.1  # s: how often `stop` is asked while other processes work
GRACE = 1.0  # s: for other processes to come to the end of an iteration when they are stopped

_stopped: Event | None = None  # of a worker process, given to it by its pool


@dataclass(frozen=True)
class Outcome:
    """Where one start led.

    Attributes:
        number: 0 is the first guess itself, 1 a slower walk, the others are perturbed.
        solution: what the solver made of it.
    """

    number: int
    solution: Solution

    @property
    def walks(self) -> bool:
        """Whether it is a feasible walk."""
        return is_walk(self.solution)


@dataclass(frozen=True)
class StartJob:
    """What a worker needs to make any of the starts.

    Attributes:
        robot, task: of the walk.
        options: how every start is made.
        x: the first guess, shape (P,).
        sigma, seed: of the noise on it.
    """

    robot: Robot
    task: Task
    options: DesignOptions
    x: Array
    sigma: float
    seed: int

    def run(
        self, number: int, on_progress: MakeProgress | None = None, stop: Stop = never
    ) -> Outcome:
        """Solve from one start.

        Args:
            number: of the start.
            on_progress: makes the progress callback of a walk.
            stop: asked at every iteration.
        """
        problem = WalkProblem(self.robot, self.task)
        slower = self._slower(on_progress, stop) if number == SECOND else None
        if slower is not None and slower.status is Status.INTERRUPTED:
            return Outcome(number, replace(slower, cost=np.nan, violation=np.inf))  # another walk
        callback = None if on_progress is None else on_progress(problem)
        if slower is not None:
            near = replace(self.options, approach="direct")
            solution = with_work(attempt(problem, near, slower.x, callback, stop), slower)
        else:
            start = self.x if number == 0 else self._perturbed(problem, number)
            solution = attempt(problem, self.options, start, callback, stop)
        return Outcome(number, solution)

    def _perturbed(self, problem: WalkProblem, number: int) -> Array:
        state = np.random.SeedSequence([self.seed, number]).generate_state(1)
        return perturbed(problem, self.x, self.sigma, int(state[0]))

    def _slower(self, on_progress: MakeProgress | None, stop: Stop) -> Solution | None:
        """Return the walk at a lower speed, None if there is none."""
        problem = WalkProblem(self.robot, replace(self.task, speed=SLOWER * self.task.speed))
        callback = None if on_progress is None else on_progress(problem)
        try:
            solution = attempt(problem, self.options, first_guess(problem), callback, stop)
        except UnreachableError:
            return None
        interrupted = solution.status is Status.INTERRUPTED
        return solution if interrupted or is_walk(solution) else None


def outcomes_of(
    job: StartJob,
    count: int,
    workers: int,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> Iterator[Outcome]:
    """Make the starts and yield their outcomes in order, until `stop` says True.

    Args:
        job: what is solved.
        count: number of starts.
        workers: processes.
        on_progress: makes the progress callback of a walk; not called with several processes.
        stop: asked at every iteration, and ten times a second for other processes, which then
            yield the best iterates of the starts that they were at.

    Raises:
        GaitoptError: a worker process died.
    """
    if workers == 1:
        for number in range(count):
            if number > 0 and stop():
                return
            yield job.run(number, on_progress, stop)
        return
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    stopped = context.Event()
    complete = False
    pool = ProcessPoolExecutor(workers, context, initializer=_begin_worker, initargs=(stopped,))
    try:
        futures = [pool.submit(_run_in_worker, job, number) for number in range(count)]
        for future in futures:
            while not (future.done() or stop()):
                wait([future], timeout=ASKED_EVERY)
            if stop():
                stopped.set()
                pool.shutdown(wait=False, cancel_futures=True)
                ended, _ = wait([f for f in futures if not f.cancelled()], timeout=GRACE)
                yield from (f.result() for f in futures[futures.index(future) :] if f in ended)
                break
            yield future.result()
        complete = not stop()
    except BrokenProcessPool as error:
        raise GaitoptError(
            "a worker process died; run with 1 worker, or see to it that the script starts its "
            'work under `if __name__ == "__main__":`'
        ) from error
    finally:
        if not complete:  # do not wait for starts that nobody wants
            for process in set(multiprocessing.active_children()) - others:
                process.kill()
        pool.shutdown(wait=True, cancel_futures=True)


def _begin_worker(stopped: Event) -> None:
    """Begin a worker process whose starts end when the event is set."""
    global _stopped
    serve_parent()
    tune_process()
    _stopped = stopped


def _run_in_worker(job: StartJob, number: int) -> Outcome:
    assert _stopped is not None
    return job.run(number, stop=_stopped.is_set)
