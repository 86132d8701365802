"""The one question gaitopt answers: how does this robot walk at this speed for the least effort?"""

from __future__ import annotations

import platform
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from gaitopt.design.certificate import Certificate, certify
from gaitopt.design.diagnose import diagnose
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.refine import refine
from gaitopt.design.runtime import small_matrices
from gaitopt.errors import EvaluationError, InputError, NoGaitFoundError, UnreachableError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.nlp import NLP, Array, ProgressCallback, Solution, Start, Status
from gaitopt.robot.model import Robot
from gaitopt.solvers import CertifiedSQP, FiniteDifferenceNLP, Solver, solver_by_name
from gaitopt.version import __version__

FEASIBLE = 1e-6  # scaled violation below which a solution is a gait


DIFFERENCES = ("none", "constraints", "all")


@dataclass(frozen=True)
class DesignOptions:
    """How a gait is searched for.

    Attributes:
        solver: does the work.
        refine: whether constraints must hold between the samples too.
        differences: "none" for exact derivatives; "all" for finite-difference gradients, or
            "constraints" for the paper's mode (exact gradient of the cost alone). Refinement and
            confirmation always have the exact ones.
        diagnose: whether to find out why when there is no gait (some seconds).
    """

    solver: Solver = field(default_factory=lambda: solver_by_name("default"))
    refine: bool = True
    differences: str = "none"
    diagnose: bool = True

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            InputError: an unknown kind of derivatives.
        """
        if self.differences not in DIFFERENCES:
            raise InputError(
                f"differences '{self.differences}' is unknown; choose {', '.join(DIFFERENCES)}"
            )


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
    x = _guess(problem, options) if start is None else _checked_start(problem, start)
    callback = None if on_progress is None else on_progress(problem)
    solution = _walk(problem, options, x, callback)
    if options.refine:
        problem, solution = refine(problem, solution, traveller(options.solver), on_progress)
    if isinstance(options.solver, CertifiedSQP):
        callback = None if on_progress is None else on_progress(problem)
        solution = options.solver.confirm(problem, solution, callback)
    certificate = certify(problem, solution.x)
    meta = {
        "solver": solution_record(solution),
        "status": solution.status.value,
        "refined": options.refine,
        "certificate": certificate.record(),
        "versions": versions(),
    }
    return Design(gait_at(problem, solution.x, meta), certificate, solution, problem)


def _guess(problem: WalkProblem, options: DesignOptions) -> Array:
    """Return the first guess, or the walk that a diagnosis finds where there is none."""
    try:
        return first_guess(problem)
    except UnreachableError as error:
        diagnosis = _diagnosis(problem, None, options)
        if diagnosis is None or diagnosis.gait is None:
            raise UnreachableError(str(error), diagnosis) from error
        return diagnosis.gait


def _walk(
    problem: WalkProblem, options: DesignOptions, x: Array, callback: ProgressCallback | None
) -> Solution:
    """Solve, once more from the walk that a diagnosis finds; raise if there is none."""
    solver, nlp = traveller(options.solver), _derived(problem, options)
    solution = solver.solve(nlp, Start(x), callback)
    if _is_gait(solution):
        return solution
    diagnosis = _diagnosis(problem, solution, options)
    if diagnosis is not None and diagnosis.gait is not None:
        second = solver.solve(nlp, Start(diagnosis.gait), callback)
        if _is_gait(second):
            return second
    raise NoGaitFoundError(_refusal(problem, solution), solution, diagnosis)


def traveller(solver: Solver) -> Solver:
    """Return the solver that goes from a first guess to a gait."""
    return solver.travel if isinstance(solver, CertifiedSQP) else solver


def _diagnosis(
    problem: WalkProblem, solution: Solution | None, options: DesignOptions
) -> Diagnosis | None:
    """Return a diagnosis, unless it is not wanted, cannot be made or is given up by Ctrl-C."""
    interrupted = solution is not None and solution.status is Status.INTERRUPTED
    if interrupted or not options.diagnose:
        return None
    try:
        return diagnose(problem, solution, refined=options.refine)
    except (UnreachableError, KeyboardInterrupt):
        return None


def _checked_start(problem: WalkProblem, start: Array) -> Array:
    x = np.array(start, dtype=np.float64)
    if x.shape != (problem.layout.size,) or not np.all(np.isfinite(x)):
        raise InputError(
            f"the first guess has shape {x.shape}; give {problem.layout.size} finite numbers, "
            "in the order of WalkProblem(robot, task).layout.names"
        )
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


def _derived(problem: WalkProblem, options: DesignOptions) -> NLP:
    if options.differences == "none":
        return problem
    return FiniteDifferenceNLP(problem, cost_gradient_only=options.differences == "constraints")


def _is_gait(solution: Solution) -> bool:
    return bool(np.isfinite(solution.cost)) and solution.violation <= FEASIBLE


def _refusal(problem: WalkProblem, solution: Solution) -> str:
    """Say what is wrong with a solution that is not a walk."""
    reason = f"no feasible gait was found ({solution.status.value})"
    try:
        rows = problem.values(solution.x).rows
    except EvaluationError as error:
        return f"{reason}; {error}"
    worst = np.maximum(problem.rows.lower - rows, rows - problem.rows.upper)
    row = int(np.argmax(worst))
    at = problem.address(row)
    scale = at.family.scale[at.entry]
    limit = (
        problem.rows.lower[row] if rows[row] < problem.rows.lower[row] else problem.rows.upper[row]
    )
    return (
        f"{reason} at {problem.task.speed:g} m/s with steps of {problem.task.duration:g} s; the "
        f"least violation leaves {problem.describe(row)}: {rows[row] * scale:.4g} "
        f"{at.family.unit}, allowed {limit * scale:.4g}"
    )
