"""From a first guess to a walk on the task's samples, or to the reason why there is none."""

from __future__ import annotations

import numpy as np

from gaitopt.design.attempt import attempt, derived, is_walk, traveller
from gaitopt.design.diagnose import diagnose
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.errors import EvaluationError, NoGaitFoundError, UnreachableError
from gaitopt.gait.guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, ProgressCallback, Solution, Start, Status


def guess(problem: WalkProblem, options: DesignOptions) -> Array:
    """Return the first guess, or the walk that a diagnosis finds where there is none."""
    try:
        return first_guess(problem)
    except UnreachableError as error:
        diagnosis = _diagnosis(problem, None, options)
        if diagnosis is None or diagnosis.gait is None:
            raise UnreachableError(str(error), diagnosis) from error
        return diagnosis.gait


def search(
    problem: WalkProblem, options: DesignOptions, x: Array, callback: ProgressCallback | None
) -> Solution:
    """Solve, once more from the walk that a diagnosis finds; raise if there is none."""
    solution = attempt(problem, options, x, callback)
    if is_walk(solution):
        return solution
    diagnosis = _diagnosis(problem, solution, options)
    if diagnosis is not None and diagnosis.gait is not None:
        solver, nlp = traveller(options.solver), derived(problem, options)
        second = solver.solve(nlp, Start(diagnosis.gait), callback)
        if is_walk(second):
            return second
    raise NoGaitFoundError(_refusal(problem, solution), solution, diagnosis)


def _diagnosis(
    problem: WalkProblem, solution: Solution | None, options: DesignOptions
) -> Diagnosis | None:
    """Return a diagnosis, unless it is not wanted, cannot be made or is given up by Ctrl-C."""
    interrupted = solution is not None and solution.status is Status.INTERRUPTED
    if interrupted or not options.diagnose:
        return None
    try:
        return diagnose(problem, solution, refined=options.refine)
    except (UnreachableError, KeyboardInterrupt):
        return None


def _refusal(problem: WalkProblem, solution: Solution) -> str:
    """Say what is wrong with a solution that is not a walk."""
    reason = f"no feasible gait was found ({solution.status.value})"
    try:
        rows = problem.values(solution.x).rows
    except EvaluationError as error:
        return f"{reason}; {error}"
    worst = np.maximum(problem.rows.lower - rows, rows - problem.rows.upper)
    row = int(np.argmax(worst))
    at = problem.address(row)
    scale = at.family.scale[at.entry]
    limit = (
        problem.rows.lower[row] if rows[row] < problem.rows.lower[row] else problem.rows.upper[row]
    )
    return (
        f"{reason} at {problem.task.speed:g} m/s with steps of {problem.task.duration:g} s; the "
        f"least violation leaves {problem.describe(row)}: {rows[row] * scale:.4g} "
        f"{at.family.unit}, allowed {limit * scale:.4g}"
    )
