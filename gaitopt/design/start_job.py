"""One of many starts, and how several of them are made side by side."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace

import numpy as np

from gaitopt.design.attempt import attempt, is_walk
from gaitopt.design.options import DesignOptions
from gaitopt.design.refine import with_work
from gaitopt.design.runtime import small_matrices
from gaitopt.design.worker import serve_parent
from gaitopt.errors import GaitoptError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.nlp import Array, Solution, Status
from gaitopt.robot.model import Robot

SLOWER = 0.75  # of the speed: where the second start comes from; measured
SECOND = 1  # number of the start that comes from there


@dataclass(frozen=True)
class Outcome:
    """Where one start led.

    Attributes:
        number: 0 is the first guess itself, 1 a slower walk, the others are perturbed.
        solution: without history.
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

    def run(self, number: int) -> Outcome:
        """Solve from one start."""
        problem = WalkProblem(self.robot, self.task)
        with small_matrices():
            slower = self._slower() if number == SECOND else None
            if slower is None:
                start = self.x if number == 0 else self._perturbed(problem, number)
                solution = attempt(problem, self.options, start)
            elif slower.status is Status.INTERRUPTED:
                solution = replace(slower, cost=np.nan, violation=np.inf)  # of another walk
            else:
                near = replace(self.options, approach="direct")
                solution = with_work(attempt(problem, near, slower.x), slower)
        return Outcome(number, replace(solution, history=()))

    def _perturbed(self, problem: WalkProblem, number: int) -> Array:
        state = np.random.SeedSequence([self.seed, number]).generate_state(1)
        return perturbed(problem, self.x, self.sigma, int(state[0]))

    def _slower(self) -> Solution | None:
        """Return the walk at a lower speed, None if there is none."""
        problem = WalkProblem(self.robot, replace(self.task, speed=SLOWER * self.task.speed))
        try:
            solution = attempt(problem, self.options, first_guess(problem))
        except UnreachableError:
            return None
        interrupted = solution.status is Status.INTERRUPTED
        return solution if interrupted or is_walk(solution) else None


def outcomes_of(job: StartJob, count: int, workers: int) -> Iterator[Outcome]:
    """Make the starts and yield their outcomes in order.

    Raises:
        GaitoptError: a worker process died.
    """
    if workers == 1:
        yield from map(job.run, range(count))
        return
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=serve_parent)
    try:
        yield from pool.map(job.run, range(count))
    except BrokenProcessPool as error:
        raise GaitoptError(
            "a worker process died; run with 1 worker, or see to it that the script starts its "
            'work under `if __name__ == "__main__":`'
        ) from error
    except BaseException:  # Ctrl-C as well: do not wait for starts that nobody wants
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
