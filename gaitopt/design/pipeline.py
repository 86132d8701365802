"""From a first guess to a design: solve at the samples, refine, confirm, certify.

`attempt` goes to a walk on the task's samples by the approach of the options; `complete` makes that
walk a `Design`. A gait that is known may be the start of a search, too (`gone_on`).

Walks whose double support begins with an impact are found by way of those that touch down at zero
speed. An impact that both feet take asks a lot: no joint gives an impulse, and each foot's must be
inside its friction cone and its sole. At many a posture none is but zero, where all limits on it
meet and no solver settles. So the walk that touches down gently is found first, and an impact only
tried where there is room for one (docs/decisions/landing.md).
"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from gaitopt.bounds import INSTANTS, at_most
from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import exceeded, violated_rows
from gaitopt.design.certificate import Certificate, certify, on_fine_grid
from gaitopt.design.extremes import located
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.refinement import refine, with_work
from gaitopt.design.shadow_prices import shadow_prices
from gaitopt.errors import EvaluationError, InputError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.double_step import DoubleStepModel
from gaitopt.gait.functions import Entries, FrictionCone, Linear
from gaitopt.gait.grid import Grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import Layout
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait, Recorded
from gaitopt.gait.task import Task
from gaitopt.nlp import (
    NLP,
    Array,
    Solution,
    Start,
    Status,
    kkt_residual,
    worst_violation,
)
from gaitopt.settings import checked_facts
from gaitopt.solvers import FiniteDifferenceNLP
from gaitopt.solvers.two_stage import UNCONFIRMED
from gaitopt.tolerances import FEASIBLE, OPTIMALITY
from gaitopt.version import __version__

_AT_KNOT, _RATE = "_at_knot_", "_rate_before_impact"  # of names of parameters of joints


def gone_on(problem: WalkProblem, gait: Gait) -> tuple[WalkProblem, Array | None]:
    """Return the walk at the instants of a gait that is an optimum of it, and its multipliers (m,).

    At the task's samples alone such a gait is no optimum: a solver would leave it, and refinement
    might end elsewhere, or nowhere. At its own instants there is nothing left to do. For a gait of
    any other walk, the problem is returned as it is, without multipliers.

    Args:
        problem: the walk, at the task's samples.
        gait: with the parameters of the problem, as `parameters_of` returns them.

    Raises:
        InputError: the instants that the gait records are none.
    """
    rows, bounds = gait.multipliers, gait.bound_multipliers
    if rows is None or bounds is None or gait.parameter_names != problem.layout.names:
        return problem, None
    own = problem.with_grid(with_instants_of(problem.grid, gait))
    if rows.shape != own.rows.lower.shape:
        return problem, None
    try:
        residual = kkt_residual(own, own.point(gait.parameters), rows, bounds)
    except EvaluationError:
        return problem, None
    # least squares may choose other multipliers by rounding, as an audit allows too
    return (own, rows) if residual.worst <= 2.0 * OPTIMALITY else (problem, None)


def with_instants_of(grid: Grid, gait: Recorded) -> Grid:
    """Return a grid with the instants that refinement added to a gait's.

    Raises:
        InputError: they are no numbers from 0 to 1.
    """
    recorded = gait.fact("instants") or []
    if isinstance(recorded, list):
        at_most(len(recorded), INSTANTS, "recorded instants")
    try:
        instants = np.asarray(recorded, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("the gait's 'instants' are not numbers") from error
    if instants.ndim != 1 or not ((instants >= 0.0) & (instants <= 1.0)).all():
        raise InputError("the gait's 'instants' are not numbers from 0 to 1")
    for instant in instants:  # one by one: multipliers are in their order
        grid = grid.with_instants(np.array([instant]))
    return grid


def parameters_of(gait: Gait, problem: WalkProblem) -> Array:
    """Return the parameters (P,) of a gait for a walk; those it lacks are first guesses.

    Raises:
        InputError: the gait moves other joints or has another number of postures.
        UnreachableError: there is no first guess for what the gait does not know.
    """
    at_start = {f"{j}_at_start": q for j, q in zip(gait.joint_names, gait.q[0], strict=True)}
    known = at_start | dict(zip(gait.parameter_names, gait.parameters, strict=True))
    names = problem.layout.names
    joints = [n for n in names if _AT_KNOT in n or n.endswith(_RATE)]
    if set(joints) != {n for n in known if _AT_KNOT in n or n.endswith(_RATE)}:
        raise InputError(
            "the gait given as start moves other joints or has another number of intermediate "
            "postures; take one of the same robot and --postures"
        )
    if all(name in known for name in names):
        return np.array([known[name] for name in names])
    guessed = zip(names, first_guess(problem), strict=True)
    return np.array([known.get(name, value) for name, value in guessed])


RELAXED_LIFTOFF = -0.02
"""Least speed of the rear foot's corners after the impact [m/s] in a relaxed first stage.

