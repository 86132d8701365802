"""Limits at every instant: add the violated instants to the grid, solve again, certify."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from gaitopt.design.active_set import Pressure, exceeded, pressures
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import Design, design, finished
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import is_walk
from gaitopt.design.refinement import MAX_ROUNDS, exchange, pruned, with_work
from gaitopt.errors import EvaluationError, NoGaitFoundError, UnreachableError
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start, Status
from gaitopt.solvers import Solver
from gaitopt.solvers.sqp import SQP
from gaitopt.sweep.scenario import Setting
from gaitopt.sweep.warm_start import Footing


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


RADIUS = 0.5  # first trust region from a neighbour; measured: 0.1 costs a quarter more iterations


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


def warm(options: DesignOptions) -> Solver:
    """Return the travelling solver, with a trust region for starts that are nearly solutions."""
    solver = options.solver.first_stage
    return replace(solver, initial_radius=RADIUS) if isinstance(solver, SQP) else solver


def finish(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    """Return the finished gait of a setting; the better of two ways if the first is not certified.

    Args:
        setting: robot and task.
        footing: a walk of it.
        options: as of `design`.

    Returns:
        The design, or None where refinement left no walk.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    first = _finished(setting, footing, options)
    if first is not None and (first.certificate.certified or not options.refine):
        return first
    second = _designed(setting, footing, options)
    return min((d for d in (first, second) if d is not None), key=rank, default=None)


def rank(found: Design) -> tuple[bool, float]:
    """Order gaits: certified ones first, then by cost."""
    return not found.certificate.certified, found.solution.cost


def _designed(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    """The usual way, from the walk."""
    direct = replace(options, diagnose=False, approach="direct")
    try:
        found = design(setting.robot.build(), setting.task, direct, start=footing.x)
    except (NoGaitFoundError, UnreachableError) as error:
        stop_if_interrupted(getattr(error, "solution", None))
        return None
    stop_if_interrupted(found.solution)
    return found


def _finished(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    sparse = WalkProblem(setting.robot.build(), setting.task)
    try:
        fine = on_fine_grid(sparse)
        between = fine if options.refine else None
        kept = keep(sparse, footing.x, footing.active, warm(options), between)
        if kept is None:
            return None
        problem, solution = pruned(sparse, kept.problem, kept.solution)
        solution = options.solver.confirm(problem, solution)
        stop_if_interrupted(solution)
        return finished(problem, solution, options.refine, fine)
    except EvaluationError:
        return None
