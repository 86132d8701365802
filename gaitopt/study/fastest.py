"""The fastest walk of a robot: from gait to faster gait until none is left."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from gaitopt.design.certificate import WorstRow
from gaitopt.design.design import Design, design
from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError, NoGaitFoundError, UnreachableError
from gaitopt.gait.task import Task
from gaitopt.robot.model import Robot
from gaitopt.solvers import CertifiedSQP, Solver

FIRST_STRIDE = 0.2  # of the speed reached, by which the next try is faster
RESOLUTION = 0.01  # m/s
DIGITS = 3  # of the speeds tried
PATIENCE = 100  # iterations of a try; a neighbour's walk needs a tenth of them
AT_LIMIT = 1e-3  # scaled margin of a row that is at its limit

OnTry = Callable[[float, "Design | None"], None]


@dataclass(frozen=True)
class Fastest:
    """The fastest walk that was found.

    Attributes:
        design: the gait, designed as any other.
        refused: the next speed tried, at which there was none [m/s].
        binding: the constraints at their limits in that gait, in words.
    """

    design: Design
    refused: float
    binding: tuple[str, ...]

    @property
    def speed(self) -> float:
        """Of the gait [m/s]."""
        return self.design.problem.task.speed


def fastest(
    robot: Robot,
    task_at: Callable[[float], Task],
    speed: float,
    options: DesignOptions | None = None,
    *,
    resolution: float = RESOLUTION,
    on_try: OnTry | None = None,
) -> Fastest:
    """Return the fastest walk of a robot, to a resolution.

    Each gait starts from the one before, or cold where that leads nowhere; when there is none, the
    stride in speed is halved. What limits a local search limits this one too: a faster walk of
    another kind may exist.

    Args:
        robot: the biped.
        task_at: the task at a speed; the step duration may follow from it.
        speed: to begin with [m/s].
        options: solver and refinement.
        resolution: [m/s].
        on_try: told every speed, and the design or None.

    Raises:
        InputError: the resolution is not above 0.
        NoGaitFoundError: there is no gait at the speed to begin with.
        UnreachableError: its step is longer than the legs.
    """
    if not resolution > 0.0:
        raise InputError(f"the resolution is {resolution} m/s; it must be above 0")
    tell = on_try or (lambda speed, found: None)
    best = design(robot, task_at(speed), options)
    tell(speed, best)
    stride, refused = FIRST_STRIDE * speed, math.inf
    while stride >= resolution:
        speed = round(best.problem.task.speed + stride, DIGITS)
        if speed < refused:
            found = _try(robot, task_at(speed), options, best)
            tell(speed, found)
            best, refused = (best, speed) if found is None else (found, refused)
        if speed >= refused:
            stride /= 2.0
    return Fastest(best, refused, binding(best))


def binding(found: Design) -> tuple[str, ...]:
    """Return the inequality constraints that are at their limits, in words, one per family."""
    rows = found.certificate.families
    return tuple(row.sentence for row in rows if _at_limit(row) and row.family not in _EQUALITIES)


_EQUALITIES = ("walking speed", "closure")


def _at_limit(row: WorstRow) -> bool:
    return row.margin <= AT_LIMIT


def _impatient(solver: Solver) -> Solver:
    """Return the default solver with fewer iterations, any other as it is."""
    if not isinstance(solver, CertifiedSQP):
        return solver
    travel = solver.travel
    short = replace(travel, max_iterations=min(travel.max_iterations, PATIENCE))
    return replace(solver, travel=short)


def _try(robot: Robot, task: Task, options: DesignOptions | None, best: Design) -> Design | None:
    """Design from a slower gait, then cold; a gait that is not certified does not count."""
    options = options or DesignOptions()
    cold = replace(options, solver=_impatient(options.solver), diagnose=False)
    for quick, start in ((replace(cold, approach="direct"), best.solution.x), (cold, None)):
        try:
            found = design(robot, task, quick, start=start)
        except (NoGaitFoundError, UnreachableError):
            continue
        if found.certificate.certified or not quick.refine:
            return found
    return None
