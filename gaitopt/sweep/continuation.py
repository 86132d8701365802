"""Continuation: from a walk to the walk next to it, and from first guesses to a first one.

The best walk known at a point is where its neighbours start. Along a branch of local optima the
cost is a smooth function of the swept quantity, and the multipliers tell its derivative. A
neighbour promises what its tangent predicts, give or take what the change of the derivative between
the two can bend it. Whether two walks are of the same branch cannot be told from costs and
derivatives alone (branches 2 % apart pass every such test, measured). So a promise is tried, once,
unless the neighbour itself came from the point in so few iterations that it must have stayed on the
branch.

Walks keep their limits at every instant: violated ones are added to the grid, and it is solved
again and certified.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import (
    DIGITS,
    SAME_PEAK,
    ActiveRow,
    active_rows,
    instants_of,
    placed,
    violated_rows,
)
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import SAME_COST, Design, finished, is_walk
from gaitopt.design.refinement import (
    exchange,
    is_strict,
    on_either_side,
    pruned,
    quadratic,
    with_work,
)
from gaitopt.design.starts import SECOND, StartJob
from gaitopt.errors import EvaluationError, InputError, NoGaitFoundError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, resized
from gaitopt.gait.problem import WalkProblem, walk_layout
from gaitopt.nlp import Array, Solution, Start
from gaitopt.solvers import Solver
from gaitopt.sweep.grid import Index, Scenario, TaskGrid, interpolated, with_values

ON_BRANCH = 8  # iterations from a neighbour that stay on its branch; leaving takes more (measured)
OFF_BRANCH = 13  # iterations; more have not followed a branch (measured: most take 4 to 6)


@dataclass(frozen=True, eq=False)
class WarmStart:
    """A walk from which neighbours and the finished gait start.

    Attributes:
        x: parameters, shape (P,).
        cost: in the unit of the task's cost.
        active: limits at which it is, with their multipliers.
        cost_gradient: derivative of the optimal cost with respect to each swept quantity, from the
            multipliers; None where it could not be had.
        first_iterations: that led to it from its origin, before instants were added.
        iterations, evaluations: of everything.
        seconds: of processor.
        origin: "cold", "slower walk", "disturbed", or the name of the point it was reached from.
        beside: names of other points through whose walks, of the same branch, it was foretold.
    """

    x: Array
    cost: float
    active: tuple[ActiveRow, ...]
    cost_gradient: tuple[float | None, ...]
    first_iterations: int
    iterations: int
    evaluations: int
    seconds: float
    origin: str
    beside: tuple[str, ...] = ()

    @property
    def left_branch(self) -> bool:
        """Whether it took so many iterations that the walk may be of any branch."""
        return self.first_iterations > OFF_BRANCH

    def record(self) -> dict[str, object]:
        """Return it as JSON-able data."""
        return {
            **vars(self),
            "x": self.x.tolist(),
            "active": [[p.constraint, p.entry, p.instant, p.multiplier] for p in self.active],
        }


def warm_start_of(record: Mapping[str, Any]) -> WarmStart:
    """Return the warm start of a record.

    Raises:
        KeyError, TypeError, ValueError: it is none.
    """
    if not isinstance(record["origin"], str):
        raise TypeError("the origin of a walk is no text")
    gradient, beside = record["cost_gradient"], tuple(record.get("beside", ()))
    if not all(isinstance(name, str) for name in beside):
        raise TypeError("a walk was foretold by what is no text")
    return WarmStart(
        x=np.array(record["x"], dtype=np.float64),
        cost=float(record["cost"]),
        active=tuple(_active(*entry) for entry in record["active"]),
        cost_gradient=tuple(None if slope is None else float(slope) for slope in gradient),
        first_iterations=int(record["first_iterations"]),
        iterations=int(record["iterations"]),
        evaluations=int(record["evaluations"]),
        seconds=float(record["seconds"]),
        origin=record["origin"],
        beside=beside,
    )


def _active(constraint: object, entry: object, instant: Any, multiplier: Any) -> ActiveRow:
    if not isinstance(constraint, str) or not isinstance(entry, int):
        raise TypeError("an active limit has no name or no number")
    return ActiveRow(constraint, entry, float(instant), float(multiplier))


def promising(
    grid: TaskGrid,
    walk_at: Callable[[Index], WarmStart | None],
    point: Index,
    neighbours: Iterable[tuple[int, Index]],
) -> list[Index]:
    """Return the neighbours from which a point might reach a lower cost, the best first.

    Args:
        walk_at: returns the walk known at a point, None where none was found.
        point: which; one without a walk is promised one by every neighbour that walks.
        neighbours: of the point, each with its axis, see `GridLevel.neighbours`.
    """
    here = walk_at(point)
    found: list[tuple[float, Index]] = []
    for axis, other in neighbours:
        there = walk_at(other)
        if there is None or (here is not None and _followed(there, grid.name(point))):
            continue
        values = grid.axes[axis].values
        stride = values[point[axis]] - values[other[axis]]
        slope = there.cost_gradient[axis] or 0.0
        predicted = there.cost + slope * stride
        if here is not None:
            curved = 0.5 * abs((slope - (here.cost_gradient[axis] or 0.0)) * stride)
            if predicted - curved >= here.cost * (1.0 - SAME_COST):
                continue
        found.append((predicted, other))
    return [other for _, other in sorted(found)]


def _followed(there: WarmStart, name: str) -> bool:
    return name in (there.origin, *there.beside) and there.first_iterations <= ON_BRANCH


def is_better(found: WarmStart | None, known: WarmStart | None) -> bool:
    """Whether a walk is worth taking in place of the one known."""
    if found is None or known is None:
        return found is not None
    return found.cost < known.cost * (1.0 - SAME_COST)


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
    near = False
    for problem, solution, moving in exchange(sparse, x, active, solve, fine, peaks, newton):
        if not is_walk(solution) or solution.cost >= cost_limit:
            return None
        near = moving
        if found is None:
            found = FeasibleWalk(problem, solution, solution.iterations)
        else:
            whole = with_work(solution, found.solution)
            found = FeasibleWalk(problem, whole, found.first_iterations)
    if not near and found is not None and fine is not None:  # rounds may end with limits exceeded
        return None if violated_rows(fine, found.solution.x) else found
    return found


def finish(scenario: Scenario, walk: WarmStart, options: DesignOptions) -> Design | None:
    """Return the finished gait of a walk, None where refinement leaves none.

    The better of two ways if the first is not certified.
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
    """Return a walk finished at the instants at which it presses, None if it is no walk there."""
    # Where it is no strict minimum there, at instants on either side of them: else Newton's method
    # would not confirm it, and the interior point method after it in half a second neither.
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


