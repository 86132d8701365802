"""Semi-infinite refinement: add violated instants to the grid and solve again, until none is left.

An exchange method (Hettich & Kortanek, 1993, Semi-infinite programming, SIAM Review 35(3), section
7) with as few instants as possible. A limit that was kept at one instant is then violated a little
beside it: its multiplier moves there too. Measured on sixteen walks of eight robots, that takes a
quarter of the iterations off the median one, and one that ran to the limit of iterations without
it is certified; one takes four times more.

A limit that is held at two instants close together is exceeded half way between them, a quarter as
much round after round; held where the multipliers of the two say that it presses, and a little
beside it, it is exceeded a fiftieth as much (`sharpened`): four rounds instead of eight for the
biped at 1 m/s. Where that does not help, as for a pressure that stays at an edge for a while, the
next round holds limits at their peaks.

With the SQP's exact Hessian the first round begins with Newton's method for instants that move
along (`gaitopt.design.reduction`): mostly there is no other, and the SQP takes no step. Where only
that its instants move makes the walk a minimum, it is held on either side of each of them; exchange
alone, which comes to the same, takes three to seven times longer for G1 with arms and waist.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from gaitopt.design.active_set import (
    ActiveRow,
    ViolatedRow,
    active_rows,
    instants_of,
    moved,
    placed,
    sharpened,
    violated_rows,
)
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.reduction import on_either_side, resting_walk
from gaitopt.gait.problem import MakeProgress, WalkProblem
from gaitopt.nlp import Array, Solution, Start, Status, Stop, never, stopping
from gaitopt.solvers.newton import is_strict_minimum
from gaitopt.solvers.solver import Solver, make_iterate
from gaitopt.solvers.sqp import SQP
from gaitopt.tolerances import FEASIBLE

MAX_ROUNDS = 20
FASTER = 0.5
"""By which the worst violation has to fall in a round for the next to hold limits where they press.
A limit that presses over a while needs instants all along it, and is held at its peaks."""
CLOSELY = 1e-8
"""KKT residual to which a walk is solved that is held on either side of its instants: where it was
the conditions hold to `OPTIMALITY`, but it is half of `REFINED` away from limits that press."""
FOLLOWED = 3  # first rounds that may begin with Newton's method; then nothing held is let go
_WORTH_SOLVING = (Status.OPTIMAL, Status.STALLED)
_WORTH_GOING_ON = (*_WORTH_SOLVING, Status.ITERATION_LIMIT)
"""A round that crawled is followed by another, at whose instants it often does not."""
Solve = Callable[[WalkProblem, Start], Solution]


def refine(
    problem: WalkProblem,
    solution: Solution,
    solver: Solver,
    on_progress: MakeProgress | None = None,
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
        The walk on its final grid, and the solution with the work of the rounds that led to it.
    """
    if solution.status not in _WORTH_SOLVING:
        return problem, solution
    fine = fine or on_fine_grid(problem)
    peaks = violated_rows(fine, solution.x)
    if not peaks:
        return problem, solution

    def solve_with(method: Solver, finer: WalkProblem, start: Start) -> Solution:
        callback = None if on_progress is None else on_progress(finer)
        return method.solve(finer, start, callback, stopping(stop))

    solve = partial(solve_with, solver)
    active, newton = active_rows(problem, solution.multipliers), quadratic(solver)
    resting: tuple[WalkProblem, Solution] | None = None
    for way in (newton, None):
        found, moving = (problem, solution), False
        for finer, again, near in exchange(problem, solution.x, active, solve, fine, peaks, way):
            moving = moving or near
            if again.status not in _WORTH_GOING_ON or again.violation > FEASIBLE:
                found = found[0], _kept(found[1], again)
                break
            found = finer, with_work(again, found[1])
        else:
            found = pruned(problem, *found)
        if not moving or is_strict(*found):
            break  # where no instants moved, exchange alone would do the same again
        beside = _held_beside(problem, fine, *found, solver, solve_with)
        if beside is not None:
            return beside
        resting = resting or found
    crawled = found[1].status is not Status.OPTIMAL  # among rows that are nearly alike
    if crawled and resting is not None and _proven(fine, resting[1]):
        return resting
    return found


def _held_beside(
    sparse: WalkProblem,
    fine: WalkProblem,
    problem: WalkProblem,
    solution: Solution,
    solver: Solver,
    solve_with: Callable[[Solver, WalkProblem, Start], Solution],
) -> tuple[WalkProblem, Solution] | None:
    """Return a walk that its moving instants make a minimum held on either side of each of them.

    None where that is no strict minimum either, or exceeds a limit.

    Args:
        sparse: the walk at its samples.
        fine: the walk on the certificate's grid.
        problem, solution: the walk at the instants that Newton's method has found, solved.
        solver: of the rounds.
        solve_with: solves by a solver.
    """
    newton = quadratic(solver)
    if newton is None or solution.status is not Status.OPTIMAL:
        return None
    rows = on_either_side(fine, solution.x, active_rows(problem, solution.multipliers))
    finer = sparse.with_grid(sparse.grid.with_instants(instants_of(sparse, rows)))
    closely = replace(newton, tolerance=min(newton.tolerance, CLOSELY))
    again = solve_with(closely, finer, Start(solution.x, placed(finer, rows)))
    if not is_strict(finer, again) or violated_rows(fine, again.x):
        return None
    return finer, with_work(again, solution)


