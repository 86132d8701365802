"""One walk, several solvers: what each found, judged alike, and how it got there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from gaitopt.design.design import checked_start
from gaitopt.errors import EvaluationError, InputError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import (
    Array,
    Progress,
    ProgressCallback,
    Solution,
    Start,
    Status,
    Stop,
    kkt_residual,
    never,
    stopping,
)
from gaitopt.solvers import Solver, solver_by_name
from gaitopt.solvers.multipliers import least_squares_multipliers

COMPARED = ("sqp", "slsqp", "ipopt")


@dataclass(frozen=True)
class SolverRun:
    """What one solver made of a walk at its samples.

    Attributes:
        solver, status: its name, and how it stopped.
        cost: at its answer [unit of the task's cost], nan if it could not begin.
        optimality, violation: of its answer from the point alone, with least-squares multipliers,
            so that no solver's own word counts.
        iterations, evaluations, hessians, seconds: of its run.
        x: its answer, shape (P,).
        history: of all iterations; `Progress.optimality` has one definition for all solvers.
    """

    solver: str
    status: Status
    cost: float
    optimality: float
    violation: float
    iterations: int
    evaluations: int
    hessians: int
    seconds: float
    x: Array
    history: tuple[Progress, ...]

    def record(self) -> dict[str, object]:
        """Return the run as JSON-able data; None for numbers that are not finite."""
        told = {name: value for name, value in asdict(self).items() if name not in ("x", "history")}
        history = [asdict(one) for one in self.history]
        for numbers in (told, *history):
            for name, value in numbers.items():
                if isinstance(value, float) and not np.isfinite(value):
                    numbers[name] = None
        return {**told, "status": self.status.name.lower(), "history": history}


def compare_solvers(
    robot: Robot,
    task: Task | None = None,
    solvers: Sequence[str | Solver] = COMPARED,
    *,
    start: Array | Gait | None = None,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None = None,
    stop: Stop = never,
) -> tuple[SolverRun, ...]:
    """Solve one walk at its samples by several solvers from the same start.

    Args:
        robot: the biped.
        task: by default the preset `standard`.
        solvers: names of `gaitopt.solvers.SOLVERS`, or solvers with options.
        start: parameters to begin with, shape (P,), or those of a gait; by default `first_guess`.
        on_progress: makes the progress callback of a walk.
        stop: asked at every iteration; where it says True, the run ends and no other begins.

    Raises:
        InputError: no solver is named, one is not known, or the start has another shape than the
            parameters.
        MissingExtraError: a solver's package is not installed.
        UnreachableError: the step asked for is longer than the legs.
    """
    chosen = [solver_by_name(one) if isinstance(one, str) else one for one in solvers]
    if not chosen:
        raise InputError("no solver is named; give one or more, as sqp,slsqp,ipopt")
    problem = WalkProblem(robot, task or preset_task(robot=robot))
    x = first_guess(problem) if start is None else checked_start(problem, start)
    runs = []
    for solver in chosen:
        callback = None if on_progress is None else on_progress(problem)
        runs.append(_judged(problem, solver.solve(problem, Start(x), callback, stopping(stop))))
        if stop():
            break
    return tuple(runs)


def _judged(problem: WalkProblem, solution: Solution) -> SolverRun:
    try:
        point = problem.point(solution.x)
    except EvaluationError:
        optimality = violation = np.nan
    else:
        residual = kkt_residual(problem, point, *least_squares_multipliers(problem, point))
        optimality, violation = residual.optimality, residual.feasibility
    return SolverRun(
        solver=solution.solver,
        status=solution.status,
        cost=solution.cost,
        optimality=optimality,
        violation=violation,
        iterations=solution.iterations,
        evaluations=solution.evaluations,
        hessians=solution.hessians,
        seconds=solution.seconds,
        x=solution.x,
        history=solution.history,
    )