A gentle landing puts the four lift-off rows, the impulse and its friction cone at one vertex, where
their gradients depend on each other; this much slack takes the walk away from it.
"""
SOFTER = 1.02
"""Of the cost of the walk whose impulse vanishes, at most, at zero speed (measured: 0.1 to 0.6 %
more, of walks that were no optima yet)."""
SAME_COST = 1e-4  # relative difference of costs that counts as none
SAME_PLACE = 0.05  # largest difference of parameters over their scale
ROUND = 70
"""Iterations of a round of refinement, which begins near its solution (most take fewer than ten). A
round that crawls is better followed by another, at whose instants it often does not."""


@checked_facts
@dataclass(frozen=True)
class Design:
    """A gait with how it was found.

    Attributes:
        gait: the result.
        certificate: its proof.
        solution: what the solver returned, with the work of all rounds.
        problem: the walk on its final grid.
    """

    gait: Gait
    certificate: Certificate
    solution: Solution
    problem: WalkProblem

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return f"<Design: {self.gait!r}, {self.solution.solver}>"

    def _repr_html_(self) -> str | None:
        """Return what a notebook shows: the page of the gait."""
        return self.gait._repr_html_()

    @property
    def proven(self) -> bool:
        """Whether the gait is certified; unrefined, being optimal at its samples is enough."""
        certificate = self.certificate
        if self.gait.meta["refined"]:
            return certificate.certified
        return certificate.optimal and certificate.refereed

    @property
    def rank(self) -> tuple[bool, float]:
        """Order among designs of the same cost function: proven first, then by cost."""
        return not self.proven, self.solution.cost


_Solve = Callable[[WalkProblem, Start], Solution]


def attempt(
    problem: WalkProblem, search: Search, x: Array, multipliers: Array | None = None
) -> Solution:
    """Solve from a first guess by the approach of the options, walk or not.

    With multipliers (m,) it is no guess but a walk that is known, and solved directly; all zero,
    they are those of a walk that stands for one without an impact, which is none.
    """
    options, callback = search.options, search.callback(problem)

    def solve(walk: WalkProblem, start: Start) -> Solution:
        solver = options.solver.first_stage
        return solver.solve(derived(walk, options), start, callback, search.ends)

    if problem.schedule.striking and (multipliers is None or not multipliers.any()):
        return _struck_walk(problem, x, solve)
    if multipliers is not None or not begins_relaxed(problem.task, options):
        return solve(problem, Start(x, multipliers))
    start, spent = _relaxed_walk(problem, x, solve)
    if spent.status is Status.INTERRUPTED:
        return replace(spent, cost=np.nan, violation=np.inf)  # of another walk
    if spent.status is Status.INFEASIBLE and _violates_no_more(problem, spent):
        # what keeps it from being a walk does so without slack, too (measured: of 22 such searches
        # none finds a walk from the first guess either)
        return spent
    return with_work(solve(problem, start), spent)


def _struck_walk(problem: WalkProblem, x: Array, solve: _Solve) -> Solution:
    """Solve a walk whose double support begins with an impact, from one that touches down gently.

    Where there is no impact that both feet could take, that walk, as one that has stalled.
    """
    easier = gentle(problem)
    found = solve(easier, Start(carried_over(x, problem, easier)))
    if found.status is Status.INTERRUPTED:
        return replace(found, cost=np.nan, violation=np.inf)  # of another walk
    if not is_walk(found):
        return with_work(solve(problem, Start(x)), found)
    y = carried_over(found.x, easier, problem)
    if impact_possible(problem, y):
        return with_work(solve(problem, Start(y)), found)
    none = np.zeros(problem.rows.lower.size), np.zeros(y.size)
    return replace(
        found, x=y, status=Status.STALLED, multipliers=none[0], bound_multipliers=none[1],
        hessian=None,
    )  # fmt: skip


def begins_relaxed(task: Task, options: DesignOptions) -> bool:
    """Return whether to begin with a rear foot that may sink at lift-off."""
    wanted = options.approach == "relaxed" or (
        options.approach == "automatic" and task.boundary == "lifted"
    )
    lifts = task.double_support is None  # else the rear foot leaves at rest, without such a limit
    return wanted and lifts and task.margins.liftoff_speed > RELAXED_LIFTOFF


def is_walk(solution: Solution) -> bool:
    """Return whether a solution is a walk: feasible, optimal or not."""
    return bool(np.isfinite(solution.cost)) and solution.violation <= FEASIBLE


def _violates_no_more(problem: WalkProblem, relaxed: Solution) -> bool:
    """Return whether a walk keeps its limits as well as one with relaxed limits kept those."""
    at, _ = worst_violation(problem, problem.values(relaxed.x))
    return at <= relaxed.violation * (1.0 + 1e-9)


def same_optimum(
    problem: WalkProblem, one: tuple[float, Array], other: tuple[float, Array]
) -> bool:
    """Return whether two optima, cost and parameters (P,), are one to the precision of solvers."""
    away = np.abs(one[1] - other[1]) / problem.variables.scale
    near = abs(one[0] - other[0]) <= SAME_COST * abs(other[0])
    return bool(near and away.max() <= SAME_PLACE)


def _relaxed_walk(problem: WalkProblem, x: Array, solve: _Solve) -> tuple[Start, Solution]:
    """Return where the relaxed walk leads to, and the work it took."""
    margins = replace(
        problem.task.margins, liftoff_speed=RELAXED_LIFTOFF * problem.robot.scales.speed
    )
    found = solve(problem.with_task(replace(problem.task, margins=margins)), Start(x))
    if not (is_walk(found) or found.status is Status.OPTIMAL):  # roughly, if that was asked for
        return Start(x), found
    return Start(found.x, found.multipliers), found


def derived(problem: WalkProblem, options: DesignOptions) -> NLP:
    """Return the walk with derivatives as the options want them."""
    if options.differences == "none":
        return problem
    return FiniteDifferenceNLP(problem, cost_gradient_only=options.differences == "constraints")


def complete(
    problem: WalkProblem, solution: Solution, search: Search, fine: WalkProblem | None = None
) -> Design:
    """Refine, confirm and certify a walk that was solved on the samples of its task.

    Args:
        fine: the walk on the certificate's grid, of one that is refined already.

    Raises:
        EvaluationError: the walk is not defined between its samples.
    """
    return finished(*polished(problem, solution, search, fine))


def polished(
    problem: WalkProblem, solution: Solution, search: Search, fine: WalkProblem | None = None
) -> tuple[WalkProblem, Solution, bool, WalkProblem]:
    """Refine and confirm a walk; as `complete`.

    Returns:
        What `finished` takes: the walk on its final grid, its solution, whether it was refined, the
        walk on the certificate's grid.
    """
    options = search.options
    first = options.solver.first_stage.limited(ROUND)
    if fine is None:
        problem, solution = landed_softly(problem, solution, search)
        fine = on_fine_grid(problem)
        if options.refine:
            problem, solution = refine(problem, solution, first, search, fine=fine)
    confirmed = options.solver.confirm(problem, solution, search.callback(problem), search.ends)
    if options.refine and _lets_go(fine, solution, confirmed):
        # A row that hardly presses is not held by Newton's method, which then passes it between
        # the samples: hold it there too.
        finer, again = refine(problem, confirmed, first, search, fine=fine)
        again = options.solver.confirm(finer, again, None, search.ends)
        if _lets_go(fine, solution, again):
            return problem, replace(with_work(solution, again), solver=UNCONFIRMED), True, fine
        problem, confirmed = finer, again
    return problem, confirmed, options.refine, fine


def _lets_go(fine: WalkProblem, before: Solution, after: Solution) -> bool:
    """Return whether a solution exceeds limits between its samples that one before it kept."""
    extremes = located(fine, after.x, everywhere=True)  # as the certificate asks next
    return bool(exceeded(fine, extremes)) and not violated_rows(fine, before.x)


def impulse_vanishes(problem: WalkProblem, solution: Solution) -> bool:
    """Return whether a walk is no optimum and its impact all but vanishes."""
    return solution.status is not Status.OPTIMAL and problem.is_tip(solution.x)


def without_impact(problem: WalkProblem) -> WalkProblem:
    """Return the same walk landing at zero speed."""
    if problem.schedule.striking:
        return gentle(problem)
    task = problem.task.with_margins({"soft_landing": True})
    return problem.with_task(task)


def landed_softly(
    problem: WalkProblem, solution: Solution, search: Search
) -> tuple[WalkProblem, Solution]:
    """Return a walk whose impulse vanishes as one that lands at zero speed, itself otherwise.

    At an impulse of zero its friction cone has a tip and all limits on it meet; solvers crawl
    there. Without an impact the same walk is a regular optimum.
    """
    if not impulse_vanishes(problem, solution):
        return problem, solution
    softly, x = without_impact(problem), solution.x
    if problem.schedule.striking:
        x = carried_over(x, problem, softly)
    found = attempt(softly, search.quiet.changed(approach="direct"), x)
    if not is_walk(found) or found.cost > SOFTER * solution.cost:
        return problem, solution
    return softly, with_work(found, solution)


def finished(
    problem: WalkProblem, solution: Solution, refined: bool, fine: WalkProblem | None = None
) -> Design:
    """Return a solution of a walk on its final grid as a design: with its gait and its proof.

    Args:
        refined: whether it was meant to hold between the samples too.
        fine: the walk on the certificate's grid, if it is at hand.
    """
    certificate = certify(problem, solution.x, fine)
    meta = proof_record(solution, certificate, refined)
    meta["findings"] = [finding.record() for finding in problem.robot.findings]
    if certificate.optimal:
        prices = shadow_prices(problem, solution.x, certificate.multipliers)
        meta["shadow_prices"] = [price.record() for price in prices]
    gait = gait_at(problem, solution.x, meta, certificate.multipliers)
    return Design(gait, certificate, solution, problem)


def proof_record(solution: Solution, certificate: Certificate, refined: bool) -> dict[str, object]:
    """Return how a solution was found and what was proven of it, JSON-able."""
    return {
        "solver": {
            "name": solution.solver,
            "status": solution.status.name.lower(),
            "violation": solution.violation,
            "optimality": solution.optimality,
            "iterations": solution.iterations,
            "evaluations": solution.evaluations,
            "hessians": solution.hessians,
            "seconds": solution.seconds,
        },
        "status": solution.status.value,
        "refined": refined,
        "certificate": certificate.record(),
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """Return the versions that a result depends on."""
    return {
        "gaitopt": __version__,
        "pinocchio": str(pin.__version__),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


_NONE = 1e-9
"""Largest vertical impulse of the front foot that is none, where 1 N·s is the most there may be."""


def gentle(problem: WalkProblem) -> WalkProblem:
    """Return the same walk touching down at zero speed."""
    task = replace(problem.task, touch_down="gentle")
    return WalkProblem(problem.robot, task, problem.grid)


def carried_over(x: Array, one: WalkProblem, other: WalkProblem) -> Array:
    """Return x (P,) of `one` as parameters of `other`, which begins its double support otherwise.

    Of an impact: as it is after it, and without an impulse where there was none.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    model, follows = one.model, other.model
    assert isinstance(model, DoubleStepModel)
    assert isinstance(follows, DoubleStepModel)
    a, b = one.layout, other.layout
    assert isinstance(a, Layout)
    assert isinstance(b, Layout)
    found = np.zeros(b.size)
    for name in ("knots", "rates", "start", "shape", "front", "largest"):
        found[getattr(b, name)] = x[getattr(a, name)]
    found[b.late] = follows.bends(model.late_motion(one.step(x)))
    return found


