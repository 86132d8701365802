"""Continuation: from a walk to the walk next to it, and from first guesses to a first one."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gaitopt.design.active_set import Pressure, pressures
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.options import DesignOptions
from gaitopt.design.refinement import with_work
from gaitopt.design.starts import SECOND, Outcome, StartJob
from gaitopt.errors import EvaluationError, InputError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, resized
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution
from gaitopt.solvers import Solver
from gaitopt.solvers.sqp import SQP
from gaitopt.sweep.grid import with_values
from gaitopt.sweep.scenario import RobotSource, Setting, between
from gaitopt.sweep.semi_infinite import Kept, joined, keep, stop_if_interrupted, warm
from gaitopt.sweep.warm_start import Footing

_ORIGINS = {0: "cold", SECOND: "slower walk"}  # by number of the start
NOISE = (0.1, 0.2)  # rad, of the disturbed first guesses tried in the end


def cold_walks(setting: Setting, options: DesignOptions) -> Iterator[tuple[str, Solution]]:
    """Yield walks at the samples with where they came from, the most promising first.

    Args:
        setting: robot and task.
        options: as of `design`.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    robot, task = setting.robot.build(), setting.task
    try:
        x = first_guess(WalkProblem(robot, task))
    except UnreachableError:
        return
    job = StartJob(robot, task, replace(options, diagnose=False), x, sigma=0.0, seed=0)
    outcomes = [_outcome(job, number) for number in _ORIGINS]
    for one in sorted((o for o in outcomes if o.walks), key=lambda o: o.solution.cost):
        yield _ORIGINS[one.number], one.solution
    for number, sigma in enumerate(NOISE, SECOND + 1):
        one = _outcome(replace(job, sigma=sigma), number)
        if one.walks:
            yield "disturbed", one.solution


def _outcome(job: StartJob, number: int) -> Outcome:
    outcome = job.run(number)
    stop_if_interrupted(outcome.solution)
    return outcome


NEARLY = 1e-4  # tolerance of the solver on the way; measured: with 1e-3 some go astray
BETWEEN = 1e-4  # violation between the samples on the way: costs are right to 2e-4 (measured)
PATIENCE = 100  # iterations; a neighbour's walk needs a tenth of them
SUBSTEPS = (2, 4)  # into which a stride to a neighbour is divided if it fails
NUDGE = 1e-5  # relative change of a swept quantity for the slope of the cost

Near = tuple[Setting, Footing, str]
"""Setting and footing of a neighbour, and the name of its point."""


def travel(
    setting: Setting,
    near: Sequence[Near],
    options: DesignOptions,
    axes: Sequence[tuple[str, float]],
    *,
    patient: bool,
    cold: bool,
    below: float = math.inf,
) -> Footing | None:
    """Return a walk at a setting, the first that is found in this order.

    From each neighbour; by smaller steps from each neighbour; from the usual first guess or from a
    slower walk, whichever is cheaper; from disturbed guesses.

    Args:
        setting: where to.
        near: neighbours that walk, the most promising first.
        options: as of `design`.
        axes: swept quantities with their values at the setting.
        patient: whether to try smaller steps.
        cold: whether to try without neighbours too.
        below: a walk of this cost or more is not wanted from a neighbour.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
        InputError: the task or the robot cannot be.
    """
    began = time.process_time()
    for steps in (1, *SUBSTEPS) if patient else (1,):
        for start in near:
            found = _strides(start, setting, steps, options, below)
            if found is not None:
                return _footing(setting, found, began, axes, start[2])
    if not cold:
        return None
    problem = WalkProblem(setting.robot.build(), setting.task)
    for origin, solution in cold_walks(setting, options):
        active = pressures(problem, solution.multipliers)
        kept = _kept(problem, solution.x, active, options)
        if kept is not None:
            whole = replace(kept, solution=with_work(kept.solution, solution))
            return _footing(setting, whole, began, axes, origin)
    return None


