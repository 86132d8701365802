"""From a first guess to a walk on the task's samples, or to the reason why there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gaitopt.design.diagnose import diagnose
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.design.refine import with_work
from gaitopt.errors import EvaluationError, NoGaitFoundError, UnreachableError
from gaitopt.gait.guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.nlp import NLP, Array, ProgressCallback, Solution, Start, Status
from gaitopt.solvers import CertifiedSQP, FiniteDifferenceNLP, Solver
from gaitopt.solvers.recorder import FEASIBLE

RELAXED_LIFTOFF = -0.02
"""Least speed of the rear foot's corners after the impact [m/s] in a relaxed first stage.

A gentle landing puts the four lift-off rows, the impulse and its friction cone at one vertex, where
their gradients depend on each other; this much slack takes the walk away from it.
"""


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
        solver, nlp = traveller(options.solver), _derived(problem, options)
        second = solver.solve(nlp, Start(diagnosis.gait), callback)
        if is_walk(second):
            return second
    raise NoGaitFoundError(_refusal(problem, solution), solution, diagnosis)


def attempt(
    problem: WalkProblem, options: DesignOptions, x: Array, callback: ProgressCallback | None = None
) -> Solution:
    """Solve from a first guess by the approach of the options, walk or not."""
    solver, nlp = traveller(options.solver), _derived(problem, options)
    if not _relaxed(problem.task, options):
        return solver.solve(nlp, Start(x), callback)
    start, spent = _relaxed_walk(problem, options, x, callback)
    if spent.status is Status.INTERRUPTED:
        return replace(spent, cost=np.nan, violation=np.inf)  # of another walk
    return with_work(solver.solve(nlp, start, callback), spent)


def _relaxed(task: Task, options: DesignOptions) -> bool:
    """Whether to begin with a rear foot that may sink at lift-off."""
    wanted = options.approach == "relaxed" or (
        options.approach == "automatic" and task.boundary == "lifted"
    )
    return wanted and task.margins.liftoff_speed > RELAXED_LIFTOFF


def _relaxed_walk(
    problem: WalkProblem, options: DesignOptions, x: Array, callback: ProgressCallback | None
) -> tuple[Start, Solution]:
    """Return where the relaxed walk leads to, and the work it took."""
    margins = replace(problem.task.margins, liftoff_speed=RELAXED_LIFTOFF)
    easier = WalkProblem(problem.robot, replace(problem.task, margins=margins))
    found = traveller(options.solver).solve(_derived(easier, options), Start(x), callback)
    if not is_walk(found):
        return Start(x), found
    return Start(found.x, found.multipliers), found


def traveller(solver: Solver) -> Solver:
    """Return the solver that goes from a first guess to a gait."""
    return solver.travel if isinstance(solver, CertifiedSQP) else solver


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


def _derived(problem: WalkProblem, options: DesignOptions) -> NLP:
    if options.differences == "none":
        return problem
    return FiniteDifferenceNLP(problem, cost_gradient_only=options.differences == "constraints")


def is_walk(solution: Solution) -> bool:
    """Return whether a solution is a walk: feasible, optimal or not."""
    return bool(np.isfinite(solution.cost)) and solution.violation <= FEASIBLE


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
