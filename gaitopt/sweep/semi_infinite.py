"""Limits at every instant: add the violated instants to the grid, solve again, certify."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import (
    ActiveRow,
    active_rows,
    instants_of,
    placed,
    violated_rows,
)
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import Design, design, finished
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import is_walk
from gaitopt.design.refinement import (
    MAX_ROUNDS,
    exchange,
    is_strict,
    on_either_side,
    pruned,
    quadratic,
    with_work,
)
from gaitopt.errors import EvaluationError, NoGaitFoundError, UnreachableError
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start
from gaitopt.solvers import Solver
from gaitopt.sweep.grid import Scenario
from gaitopt.sweep.warm_start import WarmStart

MAX_ITERATIONS = 100  # a neighbour's walk needs a tenth of them


@dataclass(frozen=True, eq=False)
class FeasibleWalk:
    """A walk that keeps its limits.

    Attributes:
        problem: on the grid with the instants that were needed.
        solution: of it, with the work of all rounds.
        first_iterations: of the first round, from wherever the walk began.
    """

    problem: WalkProblem
    solution: Solution
    first_iterations: int

    @property
    def active(self) -> tuple[ActiveRow, ...]:
        """The limits at which it is."""
        return active_rows(self.problem, self.solution.multipliers)


def solve_between_samples(
    sparse: WalkProblem,
    x: Array,
    active: Iterable[ActiveRow],
    solver: Solver,
    fine: WalkProblem | None,
    *,
    cost_limit: float = math.inf,
) -> FeasibleWalk | None:
    """Return a walk near a point that keeps its limits between the samples, None if none is found.

    Args:
        sparse: the walk at its samples.
        x: where to begin, shape (P,).
        active: limits at which a walk like it is.
        solver: of every round.
        fine: the walk on the certificate's grid; None to leave the limits at the samples.
        cost_limit: of a walk that is wanted; adding instants never lowers the cost.

    Raises:
        EvaluationError: the walk is not defined at x or a solution on the fine grid.
    """
    found: FeasibleWalk | None = None

    def solve(problem: WalkProblem, start: Start) -> Solution:
        return solver.solve(problem, start)

    newton = quadratic(solver)
    peaks = () if fine is None or newton is not None else violated_rows(fine, x)
    rounds = 0
    for problem, solution, _ in exchange(sparse, x, active, solve, fine, peaks, newton):
        rounds += 1
        if not is_walk(solution) or solution.cost >= cost_limit:
            return None
        if found is None:
            found = FeasibleWalk(problem, solution, solution.iterations)
        else:
            whole = with_work(solution, found.solution)
            found = FeasibleWalk(problem, whole, found.first_iterations)
    if rounds == MAX_ROUNDS and found is not None and fine is not None:
        return None if violated_rows(fine, found.solution.x) else found
    return found


def with_all_work(way: Sequence[FeasibleWalk]) -> FeasibleWalk:
    """Return the last of walks, at least one, each from the one before; all the work counts."""
    last = way[-1]
    for earlier in reversed(way[:-1]):
        last = FeasibleWalk(
            last.problem,
            with_work(last.solution, earlier.solution),
            last.first_iterations + earlier.first_iterations,
        )
    return last


def finish(scenario: Scenario, walk: WarmStart, options: DesignOptions) -> Design | None:
    """Return the finished gait of a walk; the better of two ways if the first is not certified.

    Args:
        scenario: robot and task.
        walk: of them.
        options: as of `design`.

    Returns:
        The design, or None where refinement left no walk.
    """
    first = _refined(scenario, walk, options)
    if first is not None and (first.certificate.certified or not options.refine):
        return first
    second = _designed(scenario, walk, options)
    walks = (one for one in (first, second) if one is not None)
    return min(walks, key=lambda one: one.rank, default=None)


def _refined(scenario: Scenario, walk: WarmStart, options: DesignOptions) -> Design | None:
    sparse = WalkProblem(scenario.robot.build(), scenario.task)
    try:
        fine = on_fine_grid(sparse)
        whole = _as_it_is(sparse, walk, options, fine)
        if whole is not None and whole.certificate.certified:
            return whole
        between = fine if options.refine else None
        kept = solve_between_samples(sparse, walk.x, walk.active, warm_solver(options), between)
        if kept is None:
            return None
        problem, solution = pruned(sparse, kept.problem, kept.solution)
        solution = options.solver.confirm(problem, solution)
        return finished(problem, solution, options.refine, fine)
    except EvaluationError:
        return None


def _as_it_is(
    sparse: WalkProblem, walk: WarmStart, options: DesignOptions, fine: WalkProblem
) -> Design | None:
    """Return a walk finished at the instants at which it presses, None if it is no walk there.

    Where it is no strict minimum there, at instants on either side of them: else Newton's method
    would not confirm it, and the interior point method after it in half a second neither.
    """
    solver = path_solver(options)

    def solved(active: Sequence[ActiveRow]) -> tuple[WalkProblem, Solution]:
        problem = sparse.with_grid(sparse.grid.with_instants(instants_of(sparse, active)))
        return problem, solver.solve(problem, Start(walk.x, placed(problem, active)))

    problem, solution = solved(walk.active)
    moving = options.refine and quadratic(solver) is not None
    if is_walk(solution) and moving and not is_strict(problem, solution):
        problem, solution = solved(on_either_side(fine, walk.x, walk.active))
    if not is_walk(solution):
        return None
    return finished(problem, options.solver.confirm(problem, solution), options.refine, fine)


def _designed(scenario: Scenario, walk: WarmStart, options: DesignOptions) -> Design | None:
    """The usual way, from the walk."""
    direct = replace(options, diagnose=False, approach="direct")
    try:
        return design(scenario.robot.build(), scenario.task, direct, start=walk.x)
    except (NoGaitFoundError, UnreachableError):
        return None


def warm_solver(options: DesignOptions) -> Solver:
    """Return the solver for starts that are nearly solutions."""
    return options.solver.first_stage.near_solution()


def path_solver(options: DesignOptions) -> Solver:
    """Return the solver for walks from their neighbours: it stops early at failure."""
    return warm_solver(options).limited(MAX_ITERATIONS)