def impact_possible(problem: WalkProblem, x: Array) -> bool:
    """Return whether there may be an impact that both feet take, at the posture x (P,).

    Cones count as the pyramids around them, so that where there is none there is none indeed.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    model = problem.model
    assert isinstance(model, DoubleStepModel)
    by_front = {
        quantities.IMPULSE: np.eye(6),
        quantities.REAR_IMPULSE: model.rear_impulses(problem.step(x)),
    }
    rows = []
    for block in problem.blocks:
        if block.reads[0] not in by_front or len(block.reads) > 1:
            continue
        matrix = by_front[block.reads[0]]
        if isinstance(block.function, FrictionCone):
            mu = block.function.friction
            sides = [[sign * (axis == 0), sign * (axis == 1), -mu, 0, 0, 0]
                     for axis in (0, 1) for sign in (-1.0, 1.0)]  # fmt: skip
            rows.append(np.array(sides) @ matrix)
        elif isinstance(block.function, Linear | Entries) and (block.lower == 0.0).all():
            rows.append(-np.asarray(block.function.jacobian(np.zeros((1, 6)))) @ matrix)
    from scipy.optimize import linprog  # slow to import, and few walks ask for it

    above = np.concatenate(rows)
    free = (-np.inf, np.inf)
    bounds = [free, free, (0.0, 1.0), free, free, free]
    cost = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    found = linprog(cost, A_ub=above, b_ub=np.zeros(len(above)), bounds=bounds)
    return found.x is None or bool(found.x[2] > _NONE)
