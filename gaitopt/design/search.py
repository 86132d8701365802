"""From a first guess to a walk on the task's samples, or to the reason why there is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gaitopt.design.attempt import attempt, is_walk
from gaitopt.design.diagnose import diagnose
from gaitopt.design.diagnosis import Diagnosis, Suggestion
from gaitopt.design.options import DesignOptions
from gaitopt.design.suggestions import followed, following
from gaitopt.errors import EvaluationError, NoGaitFoundError, StoppedError, UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, ProgressCallback, Solution, Status, Stop, never


def guess(problem: WalkProblem, options: DesignOptions, stop: Stop = never) -> Array:
    """Return the first guess, or the walk that a diagnosis finds where there is none."""
    try:
        return first_guess(problem)
    except UnreachableError as error:
        diagnosis = _diagnosis(problem, [], options, stop)
        if diagnosis is None or diagnosis.gait is None:
            raise UnreachableError(str(error), diagnosis) from error
        return diagnosis.gait


def search(
    problem: WalkProblem,
    options: DesignOptions,
    x: Array,
    callback: ProgressCallback | None,
    stop: Stop = never,
) -> Solution:
    """Solve, once more from the walk that a diagnosis finds; raise if there is none."""
    solution = attempt(problem, options, x, callback, stop)
    if is_walk(solution):
        return solution
    return second_thoughts(problem, [solution], options, callback, stop)


def second_thoughts(
    problem: WalkProblem,
    tried: Sequence[Solution],
    options: DesignOptions,
    callback: ProgressCallback | None,
    stop: Stop = never,
) -> Solution:
    """Return the walk that a diagnosis leads to where solvers found none; raise if there is none.

    Args:
        problem: the walk.
        tried: what solvers made of it, none of them a walk.
        options: how it was searched for.
        callback: told of iterations.
        stop: ends the diagnosis.

    Raises:
        NoGaitFoundError: with the diagnosis.
        StoppedError: a solver or the diagnosis was stopped.
    """
    solution = min(tried, key=lambda s: s.violation if np.isfinite(s.violation) else np.inf)
    if any(one.status is Status.INTERRUPTED for one in tried):
        raise StoppedError(solution)
    diagnosis = _diagnosis(problem, tried, options, stop)
    if diagnosis is not None and diagnosis.gait is not None:
        second = attempt(problem, following(options), diagnosis.gait, callback, stop)
        if is_walk(second):
            return second
        if stop():
            raise StoppedError(second)
        diagnosis = _with_another_solver(problem, diagnosis, options, stop)
    raise NoGaitFoundError(_refusal(problem, solution), solution, diagnosis)


def _diagnosis(
    problem: WalkProblem, tried: Sequence[Solution], options: DesignOptions, stop: Stop
) -> Diagnosis | None:
    """Return a diagnosis, unless it is not wanted or cannot be made."""
    if not options.diagnose:
        return None
    try:
        return diagnose(problem, tried, options, stop)
    except UnreachableError:
        return None


def _with_another_solver(
    problem: WalkProblem, diagnosis: Diagnosis, options: DesignOptions, stop: Stop
) -> Diagnosis:
    """Return the diagnosis of a walk that exists with what finds it, if anything does."""
    usual = following(replace(options, solver=DesignOptions().solver, differences="none"))
    x = diagnosis.gait
    found = None if x is None else followed(problem.robot, problem.task, x, usual, stop)
    if x is None or found is None:
        return diagnosis
    words = "the default solver, started from the walk that the diagnosis found,"
    told = Suggestion("", words, 0.0, 0.0, "", problem.robot, problem.task, usual, x, found)
    return replace(diagnosis, suggestions=(told,))


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
    scale = at.block.scale[at.entry]
    limit = (
        problem.rows.lower[row] if rows[row] < problem.rows.lower[row] else problem.rows.upper[row]
    )
    return (
        f"{reason} at {problem.task.speed:g} m/s with steps of {problem.task.duration:g} s; the "
        f"least violation leaves {problem.describe(row)}: {rows[row] * scale:.4g} "
        f"{at.block.unit}, allowed {limit * scale:.4g}"
    )
