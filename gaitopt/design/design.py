"""The one question gaitopt answers: how does this robot walk at this speed for the least effort?

Where solvers find no walk, a diagnosis searches on; it finds one, or the reason why there is none.
Several solvers can be compared by one walk: what each found, judged alike, and how it got there.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import asdict, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from gaitopt.design.certificate import on_fine_grid, worst_rows
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import (
    ROUND,
    Design,
    attempt,
    complete,
    gone_on,
    is_walk,
    parameters_of,
)
from gaitopt.design.refinement import quadratic, refine, with_work
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
from gaitopt.nlp import (
    Array,
    Solution,
    Start,
    Status,
    Stop,
    kkt_residual,
    never,
    stopping,
)
from gaitopt.settings import checked_arguments
from gaitopt.solvers import Solver, solver_by_name
from gaitopt.solvers.multipliers import least_squares_multipliers

if TYPE_CHECKING:
    from gaitopt.design.diagnosis import Diagnosis


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
    newton, options = quadratic(search.options.solver.first_stage), search.options
    # Where both feet take an impact, the walk is sought from another, which must be a walk itself.
    to_its_end = multipliers is not None or problem.schedule.striking
    if to_its_end or newton is None or options.differences != "none" or not options.refine:
        return complete(problem, searched(problem, search, x, multipliers), search)
    # Near the walk refinement arrives sooner than the search; else the search goes on.
    solution = attempt(problem, search.changed(solver=replace(newton, early=True)), x)
    if solution.status is Status.OPTIMAL:
        fine = on_fine_grid(problem)
        finer, found = refine(problem, solution, newton.limited(ROUND), search, fine=fine)
        if finer is not problem:
            early = complete(finer, found, search, fine)
            if early.certificate.certified or search.stop():
                return early
        again = attempt(problem, search, solution.x, solution.multipliers)
        if again.status is not Status.OPTIMAL:  # begun anew it went astray
            again = with_work(attempt(problem, search, x), again)
        solution = with_work(again, solution)
    if not is_walk(solution):
        solution = walk_after_diagnosis(problem, [solution], search)
    return complete(problem, solution, search)


def checked_start(problem: WalkProblem, start: Array | Gait | None) -> Array:
    """Return a copy of a first guess of the parameters, shape (P,), or the parameters of a gait.

    Without one, the usual guess.

    Raises:
        UnreachableError: the step asked for is longer than the legs.
        InputError: it has another shape, or entries that are not finite numbers; the gait moves
            other joints or has another number of postures.
    """
    if start is None:
        return first_guess(problem)
    if isinstance(start, Gait):
        x = parameters_of(start, problem)
    else:
        x = problem.checked(start, "the first guess")
    if not np.all(np.isfinite(x)):
        at = problem.layout.names[int(np.argmin(np.isfinite(x)))]
        raise InputError(f"the first guess has no finite value for {at}; give {x.size}")
    try:
        problem.whole(x)
        problem.check_own(x)
    except UnreachableError:
        first_guess(problem)  # says what is held out of reach, if that is why
    except EvaluationError:
        pass  # a solver says where there is no walk
    return x


def _guess(problem: WalkProblem, search: Search) -> Array:
    """Return the first guess (P,), or the walk that a diagnosis finds where there is none."""
    try:
        return first_guess(problem)
    except UnreachableError as error:
        diagnosis = _diagnosis(problem, [], search)
        if diagnosis is None or diagnosis.gait is None:
            raise UnreachableError(str(error), diagnosis) from error
        return diagnosis.gait


def searched(
    problem: WalkProblem, search: Search, x: Array, multipliers: Array | None = None
) -> Solution:
    """Solve from x (P,), once more from the walk that a diagnosis finds; raise if none is."""
    solution = attempt(problem, search, x, multipliers)
    if is_walk(solution):
        return solution
    return walk_after_diagnosis(problem, [solution], search)


def walk_after_diagnosis(
    problem: WalkProblem, tried: Sequence[Solution], search: Search
) -> Solution:
    """Return the walk that a diagnosis leads to where solvers found none; raise if there is none.

    Args:
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

        second = attempt(problem, following(search), diagnosis.gait)
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
        return diagnose(problem, tried, search)
    except UnreachableError:
        return None


def _with_another_solver(problem: WalkProblem, diagnosis: Diagnosis, search: Search) -> Diagnosis:
    """Return the diagnosis of a walk that exists with what finds it, if anything does."""
    from gaitopt.design.diagnosis import Suggestion, followed, following

    usual = following(search.quiet.changed(solver=DesignOptions().solver, differences="none"))
    x = diagnosis.gait
    found = None if x is None else followed(problem.robot, problem.task, x, usual)
    if x is None or found is None:
        return diagnosis
    words = "the default solver, started from the walk that the diagnosis found,"
    told = Suggestion("", words, 0.0, 0.0, "", problem.robot, problem.task, usual.options, found)
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


COMPARED = ("sqp", "slsqp", "ipopt")


@checked_arguments
def compare_solvers(
    robot: Robot,
    task: Task | None = None,
    solvers: Collection[str | Solver] = COMPARED,
    *,
    start: Array | Gait | None = None,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> tuple[Solution, ...]:
    """Solve one walk at its samples by several solvers from the same start.

    Returns:
        Their answers, judged alike: multipliers are those of least squares, and optimality and
        violation those of the point with them, so that no solver's own word counts; cost,
        optimality and violation are nan where a solver could not begin.

    Args:
        task: by default the preset `standard`.
        solvers: names of `gaitopt.solvers.SOLVERS`, or solvers with options.
        start: parameters to begin with, shape (P,), or those of a gait; by default `first_guess`.
        on_progress: makes the progress callback of a walk.
        stop: asked at every iteration; where it says True, the run ends and no other begins.

    Raises:
        InputError: no solver is named, one is not known, or the start has another shape than the
            parameters.
        MissingExtraError: a solver's package is not installed.
        UnreachableError: the step asked for is longer than the legs.
    """
    chosen = [solver_by_name(one) if isinstance(one, str) else one for one in solvers]
    if not chosen:
        raise InputError("no solver is named; give one or more, as sqp,slsqp,ipopt")
    problem = WalkProblem(robot, task or preset_task(robot=robot))
    x = checked_start(problem, start)
    runs = []
    for solver in chosen:
        callback = None if on_progress is None else on_progress(problem)
        runs.append(_judged(problem, solver.solve(problem, Start(x), callback, stopping(stop))))
        if stop():
            break
    return tuple(runs)


def _judged(problem: WalkProblem, solution: Solution) -> Solution:
    try:
        point = problem.point(solution.x)
    except EvaluationError:
        return replace(solution, optimality=np.nan, violation=np.nan)
    rows, bounds = least_squares_multipliers(problem, point)
    residual = kkt_residual(problem, point, rows, bounds)
    return replace(
        solution, multipliers=rows, bound_multipliers=bounds,
        optimality=residual.optimality, violation=residual.feasibility,
    )  # fmt: skip


def run_record(run: Solution) -> dict[str, object]:
    """Return a solver's run as JSON-able data; None for numbers that are not finite."""
    apart = ("x", "multipliers", "bound_multipliers", "hessian", "history")
    told = {one.name: getattr(run, one.name) for one in fields(run) if one.name not in apart}
    history = [asdict(one) for one in run.history]
    for numbers in (told, *history):
        for name, value in numbers.items():
            if isinstance(value, float) and not np.isfinite(value):
                numbers[name] = None
    return {**told, "status": run.status.name.lower(), "history": history}
