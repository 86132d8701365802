"""From a walk to the walk next to it, and from nowhere to a first one."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gaitopt.design.options import DesignOptions
from gaitopt.design.search import is_walk, search, traveller
from gaitopt.errors import EvaluationError, InputError, NoGaitFoundError, UnreachableError
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start, Status
from gaitopt.solvers import Solver
from gaitopt.solvers.sqp import SQP
from gaitopt.study.active import instants_of, placed, pressures
from gaitopt.study.axes import with_values
from gaitopt.study.footing import Footing
from gaitopt.study.setting import RobotSource, Setting, between

RADIUS = 0.5  # first trust region from a neighbour; measured: 0.1 costs a quarter more iterations
NEARLY = 1e-5  # tolerance on the way; measured: with 1e-3 walks near a branching go astray
PATIENCE = 100  # iterations; a neighbour's walk needs a tenth of them
SUBSTEPS = (2, 4)  # into which a stride to a neighbour is divided if it fails
NOISE = (0.1, 0.2)  # rad, of the disturbed first guesses tried in the end
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
) -> Footing | None:
    """Return a walk at a setting, the first that is found in this order.

    From each neighbour; by smaller steps from each neighbour; from the usual first guess; from
    disturbed ones.

    Args:
        setting: where to.
        near: neighbours that walk, the most promising first.
        options: as of `design`.
        axes: swept quantities with their values at the setting.
        patient: whether to try smaller steps.
        cold: whether to try without neighbours too.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
        InputError: the task or the robot cannot be.
    """
    for steps in (1, *SUBSTEPS) if patient else (1,):
        for start in near:
            found = _strides(start, setting, steps, options)
            if found is not None:
                return _footing(setting, *found, axes, start[2])
    if not cold:
        return None
    for number, sigma in enumerate((0.0, *NOISE)):
        found = _cold(setting, options, sigma, number)
        if found is not None:
            return _footing(setting, *found, axes, "disturbed" if sigma else "cold")
    return None


_Found = tuple[WalkProblem, Solution, float]
"""Walk, solution, and seconds of processor."""


def _strides(start: Near, goal: Setting, steps: int, options: DesignOptions) -> _Found | None:
    began = time.process_time()
    origin, footing, _ = start
    x, active = footing.x, footing.active
    found = None
    for step in range(1, steps + 1):
        try:
            setting = between(origin, goal, step / steps)
            robot = setting.robot.build()
        except InputError:
            if step == steps:
                raise
            return None
        sparse = WalkProblem(robot, setting.task)
        grid = uniform_grid(setting.task.samples, setting.task.quadrature)
        problem = sparse.with_grid(grid.with_instants(instants_of(sparse, active)))
        if x.shape != (problem.layout.size,):
            return None
        solution = solved(quick(options), problem, Start(x, placed(problem, active)))
        if not is_walk(solution):
            return None
        x, active = solution.x, pressures(problem, solution.multipliers)
        found = problem, solution
    return None if found is None else (*found, time.process_time() - began)


def _cold(setting: Setting, options: DesignOptions, sigma: float, seed: int) -> _Found | None:
    began = time.process_time()
    problem = WalkProblem(setting.robot.build(), setting.task)
    try:
        x = first_guess(problem)
        x = perturbed(problem, x, sigma, seed) if sigma else x
        solution = search(problem, replace(options, diagnose=False), x, None)
    except (NoGaitFoundError, UnreachableError) as error:
        stop_if_interrupted(getattr(error, "solution", None))
        return None
    stop_if_interrupted(solution)
    return problem, solution, time.process_time() - began


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


def warm(options: DesignOptions) -> Solver:
    """Return the travelling solver, with a trust region for starts that are nearly solutions."""
    solver = traveller(options.solver)
    return replace(solver, initial_radius=RADIUS) if isinstance(solver, SQP) else solver


def quick(options: DesignOptions) -> Solver:
    """Return the solver for the way: it stops early, at success and at failure."""
    solver = warm(options)
    if not isinstance(solver, SQP):
        return solver
    most = min(solver.max_iterations, PATIENCE)
    return replace(solver, tolerance=max(NEARLY, solver.tolerance), max_iterations=most)


def _footing(
    setting: Setting,
    problem: WalkProblem,
    solution: Solution,
    seconds: float,
    axes: Sequence[tuple[str, float]],
    origin: str,
) -> Footing:
    began = time.process_time()
    slopes = tuple(_slope(setting, problem, solution, axis) for axis in axes)
    return Footing(
        x=solution.x,
        cost=solution.cost,
        active=pressures(problem, solution.multipliers),
        slopes=slopes,
        iterations=solution.iterations,
        evaluations=solution.evaluations,
        seconds=seconds + time.process_time() - began,
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
            moved = WalkProblem(other.robot.build(), other.task, problem.grid)
            return (_lagrangian(moved, problem, solution) - solution.cost) / nudge
        except (InputError, EvaluationError):
            continue
    return None


def _nudged(setting: Setting, name: str, value: float) -> Setting:
    changes = tuple((k, value if k == name else v) for k, v in setting.robot.changes)
    robot: RobotSource = replace(setting.robot, changes=changes)
    return Setting(robot, with_values(setting.task, [(name, value)]))


def _lagrangian(moved: WalkProblem, problem: WalkProblem, solution: Solution) -> float:
    values, y = moved.values(solution.x), solution.multipliers
    limits: Array = np.where(y > 0.0, moved.rows.upper, moved.rows.lower)
    pressed = np.flatnonzero(y)
    excess = values.rows[pressed] - limits[pressed]
    return float(values.cost + y[pressed] @ excess / problem.cost_scale)
