"""A walk near another one that keeps its limits between the samples, if there is one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from gaitopt.design.active import Pressure, exceeded, pressures
from gaitopt.design.attempt import is_walk
from gaitopt.design.exchange import MAX_ROUNDS, exchange
from gaitopt.design.refine import with_work
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start
from gaitopt.solvers import Solver
from gaitopt.study.interruption import solved


@dataclass(frozen=True, eq=False)
class Kept:
    """A walk that keeps its limits.

    Attributes:
        problem: on the grid with the instants that were needed.
        solution: of it, with the work of all rounds.
        journey: iterations of the first round, from wherever the walk began.
    """

    problem: WalkProblem
    solution: Solution
    journey: int

    @property
    def active(self) -> tuple[Pressure, ...]:
        """The limits it presses on."""
        return pressures(self.problem, self.solution.multipliers)


def keep(
    sparse: WalkProblem,
    x: Array,
    active: Iterable[Pressure],
    solver: Solver,
    fine: WalkProblem | None,
    *,
    enough: float = 0.0,
    below: float = math.inf,
) -> Kept | None:
    """Return a walk near a point that keeps its limits between the samples, None if none is found.

    Args:
        sparse: the walk at its samples.
        x: where to begin, shape (P,).
        active: limits that a walk like it presses on.
        solver: of every round.
        fine: the walk on the certificate's grid; None to leave the limits at the samples.
        enough: scaled violation between the samples with which it may end.
        below: a walk of this cost or more is not wanted; adding instants never lowers the cost.

    Raises:
        EvaluationError: the walk is not defined at x or a solution on the fine grid.
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    found: Kept | None = None

    def solve(problem: WalkProblem, start: Start) -> Solution:
        return solved(solver, problem, start)

    peaks = () if fine is None else exceeded(fine, x)
    rounds = 0
    for problem, solution in exchange(sparse, x, active, solve, fine, peaks, enough):
        rounds += 1
        if not is_walk(solution) or solution.cost >= below:
            return None
        if found is None:
            found = Kept(problem, solution, solution.iterations)
        else:
            found = Kept(problem, with_work(solution, found.solution), found.journey)
    if rounds == MAX_ROUNDS and found is not None and fine is not None:
        unkept = any(peak.excess > enough for peak in exceeded(fine, found.solution.x))
        return None if unkept else found
    return found


def joined(way: Sequence[Kept]) -> Kept:
    """Return the last of walks, at least one, each from the one before; all the work counts."""
    last = way[-1]
    for earlier in reversed(way[:-1]):
        last = Kept(
            last.problem,
            with_work(last.solution, earlier.solution),
            last.journey + earlier.journey,
        )
    return last