LEAP = 0.5  # scaled difference of parameters from which on walks are taken for two branches
SUBSTEPS = (2, 4)  # into which a stride to a neighbour is divided if it fails
DIFFERENCE = 1e-5  # relative change of a swept quantity, for the derivative of the cost
NOISE = (0.1, 0.2)  # rad, of the disturbed first guesses tried in the end

_ORIGINS = {0: "cold", SECOND: "slower walk"}  # by number of the start


@dataclass(frozen=True, eq=False)
class Neighbour:
    """A point next to the one that is sought, with its walk and its name.

    Attributes:
        scenario: the point.
        walk: its walk.
        name: of the walk, for people.
    """

    scenario: Scenario
    walk: WarmStart
    name: str


@dataclass(frozen=True, eq=False)
class Station:
    """A walk that differs in one quantity from the one that is sought.

    Attributes:
        place: by how much the quantity is larger there.
        walk: the walk.
        name: of its point.
    """

    place: float
    walk: WarmStart
    name: str


Line = tuple[Station, ...]


def continue_from(
    scenario: Scenario,
    neighbours: Sequence[Neighbour],
    options: DesignOptions,
    axes: Sequence[tuple[str, float]],
    *,
    substeps: bool,
    cold_start: bool,
    cost_limit: float = math.inf,
    line: Line = (),
) -> WarmStart | None:
    """Return a walk of a scenario, the first that is found in this order.

    From the polynomial through the walks of a line, as far as they are of one branch; from each
    neighbour; by smaller steps from each neighbour; from the usual first guess or from a slower
    walk, whichever is cheaper; from disturbed guesses.

    Args:
        neighbours: that walk, the most promising first.
        axes: swept quantities with their values there.
        substeps: whether to try smaller steps.
        cold_start: whether to try without neighbours too.
        cost_limit: of a walk that is wanted from a neighbour.
        line: walks along one quantity, the first that of the first neighbour.

    Raises:
        InputError: the task or the robot cannot be.
    """
    began = time.process_time()
    near = _of_one_branch(line, scenario)
    if len(near) > 1:
        problem = WalkProblem(scenario.robot.build(), scenario.task)
        found = _feasible(problem, *extrapolated(near), options, cost_limit)
        if found is not None:
            walk = _warm_start(scenario, found, began, axes, near[0].name)
            return replace(walk, beside=tuple(station.name for station in near[1:]))
    for steps in (1, *SUBSTEPS) if substeps else (1,):
        for start in neighbours:
            found = _strides(start, scenario, steps, options, cost_limit)
            if found is not None:
                return _warm_start(scenario, found, began, axes, start.name)
    if not cold_start:
        return None
    problem = WalkProblem(scenario.robot.build(), scenario.task)
    for origin, solution in cold_walks(scenario, options):
        active = active_rows(problem, solution.multipliers)
        found = _feasible(problem, solution.x, active, options)
        if found is not None:
            whole = replace(found, solution=with_work(found.solution, solution))
            return _warm_start(scenario, whole, began, axes, origin)
    return None


