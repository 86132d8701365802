"""Turning about the toe where it pays: its best beginning, or the flat walk if that is cheaper."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from gaitopt.design.design import checked_start
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design, attempt, is_walk
from gaitopt.errors import GaitoptError, StoppedError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import EARLIEST, LATEST, SOONEST, Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Solution, Status, Stop, never

STEPS = (0.08, 0.04, 0.02)
"""Shares of the step by which the beginning is moved, one after the other: at 1 m/s the cost of the
thirteen-link biped changes by 1 to 2 % from one beginning to another 0.02 later."""
SLOWER = 0.75
"""Of the speed: a walk at it leads to another optimum than the first guess, often a cheaper one."""
_DIGITS = 3  # of a beginning

Designer = Callable[[Task, Array | None, DesignOptions], Design]
"""Designs the gait of a task from a first guess, or from the usual one."""


@dataclass(frozen=True)
class ToeOffChoice:
    """A walk whose stance foot turns about its toe, or stands flat, whichever is cheaper.

    Attributes:
        design: the walk that is kept; what was compared is in its gait's `meta["toe_off"]`.
        sentence: what was compared, for people.
    """

    design: Design
    sentence: str


def searches_toe_off(task: Task, options: DesignOptions | None) -> bool:
    """Return whether the best beginning of a turn about the toe is asked for."""
    return task.toe_off is not None and (options is None or options.toe_begin == "best")


def best_toe_off(
    robot: Robot,
    task: Task,
    options: DesignOptions,
    designed: Designer,
    start: Array | Gait | None = None,
    stop: Stop = never,
) -> ToeOffChoice:
    """Design the flat walk and the one that turns about its toe; keep the cheaper.

    Args:
        robot, task: with `toe_off`, from which the search for the best beginning sets out.
        options: how walks are searched for.
        designed: designs the gait of a task, refined and certified.
        start: first guess of the parameters of the task, shape (P,), or a gait; by default
            `first_guess`.
        stop: asked at every iteration; where it says True, the best walk until then is returned,
            with the status INTERRUPTED.

    Raises:
        NoGaitFoundError: neither of the two was found; with the diagnosis of the flat one.
        UnreachableError: the step asked for is longer than the legs.
        StoppedError: `stop` said so before there was a walk.
    """
    flat_task, quiet = replace(task, toe_off=None), replace(options, diagnose=False)
    problem = WalkProblem(robot, task)
    start = None if start is None else checked_start(problem, start)
    flat_start = None if start is None else _without_turn(problem, flat_task, start)
    flat = turning = None
    try:
        flat = designed(flat_task, flat_start, quiet)
    except StoppedError:
        raise
    except GaitoptError:
        pass  # there may be one that turns
    if flat is None or flat.solution.status is not Status.INTERRUPTED:
        try:
            for begin, x in best_beginnings(robot, task, options, start, stop):
                found = designed(replace(task, toe_off=begin), x, quiet)
                turning = found if turning is None else min(turning, found, key=_rank)
                if found.proven or stop():
                    break
        except StoppedError:
            if flat is None:
                raise
        except GaitoptError:
            pass  # the flat one may do
    walks = [one for one in (flat, turning) if one is not None]
    if not walks:
        return ToeOffChoice(designed(flat_task, flat_start, options), "")  # tells why
    kept = min(walks, key=_rank)
    if stop():
        kept = replace(kept, solution=replace(kept.solution, status=Status.INTERRUPTED))
    record = {
        "asked": task.toe_off,
        "begin": None if turning is None else turning.problem.task.toe_off,
        "cost": None if turning is None else turning.solution.cost,
        "flat_cost": None if flat is None else flat.solution.cost,
        "kept": kept.problem.task.toe_off is not None,
    }
    gait = replace(kept.gait, meta={**kept.gait.meta, "toe_off": record})
    return ToeOffChoice(replace(kept, gait=gait), _sentence(flat, turning, kept))


def _without_turn(problem: WalkProblem, flat: Task, x: Array) -> Array:
    """Return the parameters that a walk on flat feet has too."""
    at = {name: k for k, name in enumerate(problem.layout.names)}
    names = WalkProblem(problem.robot, flat).layout.names
    return x[[at[name] for name in names]]


def best_beginnings(
    robot: Robot,
    task: Task,
    options: DesignOptions,
    start: Array | None = None,
    stop: Stop = never,
) -> list[tuple[float, Array | None]]:
    """Return shares of the step at which the turn costs least, each with its walk; best first.

    The beginning sets instants and knots of the program and is no parameter of it. It is searched
    at the samples, by steps that get shorter, each walk from the optimum beside it: once from the
    first guess and once from a slower walk, which lead to different optima. Without a walk at the
    share that the task asks for, that share and the start are returned.

    Args:
        robot, task, options, start, stop: as of `best_toe_off`.

    Raises:
        UnreachableError: the step asked for is longer than the legs.
    """
    asked = EARLIEST if task.toe_off is None else task.toe_off
    near = replace(options, approach="direct", differences="none")
    problem = WalkProblem(robot, replace(task, toe_off=asked))
    walks = filter(is_walk, _first_walks(problem, options, near, start, stop))
    found = sorted((_moved(problem, walk, near, stop) for walk in walks), key=lambda f: f[1].cost)
    return [(begin, walk.x) for begin, walk in found] or [(asked, start)]


def _moved(
    problem: WalkProblem, walk: Solution, options: DesignOptions, stop: Stop
) -> tuple[float, Solution]:
    """Move the beginning of a walk's turn as long as its cost falls."""
    task = problem.task
    assert task.toe_off is not None
    begin, tried = task.toe_off, {task.toe_off: walk}
    for way in (sign * step for step in STEPS for sign in (1.0, -1.0)):
        while not stop():
            trial = round(begin + way, _DIGITS)
            if trial in tried or not EARLIEST <= trial <= _latest(task):
                break
            moved = WalkProblem(problem.robot, replace(task, toe_off=trial))
            tried[trial] = attempt(moved, options, tried[begin].x, None, stop)
            if not (is_walk(tried[trial]) and tried[trial].cost < tried[begin].cost):
                break
            begin = trial
    return begin, tried[begin]


