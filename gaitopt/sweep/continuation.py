"""Continuation: from a walk to the walk next to it, and from first guesses to a first one."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import DIGITS, SAME_PEAK, ActiveRow, active_rows
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Search
from gaitopt.design.refinement import with_work
from gaitopt.design.starts import SECOND, StartJob
from gaitopt.errors import EvaluationError, InputError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, resized
from gaitopt.gait.problem import WalkProblem, walk_layout
from gaitopt.nlp import Array, Solution
from gaitopt.sweep.grid import Scenario, interpolated, with_values
from gaitopt.sweep.semi_infinite import (
    FeasibleWalk,
    path_solver,
    solve_between_samples,
    with_all_work,
)
from gaitopt.sweep.warm_start import WarmStart

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
        scenario: where to.
        neighbours: that walk, the most promising first.
        options: as of `design`.
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

    Args:
        scenario: robot and task.
        options: as of `design`.
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
    way: list[FeasibleWalk] = []
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
        way.append(found)
        x, active, last = found.solution.x, found.active, scenario
    return with_all_work(way)


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
    """Return the derivative of the optimal cost with respect to a swept quantity.

    That of the Lagrangian at a fixed point, by the envelope theorem (Nocedal & Wright, 2006,
    section 12.8): what the multipliers say a limit costs, for whatever moves the limits.
    """
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
