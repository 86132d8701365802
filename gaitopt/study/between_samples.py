"""Limits kept between the samples too, with as few instants as possible.

A walk takes over the instants at which its neighbour presses on limits, and gets new ones where it
exceeds them. With a peak come its neighbours on the fine grid, because it moves when the walk gives
way; that saves a round in three (measured).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from gaitopt.design.refine import MAX_ROUNDS, with_work
from gaitopt.design.search import is_walk
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start
from gaitopt.solvers import Solver
from gaitopt.study.active import Key, Pressure, exceeded, instants_of, moved, placed, pressures
from gaitopt.study.interruption import solved


@dataclass(frozen=True, eq=False)
class Kept:
    """A walk that keeps its limits.

    Attributes:
        problem: on the grid with the instants that were needed.
        solution: of it, with the work of all rounds.
        active: limits it presses on, and those it still exceeds.
        journey: iterations of the first round, from wherever the walk began.
    """

    problem: WalkProblem
    solution: Solution
    active: tuple[Pressure, ...]
    journey: int


def keep(
    sparse: WalkProblem,
    x: Array,
    active: Iterable[Pressure],
    solver: Solver,
    fine: WalkProblem | None,
    *,
    rounds: int = MAX_ROUNDS,
    below: float = math.inf,
) -> Kept | None:
    """Return a walk near a point that keeps its limits between the samples, None if none is found.

    Args:
        sparse: the walk at its samples.
        x: where to begin, shape (P,).
        active: limits that a walk like it presses on.
        solver: of every round.
        fine: the walk on the certificate's grid; None to leave the limits at the samples.
        rounds: at most; after them what is still exceeded is told in `Kept.active`.
        below: a walk of this cost or more is not wanted; adding instants never lowers the cost.

    Raises:
        EvaluationError: the walk is not defined at a solution on the fine grid.
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    found: Kept | None = None
    grid = uniform_grid(sparse.task.samples, sparse.task.quadrature)
    instants, active = instants_of(sparse, active), tuple(active)
    for _ in range(rounds):
        problem = sparse.with_grid(grid.with_instants(instants))
        solution = solved(solver, problem, Start(x, placed(problem, active)))
        if not is_walk(solution) or solution.cost >= below:
            return None
        x, active = solution.x, pressures(problem, solution.multipliers)
        peaks = () if fine is None else exceeded(fine, x)
        active = moved(active, peaks)
        if found is None:
            found = Kept(problem, solution, active, solution.iterations)
        else:
            found = Kept(problem, with_work(solution, found.solution), active, found.journey)
        if not peaks:
            break
        instants = np.union1d(instants, _around(peaks, fine))
    return found


def pruned(sparse: WalkProblem, kept: Kept) -> tuple[WalkProblem, Solution]:
    """Return the walk on the grid without added instants at which nothing presses.

    Limits with nearly the same gradients cost a second opinion more than all the rest.
    """
    active = pressures(kept.problem, kept.solution.multipliers)
    grid = uniform_grid(sparse.task.samples, sparse.task.quadrature)
    lean = sparse.with_grid(grid.with_instants(instants_of(sparse, active)))
    return lean, replace(kept.solution, multipliers=placed(lean, active))


def _around(peaks: Iterable[tuple[Key, float]], fine: WalkProblem | None) -> Array:
    spacing = 0.0 if fine is None else 1.0 / (fine.grid.count - 1)
    return np.clip([s + k * spacing for _, s in peaks for k in (-1, 0, 1)], 0.0, 1.0)