def cold_walks(scenario: Scenario, options: DesignOptions) -> Iterator[tuple[str, Solution]]:
    """Yield walks at the samples with where they came from, the most promising first.

    The starts are those of a single design, then disturbed ones.
    """
    robot, task = scenario.robot.build(), scenario.task
    try:
        x = first_guess(WalkProblem(robot, task))
    except UnreachableError:
        return
    search = Search(replace(options, diagnose=False))
    job = StartJob(robot, task, x, sigma=0.0, seed=0)
    outcomes = [job.run(number, search) for number in _ORIGINS]
    for one in sorted((o for o in outcomes if o.walks), key=lambda o: o.solution.cost):
        yield _ORIGINS[one.number], one.solution
    for number, sigma in enumerate(NOISE, SECOND + 1):
        one = replace(job, sigma=sigma).run(number, search)
        if one.walks:
            yield "disturbed", one.solution


def _of_one_branch(line: Line, scenario: Scenario) -> Line:
    """Return the walks of a line that are of the branch of the first, as far as can be seen."""
    if not line:
        return ()
    scale = walk_layout(scenario.robot.build(), scenario.task).scale()
    x = line[0].walk.x
    return tuple(
        one
        for one in line
        if one.walk.x.shape == scale.shape and np.abs((one.walk.x - x) / scale).max() < LEAP
    )


def extrapolated(line: Line) -> tuple[Array, tuple[ActiveRow, ...]]:
    """Return parameters (P,) and active limits by the polynomial through walks, at its argument 0.

    The active limits are those of the first walk; where the others have them too, at about the same
    instant, instant and multiplier are of the polynomial.
    """
    places: Array = np.array([one.place for one in line])
    weights = [
        float(np.prod(np.delete(places, k) / (np.delete(places, k) - places[k])))
        for k in range(places.size)
    ]
    x = np.sum([w * one.walk.x for w, one in zip(weights, line, strict=True)], axis=0)
    active = tuple(_extrapolated(row, line[1:], weights) for row in line[0].walk.active)
    return np.asarray(x), active


def _extrapolated(row: ActiveRow, others: Line, weights: Sequence[float]) -> ActiveRow:
    instant, multiplier = weights[0] * row.instant, weights[0] * row.multiplier
    for weight, other in zip(weights[1:], others, strict=True):
        alike = [
            one
            for one in other.walk.active
            if (one.constraint, one.entry) == (row.constraint, row.entry)
            and abs(one.instant - row.instant) <= SAME_PEAK
            and one.multiplier * row.multiplier > 0.0
        ]
        if not alike:
            return row
        nearest = min(alike, key=lambda one: abs(one.instant - row.instant))
        instant += weight * nearest.instant
        multiplier += weight * nearest.multiplier
    inside = SAME_PEAK < instant < 1.0 - SAME_PEAK and row.instant % 1.0 != 0.0
    return replace(
        row,
        instant=round(instant, DIGITS) if inside else row.instant,
        multiplier=multiplier if multiplier * row.multiplier > 0.0 else 0.0,
    )


