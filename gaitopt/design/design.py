"""The one question gaitopt answers: how does this robot walk at this speed for the least effort?

Where solvers find no walk, a diagnosis searches on; it finds one, or the reason why there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gaitopt.design.certificate import worst_rows
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import (
    Design,
    Search,
    attempt,
    complete,
    finished,
    gone_on,
    is_walk,
    parameters_of,
    versions,
)
from gaitopt.errors import (
    EvaluationError,
    InputError,
    NoGaitFoundError,
    StoppedError,
    UnreachableError,
)
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import MakeProgress, WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Solution, Status, Stop, never

if TYPE_CHECKING:  # most designs need no diagnosis: it is loaded when one does
    from gaitopt.design.diagnosis import Diagnosis

__all__ = ["Design", "checked_start", "design", "finished", "versions"]


def design(
    robot: Robot,
    task: Task | None = None,
    options: DesignOptions | None = None,
    *,
    start: Array | Gait | None = None,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> Design:
    """Design the optimal gait of a robot for a task.

    Args:
        robot, task, options, start, on_progress, stop: as of `design_gait`, with one start.

    Raises:
        InputError: the start has another shape than the parameters, or is not finite.
        NoGaitFoundError: no feasible gait was found; the message says what stands in the way, and
            `diagnosis` why and what would help.
        UnreachableError: the step asked for is longer than the legs; with a `diagnosis` too.
        StoppedError: `stop` said so before there was a walk.
    """
    problem, multipliers = WalkProblem(robot, task or preset_task(robot=robot)), None
    search = Search(options or DesignOptions(), on_progress, stop)
    x = _guess(problem, search) if start is None else checked_start(problem, start)
    if isinstance(start, Gait):
        problem, multipliers = gone_on(problem, start)
    solution = attempt(problem, search, x, multipliers)
    if not is_walk(solution):
        solution = walk_after_diagnosis(problem, [solution], search)
    return complete(problem, solution, search)


def checked_start(problem: WalkProblem, start: Array | Gait) -> Array:
    """Return a copy of a first guess of the parameters, shape (P,), or the parameters of a gait.

    Raises:
        InputError: it has another shape, or entries that are not finite numbers; the gait moves
            other joints or has another number of postures.
    """
    if isinstance(start, Gait):
        return parameters_of(start, problem)
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


def _guess(problem: WalkProblem, search: Search) -> Array:
    """Return the first guess (P,), or the walk that a diagnosis finds where there is none.

    Raises:
        UnreachableError: there is none either; with the diagnosis.
    """
    try:
        return first_guess(problem)
    except UnreachableError as error:
        diagnosis = _diagnosis(problem, [], search)
        if diagnosis is None or diagnosis.gait is None:
            raise UnreachableError(str(error), diagnosis) from error
        return diagnosis.gait


def walk_after_diagnosis(
    problem: WalkProblem, tried: Sequence[Solution], search: Search
) -> Solution:
    """Return the walk that a diagnosis leads to where solvers found none; raise if there is none.

    Args:
        problem: the walk.
        tried: what solvers made of it, none of them a walk.
        search: how it was searched for; stopped, it ends the diagnosis.

    Raises:
        NoGaitFoundError: with the diagnosis.
        StoppedError: a solver or the diagnosis was stopped.
    """
    solution = min(tried, key=lambda s: s.violation if np.isfinite(s.violation) else np.inf)
    if any(one.status is Status.INTERRUPTED for one in tried):
        raise StoppedError(solution)
    diagnosis = _diagnosis(problem, tried, search)
    if diagnosis is not None and diagnosis.gait is not None:
        from gaitopt.design.diagnosis import following

        then = replace(search, options=following(search.options))
        second = attempt(problem, then, diagnosis.gait)
        if is_walk(second):
            return second
        if search.stop():
            raise StoppedError(second)
        diagnosis = _with_another_solver(problem, diagnosis, search)
    raise NoGaitFoundError(_refusal(problem, solution), solution, diagnosis)


def _diagnosis(problem: WalkProblem, tried: Sequence[Solution], search: Search) -> Diagnosis | None:
    """Return a diagnosis, unless it is not wanted or cannot be made."""
    if not search.options.diagnose:
        return None
    from gaitopt.design.diagnosis import diagnose

    try:
        return diagnose(problem, tried, search.options, search.stop)
    except UnreachableError:
        return None


def _with_another_solver(problem: WalkProblem, diagnosis: Diagnosis, search: Search) -> Diagnosis:
    """Return the diagnosis of a walk that exists with what finds it, if anything does."""
    from gaitopt.design.diagnosis import Suggestion, followed, following

    usual = following(replace(search.options, solver=DesignOptions().solver, differences="none"))
    x = diagnosis.gait
    found = None if x is None else followed(problem.robot, problem.task, x, usual, search.stop)
    if x is None or found is None:
        return diagnosis
    words = "the default solver, started from the walk that the diagnosis found,"
    told = Suggestion("", words, 0.0, 0.0, "", problem.robot, problem.task, usual, found)
    return replace(diagnosis, suggestions=(told,))


def _refusal(problem: WalkProblem, solution: Solution) -> str:
    """Say what is wrong with a solution that is not a walk."""
    reason = f"no feasible gait was found ({solution.status.value})"
    try:
        worst = worst_rows(problem, solution.x)[0]
    except EvaluationError as error:
        return f"{reason}; {error}"
    task = problem.task
    return (
        f"{reason} at {task.speed:g} m/s with steps of {task.duration:g} s; the least violation "
        f"leaves {worst.sentence}"
    )