def _strides(
    start: Near, goal: Setting, steps: int, options: DesignOptions, below: float
) -> Kept | None:
    origin, footing, _ = start
    x, active = footing.x, footing.active
    last = origin
    way: list[Kept] = []
    for step in range(1, steps + 1):
        try:
            setting = between(origin, goal, step / steps)
            sparse = WalkProblem(setting.robot.build(), setting.task)
        except InputError:
            if step == steps:
                raise
            return None
        if setting.robot.changes != last.robot.changes:
            x = resized(x, WalkProblem(last.robot.build(), last.task), sparse)
        limit = below if step == steps else math.inf
        kept = _kept(sparse, x, active, options, limit)
        if kept is None:
            return None
        way.append(kept)
        x, active, last = kept.solution.x, kept.active, setting
    return joined(way)


def _kept(
    sparse: WalkProblem,
    x: Array,
    active: tuple[Pressure, ...],
    options: DesignOptions,
    below: float = math.inf,
) -> Kept | None:
    if x.shape != (sparse.layout.size,):
        return None
    fine = on_fine_grid(sparse) if options.refine else None
    try:
        return keep(sparse, x, active, quick(options), fine, enough=BETWEEN, below=below)
    except EvaluationError:
        return None


def quick(options: DesignOptions) -> Solver:
    """Return the solver for the way: it stops early, at success and at failure."""
    solver = warm(options)
    if not isinstance(solver, SQP):
        return solver
    most = min(solver.max_iterations, PATIENCE)
    return replace(solver, tolerance=max(NEARLY, solver.tolerance), max_iterations=most)


def _footing(
    setting: Setting,
    kept: Kept,
    began: float,
    axes: Sequence[tuple[str, float]],
    origin: str,
) -> Footing:
    solution = kept.solution
    slopes = tuple(_slope(setting, kept.problem, solution, axis) for axis in axes)
    return Footing(
        x=solution.x,
        cost=solution.cost,
        active=kept.active,
        slopes=slopes,
        journey=kept.journey,
        iterations=solution.iterations,
        evaluations=solution.evaluations,
        seconds=time.process_time() - began,
        origin=origin,
    )


def _slope(
    setting: Setting, problem: WalkProblem, solution: Solution, axis: tuple[str, float]
) -> float | None:
    """Return the derivative of the optimal cost with respect to a swept quantity.

    That of the Lagrangian at a fixed point, by the envelope theorem (Nocedal & Wright, 2006,
    section 12.8): what the multipliers say a limit costs, for whatever moves the limits.
    """
    name, value = axis
    step = NUDGE * max(abs(value), 0.1)
    for nudge in (step, -step):
        try:
            other = _nudged(setting, name, value + nudge)
            nearby = WalkProblem(other.robot.build(), other.task, problem.grid)
            return (_lagrangian(nearby, problem, solution) - solution.cost) / nudge
        except (InputError, EvaluationError):
            continue
    return None


def _nudged(setting: Setting, name: str, value: float) -> Setting:
    changes = tuple((k, value if k == name else v) for k, v in setting.robot.changes)
    robot: RobotSource = replace(setting.robot, changes=changes)
    return Setting(robot, with_values(setting.task, [(name, value)]))


def _lagrangian(nearby: WalkProblem, problem: WalkProblem, solution: Solution) -> float:
    values, rows, variables = nearby.values(solution.x), nearby.rows, nearby.variables
    excess = _excess(values.rows, rows.lower, rows.upper, solution.multipliers)
    excess += _excess(solution.x, variables.lower, variables.upper, solution.bound_multipliers)
    return values.cost + excess / problem.cost_scale


def _excess(values: Array, lower: Array, upper: Array, multipliers: Array) -> float:
    """Return how far values are beyond the limits that are pressed on, weighed, summed."""
    pressed = np.flatnonzero(multipliers)
    limits = np.where(multipliers > 0.0, upper, lower)[pressed]
    return float(multipliers[pressed] @ (values[pressed] - limits))
