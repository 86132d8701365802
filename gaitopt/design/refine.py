"""Constraints hold between the samples too: add the instants that do not, and solve again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gaitopt.design.certificate import FINE_TOLERANCE, on_fine_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, ProgressCallback, Solution, Start, Status, violations
from gaitopt.solvers.solver import Solver

MAX_ROUNDS = 12
_WORTH_SOLVING = (Status.OPTIMAL, Status.STALLED)


def refine(
    problem: WalkProblem,
    solution: Solution,
    solver: Solver,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None = None,
    *,
    fine: WalkProblem | None = None,
) -> tuple[WalkProblem, Solution]:
    """Solve again, warm, with the violated instants of the fine grid, until none is left.

    Args:
        problem, solution: a walk and its solution on the given samples.
        solver: used for every round.
        on_progress: makes the progress callback of a walk.
        fine: the walk on the certificate's grid, if it is at hand.

    Returns:
        The walk on its final grid, and the solution with the work of all rounds.
    """
    fine = fine or on_fine_grid(problem)
    for _ in range(MAX_ROUNDS):
        if solution.status not in _WORTH_SOLVING:
            break
        extra = violated_instants(fine, solution.x)
        if extra.size == 0:
            break
        finer = problem.with_grid(problem.grid.with_instants(extra))
        start = Start(solution.x, carry_multipliers(problem, finer, solution.multipliers))
        again = solver.solve(finer, start, None if on_progress is None else on_progress(finer))
        if again.status not in _WORTH_SOLVING:
            return problem, _kept(solution, again)
        problem, solution = finer, with_work(again, solution)
    return problem, solution


def violated_instants(fine: WalkProblem, x: Array) -> Array:
    """Return the instants s where a row of a walk on a fine grid is at its worst beyond its limit.

    Of every stretch of violated instants of one row only the worst is taken.
    """
    rows = fine.values(x).rows
    excess = violations(fine.rows.lower, fine.rows.upper, rows)
    found: list[float] = []
    for family in fine.families:
        if family.times is None:
            continue
        by_row = excess[fine.family_rows(family.name)].reshape(family.lower.shape).T
        for row in by_row:
            found.extend(family.times[_peaks(row)])
    return np.unique(found)


def carry_multipliers(old: WalkProblem, new: WalkProblem, multipliers: Array) -> Array:
    """Return multipliers for a walk with instants added; the added rows get zero."""
    carried = np.zeros(new.rows.lower.size)
    for family in old.families:
        rows = new.family_rows(family.name)
        carried[rows][: family.size] = multipliers[old.family_rows(family.name)]
    return carried


def _peaks(excess: Array) -> NDArray[np.int_]:
    """Indices of the local maxima above the tolerance."""
    padded = np.concatenate([[-1.0], excess, [-1.0]])
    middle = padded[1:-1]
    peak = (middle > 0.5 * FINE_TOLERANCE) & (middle >= padded[:-2]) & (middle > padded[2:])
    return np.flatnonzero(peak)


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
