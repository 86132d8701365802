"""Ctrl-C, which solvers answer by their best iterate, ends a study."""

from __future__ import annotations

from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution, Start, Status
from gaitopt.solvers import Solver


def solved(solver: Solver, problem: WalkProblem, start: Start) -> Solution:
    """Solve a walk.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed meanwhile.
    """
    solution = solver.solve(problem, start)
    stop_if_interrupted(solution)
    return solution


def stop_if_interrupted(solution: object) -> None:
    """Go on with Ctrl-C, which solvers answer by their best iterate.

    Raises:
        KeyboardInterrupt: the solution was interrupted.
    """
    if isinstance(solution, Solution) and solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