def _latest(task: Task) -> float:
    """Return the share of the step from which on the foot may turn at the latest."""
    if task.double_support is None:
        return LATEST
    return min(LATEST, 1.0 - task.double_support / task.duration - SOONEST)


def _first_walks(
    problem: WalkProblem,
    options: DesignOptions,
    near: DesignOptions,
    start: Array | None,
    stop: Stop,
) -> Iterator[Solution]:
    """Yield walks from the start, or from the usual guess and from a slower walk."""
    x = first_guess(problem) if start is None else start
    yield attempt(problem, options, x, None, stop)
    if start is not None or stop() or problem.task.in_place:
        return
    slower = WalkProblem(problem.robot, problem.task.slower(SLOWER))
    found = attempt(slower, options, first_guess(slower), None, stop)
    if is_walk(found):
        yield attempt(problem, near, found.x, None, stop)


def _rank(found: Design) -> tuple[bool, float]:
    """Proven walks before others, then by cost."""
    return not found.proven, found.solution.cost


def _sentence(flat: Design | None, turning: Design | None, kept: Design) -> str:
    if turning is None:
        return "no walk was found whose foot turns about its toe; the flat walk is kept"
    share, unit = turning.problem.task.toe_off, kept.problem.task.cost_unit
    told = f"turning about the toe from {share:.3g} of the step costs {turning.solution.cost:.6g}"
    if flat is None:
        return f"{told} {unit}; no walk was found whose foot stands flat"
    doubt = "" if flat.proven == turning.proven else "; only that one is proven"
    which = "the flat walk" if kept.problem.task.toe_off is None else "the turn"
    return f"{told}, standing flat {flat.solution.cost:.6g} {unit}; {which} is kept{doubt}"
