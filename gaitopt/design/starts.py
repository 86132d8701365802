"""Many starts: several strict local optima exist, so search from several first guesses."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace

import numpy as np

from gaitopt.design.design import Design, design
from gaitopt.design.options import DesignOptions
from gaitopt.design.runtime import small_matrices
from gaitopt.design.search import FEASIBLE, traveller
from gaitopt.errors import GaitoptError, InputError, UnreachableError
from gaitopt.gait.guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.nlp import Array, ProgressCallback, Solution, Start, Status
from gaitopt.robot.model import Robot
from gaitopt.solvers import Solver

SIGMA = 0.1  # rad and rad/s: still a walk, no longer the same one; measured
COUNT = 4  # measured: enough for 95 % of runs to find the best, docs/diagnosis.md has the exception
SAME_COST = 1e-4  # relative
SAME_PLACE = 0.05  # largest difference of parameters over their scale


@dataclass(frozen=True)
class Outcome:
    """Where one start led.

    Attributes:
        number: 0 is the first guess itself, the others are perturbed.
        solution: without history.
    """

    number: int
    solution: Solution

    @property
    def walks(self) -> bool:
        """Whether it is a feasible walk."""
        return bool(np.isfinite(self.solution.cost)) and self.solution.violation <= FEASIBLE


@dataclass(frozen=True)
class Optimum:
    """One of the distinct optima.

    Attributes:
        cost: [N²·m·s].
        x: parameters, shape (P,).
        starts: numbers of the starts that led to it.
    """

    cost: float
    x: Array
    starts: tuple[int, ...]


@dataclass(frozen=True)
class StartsReport:
    """What many starts found.

    Attributes:
        design: the best gait, refined and certified.
        optima: distinct ones at the given samples, the best first.
        outcomes: of every start, in order.
    """

    design: Design
    optima: tuple[Optimum, ...]
    outcomes: tuple[Outcome, ...]

    @property
    def sentences(self) -> tuple[str, ...]:
        """The report for people."""
        walks = sum(outcome.walks for outcome in self.outcomes)
        first = f"{walks} of {len(self.outcomes)} starts led to a walk"
        rest = (
            f"optimum {i} of cost {optimum.cost:.6g}: reached from {len(optimum.starts)}"
            for i, optimum in enumerate(self.optima, start=1)
        )
        return (first, *rest)

    def record(self) -> dict[str, object]:
        """Return the report as JSON-able data."""
        return {
            "starts": len(self.outcomes),
            "walks": sum(outcome.walks for outcome in self.outcomes),
            "optima": [
                {"cost": o.cost, "starts": list(o.starts), "parameters": o.x.tolist()}
                for o in self.optima
            ],
        }


def many_starts(
    robot: Robot,
    task: Task | None = None,
    options: DesignOptions | None = None,
    *,
    count: int = COUNT,
    seed: int = 0,
    sigma: float = SIGMA,
    workers: int = 1,
    start: Array | None = None,
    on_outcome: Callable[[Outcome], None] | None = None,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None = None,
) -> StartsReport:
    """Search from several first guesses, keep the best walk, refine and certify that one.

    The result depends on the seed, not on the number of workers.

    Args:
        robot: the biped.
        task: by default 1 m/s with steps of 0.4 s.
        options: as of `design`; the starts always have exact derivatives.
        count: number of starts; the first is the guess itself.
        seed: of the perturbations.
        sigma: their standard deviation [rad], and [rad/s] for the rates before impact.
        workers: processes; with more than one, a script must start its work under
            `if __name__ == "__main__":`, because each process imports it.
        start: first guess of the parameters, shape (P,); by default `first_guess`.
        on_outcome: called with every outcome, in order; may raise KeyboardInterrupt to end it all.
        on_progress: makes the progress callback of the final design.

    Raises:
        InputError: count or workers below 1, sigma or seed negative.
        NoGaitFoundError: none of the starts led to a walk; with a `diagnosis`.
        UnreachableError: the step asked for is longer than the legs.
        GaitoptError: a worker process died.
    """
    _check(count, seed, sigma, workers)
    task, options = task or Task(), options or DesignOptions()
    try:
        x = first_guess(WalkProblem(robot, task)) if start is None else start
    except UnreachableError:
        found = design(robot, task, options, on_progress=on_progress)
        return StartsReport(found, (), ())
    job = _Job(robot, task, traveller(options.solver), np.asarray(x), sigma, seed)
    outcomes = []
    for outcome in _outcomes(job, count, min(workers, count)):
        outcomes.append(outcome)
        if on_outcome is not None:
            on_outcome(outcome)
    best = min(outcomes, key=_rank)
    again = best.solution.x if best.walks else job.x
    found = design(robot, task, options, start=again, on_progress=on_progress)
    return StartsReport(found, _distinct(outcomes, WalkProblem(robot, task)), tuple(outcomes))


@dataclass(frozen=True)
class _Job:
    """What a worker needs to make any of the starts."""

    robot: Robot
    task: Task
    solver: Solver
    x: Array
    sigma: float
    seed: int

    def run(self, number: int) -> Outcome:
        """Solve from one start."""
        problem = WalkProblem(self.robot, self.task)
        x = self.x
        if number > 0:
            state = np.random.SeedSequence([self.seed, number]).generate_state(1)
            x = perturbed(problem, x, self.sigma, int(state[0]))
        with small_matrices():
            solution = self.solver.solve(problem, Start(x))
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        return Outcome(number, replace(solution, history=()))


def _outcomes(job: _Job, count: int, workers: int) -> Iterator[Outcome]:
    if workers == 1:
        yield from map(job.run, range(count))
        return
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, initializer=_leave_ctrl_c_to_parent)
    try:
        yield from pool.map(job.run, range(count))
    except BrokenProcessPool as error:
        raise GaitoptError(
            "a worker process died; run with 1 worker, or see to it that the script starts its "
            'work under `if __name__ == "__main__":`'
        ) from error
    except BaseException:  # Ctrl-C as well: do not wait for starts that nobody wants
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _leave_ctrl_c_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _rank(outcome: Outcome) -> tuple[bool, float]:
    """Walks before others, then by cost or violation; a nan comes last."""
    value = outcome.solution.cost if outcome.walks else outcome.solution.violation
    return not outcome.walks, value if np.isfinite(value) else np.inf


def _distinct(outcomes: list[Outcome], problem: WalkProblem) -> tuple[Optimum, ...]:
    """Gather outcomes that are optimal and the same to the precision of solvers."""
    optima: list[Optimum] = []
    for outcome in sorted(outcomes, key=_rank):
        solution = outcome.solution
        if not outcome.walks or solution.status is not Status.OPTIMAL:
            continue
        for i, known in enumerate(optima):
            away = np.abs(solution.x - known.x) / problem.variables.scale
            near = abs(solution.cost - known.cost) <= SAME_COST * abs(known.cost)
            if near and away.max() <= SAME_PLACE:
                optima[i] = replace(known, starts=(*known.starts, outcome.number))
                break
        else:
            optima.append(Optimum(solution.cost, solution.x, (outcome.number,)))
    return tuple(optima)


def _check(count: int, seed: int, sigma: float, workers: int) -> None:
    for name, value in (("starts", count), ("workers", workers)):
        if value < 1:
            raise InputError(f"{value} {name} are too few; give at least 1")
    if seed < 0:
        raise InputError(f"seed {seed} is negative; give 0 or more")
    if not (np.isfinite(sigma) and sigma >= 0.0):
        raise InputError(f"sigma is {sigma} rad; it must be a finite number, not negative")
