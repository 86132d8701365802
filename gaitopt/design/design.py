"""The one question gaitopt answers: how does this robot walk at this speed for the least effort?"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gaitopt.design.complete import Design, complete, finished, versions
from gaitopt.design.options import DesignOptions
from gaitopt.design.search import guess, search
from gaitopt.errors import InputError
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, ProgressCallback, Stop, never

__all__ = ["Design", "checked_start", "design", "finished", "versions"]


def design(
    robot: Robot,
    task: Task | None = None,
    options: DesignOptions | None = None,
    *,
    start: Array | None = None,
    on_progress: Callable[[WalkProblem], ProgressCallback] | None = None,
    stop: Stop = never,
) -> Design:
    """Design the optimal gait of a robot for a task.

    Args:
        robot: the biped.
        task: speed, duration, margins; by default 1 m/s with steps of 0.4 s.
        options: solver, refinement, kind of derivatives.
        start: first guess of the parameters, shape (P,); by default `first_guess`.
        on_progress: makes the progress callback of a walk (it can name the walk's rows).
        stop: asked at every iteration; where it says True, the best walk until then is returned,
            with the status INTERRUPTED.

    Raises:
        InputError: the start has another shape than the parameters, or is not finite.
        NoGaitFoundError: no feasible gait was found; the message says what stands in the way, and
            `diagnosis` why and what would help.
        UnreachableError: the step asked for is longer than the legs; with a `diagnosis` too.
        StoppedError: `stop` said so before there was a walk.
    """
    task, options = task or Task(), options or DesignOptions()
    problem = WalkProblem(robot, task)
    x = guess(problem, options, stop) if start is None else checked_start(problem, start)
    callback = None if on_progress is None else on_progress(problem)
    solution = search(problem, options, x, callback, stop)
    return complete(problem, solution, options, on_progress, stop)


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