def _strides(
    start: Neighbour, goal: Scenario, steps: int, options: DesignOptions, cost_limit: float
) -> FeasibleWalk | None:
    x, active, last = start.walk.x, start.walk.active, start.scenario
    walk: FeasibleWalk | None = None
    for step in range(1, steps + 1):
        try:
            scenario = interpolated(start.scenario, goal, step / steps)
            sparse = WalkProblem(scenario.robot.build(), scenario.task)
        except InputError:
            if step == steps:
                raise
            return None
        if scenario.robot.changes != last.robot.changes:
            x = resized(x, WalkProblem(last.robot.build(), last.task), sparse)
        limit = cost_limit if step == steps else math.inf
        found = _feasible(sparse, x, active, options, limit)
        if found is None:
            return None
        x, active, last = found.solution.x, found.active, scenario
        if walk is not None:  # all the work of the way counts
            whole = with_work(found.solution, walk.solution)
            first = found.first_iterations + walk.first_iterations
            found = FeasibleWalk(found.problem, whole, first)
        walk = found
    return walk


def _feasible(
    sparse: WalkProblem,
    x: Array,
    active: tuple[ActiveRow, ...],
    options: DesignOptions,
    cost_limit: float = math.inf,
) -> FeasibleWalk | None:
    if x.shape != (sparse.layout.size,):
        return None
    fine = on_fine_grid(sparse) if options.refine else None
    solver = path_solver(options)
    try:
        return solve_between_samples(sparse, x, active, solver, fine, cost_limit=cost_limit)
    except EvaluationError:
        return None


def _warm_start(
    scenario: Scenario,
    found: FeasibleWalk,
    began: float,
    axes: Sequence[tuple[str, float]],
    origin: str,
) -> WarmStart:
    solution = found.solution
    gradient = tuple(_cost_slope(scenario, found.problem, solution, axis) for axis in axes)
    return WarmStart(
        x=solution.x,
        cost=solution.cost,
        active=found.active,
        cost_gradient=gradient,
        first_iterations=found.first_iterations,
        iterations=solution.iterations,
        evaluations=solution.evaluations,
        seconds=time.process_time() - began,
        origin=origin,
    )


def _cost_slope(
    scenario: Scenario, problem: WalkProblem, solution: Solution, axis: tuple[str, float]
) -> float | None:
    """Return the derivative of the optimal cost with respect to a swept quantity."""
    # That of the Lagrangian at a fixed point, by the envelope theorem (Nocedal & Wright, 2006,
    # section 12.8): what the multipliers say a limit costs, for whatever moves the limits.
    name, value = axis
    step = DIFFERENCE * max(abs(value), 0.1)
    for change in (step, -step):
        try:
            other = _changed(scenario, name, value + change)
            if other.task.in_place != scenario.task.in_place:  # whose cost is per second
                return None
            nearby = WalkProblem(other.robot.build(), other.task, problem.grid, neighbour=problem)
            return (_lagrangian(nearby, problem, solution) - solution.cost) / change
        except (InputError, EvaluationError):
            continue
    return None


def _changed(scenario: Scenario, name: str, value: float) -> Scenario:
    changes = tuple((k, value if k == name else v) for k, v in scenario.robot.changes)
    robot = replace(scenario.robot, changes=changes)
    return Scenario(robot, with_values(scenario.task, [(name, value)])).driven()


def _lagrangian(nearby: WalkProblem, problem: WalkProblem, solution: Solution) -> float:
    values, rows, variables = nearby.values(solution.x), nearby.rows, nearby.variables
    excess = _excess(values.rows, rows.lower, rows.upper, solution.multipliers)
    excess += _excess(solution.x, variables.lower, variables.upper, solution.bound_multipliers)
    return values.cost + excess / problem.cost_scale


def _excess(values: Array, lower: Array, upper: Array, multipliers: Array) -> float:
    """Return how far values are beyond the limits that are active, times multipliers, summed."""
    active = np.flatnonzero(multipliers)
    limits = np.where(multipliers > 0.0, upper, lower)[active]
    return float(multipliers[active] @ (values[active] - limits))
