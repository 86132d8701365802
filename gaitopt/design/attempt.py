"""From a first guess to a walk on the task's samples, by the approach of the options."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gaitopt.design.options import DesignOptions
from gaitopt.design.refine import with_work
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.nlp import NLP, Array, ProgressCallback, Solution, Start, Status, Stop, never, stopping
from gaitopt.solvers import FiniteDifferenceNLP
from gaitopt.tolerances import FEASIBLE

RELAXED_LIFTOFF = -0.02
"""Least speed of the rear foot's corners after the impact [m/s] in a relaxed first stage.

A gentle landing puts the four lift-off rows, the impulse and its friction cone at one vertex, where
their gradients depend on each other; this much slack takes the walk away from it.
"""


def attempt(
    problem: WalkProblem,
    options: DesignOptions,
    x: Array,
    callback: ProgressCallback | None = None,
    stop: Stop = never,
) -> Solution:
    """Solve from a first guess by the approach of the options, walk or not."""
    solver, nlp = options.solver.first_stage, derived(problem, options)
    if not begins_relaxed(problem.task, options):
        return solver.solve(nlp, Start(x), callback, stopping(stop))
    start, spent = _relaxed_walk(problem, options, x, callback, stop)
    if spent.status is Status.INTERRUPTED:
        return replace(spent, cost=np.nan, violation=np.inf)  # of another walk
    return with_work(solver.solve(nlp, start, callback, stopping(stop)), spent)


def begins_relaxed(task: Task, options: DesignOptions) -> bool:
    """Return whether to begin with a rear foot that may sink at lift-off."""
    wanted = options.approach == "relaxed" or (
        options.approach == "automatic" and task.boundary == "lifted"
    )
    return wanted and task.margins.liftoff_speed > RELAXED_LIFTOFF


def _relaxed_walk(
    problem: WalkProblem,
    options: DesignOptions,
    x: Array,
    callback: ProgressCallback | None,
    stop: Stop,
) -> tuple[Start, Solution]:
    """Return where the relaxed walk leads to, and the work it took."""
    margins = replace(problem.task.margins, liftoff_speed=RELAXED_LIFTOFF)
    easier = WalkProblem(problem.robot, replace(problem.task, margins=margins))
    found = options.solver.first_stage.solve(
        derived(easier, options), Start(x), callback, stopping(stop)
    )
    if not is_walk(found):
        return Start(x), found
    return Start(found.x, found.multipliers), found


def derived(problem: WalkProblem, options: DesignOptions) -> NLP:
    """Return the walk with derivatives as the options want them."""
    if options.differences == "none":
        return problem
    return FiniteDifferenceNLP(problem, cost_gradient_only=options.differences == "constraints")


def is_walk(solution: Solution) -> bool:
    """Return whether a solution is a walk: feasible, optimal or not."""
    return bool(np.isfinite(solution.cost)) and solution.violation <= FEASIBLE
