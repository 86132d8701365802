"""One walk, several solvers: what each found, judged alike, and how it got there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields, replace

import numpy as np

from gaitopt.design.design import checked_start
from gaitopt.errors import EvaluationError, InputError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import MakeProgress, WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import (
    Array,
    Solution,
    Start,
    Stop,
    kkt_residual,
    never,
    stopping,
)
from gaitopt.solvers import Solver, solver_by_name
from gaitopt.solvers.multipliers import least_squares_multipliers

COMPARED = ("sqp", "slsqp", "ipopt")


def compare_solvers(
    robot: Robot,
    task: Task | None = None,
    solvers: Sequence[str | Solver] = COMPARED,
    *,
    start: Array | Gait | None = None,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> tuple[Solution, ...]:
    """Solve one walk at its samples by several solvers from the same start.

    Returns:
        Their answers, judged alike: multipliers are those of least squares, and optimality and
        violation those of the point with them, so that no solver's own word counts; cost,
        optimality and violation are nan where a solver could not begin.

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


def _judged(problem: WalkProblem, solution: Solution) -> Solution:
    try:
        point = problem.point(solution.x)
    except EvaluationError:
        return replace(solution, optimality=np.nan, violation=np.nan)
    rows, bounds = least_squares_multipliers(problem, point)
    residual = kkt_residual(problem, point, rows, bounds)
    return replace(
        solution, multipliers=rows, bound_multipliers=bounds,
        optimality=residual.optimality, violation=residual.feasibility,
    )  # fmt: skip


def run_record(run: Solution) -> dict[str, object]:
    """Return a solver's run as JSON-able data; None for numbers that are not finite."""
    apart = ("x", "multipliers", "bound_multipliers", "hessian", "history")
    told = {one.name: getattr(run, one.name) for one in fields(run) if one.name not in apart}
    history = [asdict(one) for one in run.history]
    for numbers in (told, *history):
        for name, value in numbers.items():
            if isinstance(value, float) and not np.isfinite(value):
                numbers[name] = None
    return {**told, "status": run.status.name.lower(), "history": history}