def _proven(fine: WalkProblem, solution: Solution) -> bool:
    """Return whether a walk is an optimum that keeps its limits between the samples."""
    return solution.status is Status.OPTIMAL and not violated_rows(fine, solution.x)


def is_strict(problem: WalkProblem, solution: Solution) -> bool:
    """Return whether a walk is a strict minimum with its instants fixed, and so can be confirmed.

    An instant that moves along bends its row, and may be all that makes the walk a minimum.
    Exchange then finds two instants on either side of that one, which do so too.
    """
    if solution.status is not Status.OPTIMAL:
        return solution.status is Status.INTERRUPTED
    point, scale = problem.point(solution.x), problem.variables.scale
    iterate = make_iterate(problem, point, solution.multipliers, solution.bound_multipliers)
    hessian = problem.hessian(solution.x, solution.multipliers, problem.cost_scale)
    return is_strict_minimum(problem, iterate, hessian * np.outer(scale, scale))


def quadratic(solver: Solver) -> SQP | None:
    """Return a solver of whose kind rounds may begin with Newton's method, None if it is none."""
    return solver if isinstance(solver, SQP) and solver.hessian == "exact" else None


def exchange(
    sparse: WalkProblem,
    x: Array,
    active: Iterable[ActiveRow],
    solve: Solve,
    fine: WalkProblem | None,
    peaks: Iterable[ViolatedRow] = (),
    newton: SQP | None = None,
) -> Iterator[tuple[WalkProblem, Solution, bool]]:
    """Yield walk, solution and whether Newton's method began it, until a walk keeps the limits.

    After `MAX_ROUNDS` the last ones may still exceed them. A round whose solution is of no use must
    be the last that is asked for.

    Args:
        sparse: the walk at its samples.
        x: where to begin, shape (P,).
        active: limits that a walk like it presses on.
        solve: solves a round.
        fine: the walk on the certificate's grid; None to leave the limits at the samples.
        peaks: where x exceeds limits.
        newton: of whose kind rounds may begin with Newton's method, its instants moving along.

    Raises:
        EvaluationError: a solution's walk is not defined on the fine grid.
    """
    instants, active, peaks = instants_of(sparse, active), tuple(active), tuple(peaks)
    excess = _worst(peaks)
    for number in range(MAX_ROUNDS):
        active, near = moved(active, peaks), None
        if newton is not None and fine is not None and number < FOLLOWED:
            near = resting_walk(sparse, fine, x, active, newton)
        beside = [one for peak in peaks for one in peak.beside]  # to stay if they press
        if near is None:
            instants = np.union1d(instants, instants_of(sparse, active))
        else:
            x, active, beside = near.x, near.active, []
            instants, newton = instants_of(sparse, active), newton if near.keeps else None
        problem = sparse.with_grid(sparse.grid.with_instants(np.union1d(instants, beside)))
        solution = solve(problem, Start(x, placed(problem, active)))
        if near is None:
            yield problem, solution, False
        else:
            yield problem, _with_steps(solution, near.steps), True
            if near.keeps and np.array_equal(solution.x, near.x):
                return  # nothing has moved since the limits were looked at
        x, active = solution.x, active_rows(problem, solution.multipliers)
        peaks = () if fine is None else violated_rows(fine, x)
        if not peaks:
            return
        before, excess = excess, _worst(peaks)
        if excess < FASTER * before:
            peaks = sharpened(active, peaks)


def _worst(peaks: Iterable[ViolatedRow]) -> float:
    return max((peak.excess for peak in peaks), default=np.inf)


def _with_steps(solution: Solution, steps: int) -> Solution:
    """Return a solution that counts the steps that led to its start."""
    return replace(
        solution,
        iterations=solution.iterations + steps,
        evaluations=solution.evaluations + steps,
        hessians=solution.hessians + steps,
    )


def pruned(
    sparse: WalkProblem, problem: WalkProblem, solution: Solution
) -> tuple[WalkProblem, Solution]:
    """Return the walk on the grid without added instants at which nothing presses.

    Limits with nearly the same gradients cost a second opinion more than all the rest.

    Args:
        sparse: the walk at its samples.
        problem: the walk with instants added.
        solution: of it.
    """
    active = active_rows(problem, solution.multipliers)
    lean = sparse.with_grid(sparse.grid.with_instants(instants_of(sparse, active)))
    return lean, replace(solution, multipliers=placed(lean, active))


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
