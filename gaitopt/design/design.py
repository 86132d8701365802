"""The one question gaitopt answers: how does this robot walk at this speed for the least effort?"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.design.certificate import Certificate, certify, on_fine_grid
from gaitopt.design.options import DesignOptions
from gaitopt.design.refine import refine
from gaitopt.design.runtime import small_matrices
from gaitopt.design.search import guess, search, traveller
from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.nlp import Array, ProgressCallback, Solution
from gaitopt.robot.model import Robot
from gaitopt.solvers import CertifiedSQP
from gaitopt.version import __version__


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


def design(
    robot: Robot,
    task: Task | None = None,
    options: DesignOptions | None = None,
    *,
    start: Array | None = None,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None = None,
) -> Design:
    """Design the optimal gait of a robot for a task.

    Args:
        robot: the biped.
        task: speed, duration, margins; by default 1 m/s with steps of 0.4 s.
        options: solver, refinement, kind of derivatives.
        start: first guess of the parameters, shape (P,); by default `first_guess`.
        on_progress: makes the progress callback of a walk (it can name the walk's rows).

    Raises:
        InputError: the start has another shape than the parameters, or is not finite.
        NoGaitFoundError: no feasible gait was found; the message says what stands in the way, and
            `diagnosis` why and what would help.
        UnreachableError: the step asked for is longer than the legs; with a `diagnosis` too.
    """
    task, options = task or Task(), options or DesignOptions()
    with small_matrices():
        return _design(robot, task, options, start, on_progress)


def _design(
    robot: Robot,
    task: Task,
    options: DesignOptions,
    start: Array | None,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None,
) -> Design:
    problem = WalkProblem(robot, task)
    x = guess(problem, options) if start is None else checked_start(problem, start)
    callback = None if on_progress is None else on_progress(problem)
    solution = search(problem, options, x, callback)
    fine = on_fine_grid(problem)
    if options.refine:
        solver = traveller(options.solver)
        problem, solution = refine(problem, solution, solver, on_progress, fine=fine)
    if isinstance(options.solver, CertifiedSQP):
        callback = None if on_progress is None else on_progress(problem)
        solution = options.solver.confirm(problem, solution, callback)
    return finished(problem, solution, options.refine, fine)


def finished(
    problem: WalkProblem, solution: Solution, refined: bool, fine: WalkProblem | None = None
) -> Design:
    """Return a solution as a design: with its gait and its proof.

    Args:
        problem: the walk on its final grid.
        solution: of it.
        refined: whether it was meant to hold between the samples too.
        fine: the walk on the certificate's grid, if it is at hand.
    """
    certificate = certify(problem, solution.x, fine)
    meta = {
        "solver": solution_record(solution),
        "status": solution.status.value,
        "refined": refined,
        "certificate": certificate.record(),
        "versions": versions(),
    }
    return Design(gait_at(problem, solution.x, meta), certificate, solution, problem)


def checked_start(problem: WalkProblem, start: Array) -> Array:
    """Return a copy of a first guess of the parameters, shape (P,).

    Raises:
        InputError: it has another shape, or entries that are not finite numbers.
    """
    wanted = (
        f"give {problem.layout.size} finite numbers, in the order of "
        "WalkProblem(robot, task).layout.names"
    )
    try:
        x = np.array(start, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"the first guess is no array of numbers; {wanted}") from error
    if x.shape != (problem.layout.size,):
        raise InputError(f"the first guess has shape {x.shape}; {wanted}")
    if not np.all(np.isfinite(x)):
        at = problem.layout.names[int(np.argmin(np.isfinite(x)))]
        raise InputError(f"the first guess has no finite value for {at}; {wanted}")
    return x


def solution_record(solution: Solution) -> dict[str, object]:
    """Return how a solution was found, JSON-able."""
    return {
        "name": solution.solver,
        "status": solution.status.name.lower(),
        "violation": solution.violation,
        "optimality": solution.optimality,
        "iterations": solution.iterations,
        "evaluations": solution.evaluations,
        "hessians": solution.hessians,
        "seconds": solution.seconds,
    }


def versions() -> dict[str, str]:
    """Return the versions that a result depends on."""
    return {
        "gaitopt": __version__,
        "pinocchio": str(pin.__version__),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }
