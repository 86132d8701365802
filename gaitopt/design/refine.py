"""Constraints hold between the samples too: add the instants that do not, and solve again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gaitopt.design.active import exceeded, pressures
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.exchange import exchange, pruned
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, ProgressCallback, Solution, Start, Status, Stop, never, stopping
from gaitopt.solvers.solver import Solver
from gaitopt.tolerances import FEASIBLE

_WORTH_SOLVING = (Status.OPTIMAL, Status.STALLED)
_WORTH_GOING_ON = (*_WORTH_SOLVING, Status.ITERATION_LIMIT)
"""A round that crawled is followed by another, at whose instants it often does not."""


def refine(
    problem: WalkProblem,
    solution: Solution,
    solver: Solver,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None = None,
    stop: Stop = never,
    *,
    fine: WalkProblem | None = None,
) -> tuple[WalkProblem, Solution]:
    """Solve again, warm, with the violated instants of the fine grid, until none is left.

    Args:
        problem, solution: a walk and its solution on the given samples.
        solver: used for every round.
        on_progress: makes the progress callback of a walk.
        stop: where it says True, the walk of the last complete round is kept.
        fine: the walk on the certificate's grid, if it is at hand.

    Returns:
        The walk on its final grid, and the solution with the work of all rounds.
    """
    if solution.status not in _WORTH_SOLVING:
        return problem, solution
    fine = fine or on_fine_grid(problem)
    peaks = exceeded(fine, solution.x)
    if not peaks:
        return problem, solution

    def solve(finer: WalkProblem, start: Start) -> Solution:
        callback = None if on_progress is None else on_progress(finer)
        return solver.solve(finer, start, callback, stopping(stop))

    found, active = (problem, solution), pressures(problem, solution.multipliers)
    for finer, again in exchange(problem, solution.x, active, solve, fine, peaks):
        if again.status not in _WORTH_GOING_ON or again.violation > FEASIBLE:
            return found[0], _kept(found[1], again)
        found = finer, with_work(again, found[1])
    return pruned(problem, *found)


def violated_instants(fine: WalkProblem, x: Array) -> Array:
    """Return the instants s at which to hold rows that exceed their limits, none if none does.

    Of every stretch in which a row exceeds its limit only one is taken.

    Args:
        fine: the walk on the proof's grid.
        x: parameters, shape (P,).
    """
    return np.unique([peak.held for peak in exceeded(fine, x)])


def _kept(solution: Solution, failed: Solution) -> Solution:
    """Return the solution before a round that failed: a gait at its own samples at least."""
    status = Status.INTERRUPTED if failed.status is Status.INTERRUPTED else solution.status
    kept = with_work(solution, failed)
    return replace(kept, status=status, history=solution.history + failed.history)


def with_work(solution: Solution, before: Solution) -> Solution:
    """Return a solution that counts the work of another round as well."""
    return replace(
        solution,
        iterations=solution.iterations + before.iterations,
        evaluations=solution.evaluations + before.evaluations,
        hessians=solution.hessians + before.hessians,
        seconds=solution.seconds + before.seconds,
        history=before.history + solution.history,
    )
