"""Times of phases where they cost least: where feet turn, or flat feet if those are cheaper.

The beginning of a turn about the toe, the end of the roll after a heel strike and the duration of a
double support set instants and knots of the program and are no parameters of it. They are searched
at the samples, by moves that get shorter, each walk from the optimum beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from gaitopt.dataclass import dataclass
from gaitopt.design.design import checked_start
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import Design, attempt, is_walk, landed_softly, same_optimum
from gaitopt.errors import GaitoptError, InputError, StoppedError
from gaitopt.gait.initial_guess import first_guess, retimed
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Solution, Status, Stop, never

STEPS = (0.08, 0.04, 0.02)
"""Shares of the step by which a turn's beginning or end is moved, one after the other: at 1 m/s the
cost of the thirteen-link biped changes by 1 to 2 % from one beginning to another 0.02 later."""
FACTORS = (2.0, 1.4, 1.2)
"""By which the duration of a double support is multiplied or divided: it may be 1 ms or 100."""
SLOWER = 0.75
"""Of the speed: a walk at it leads to another optimum than the first guess, often a cheaper one
(measured). The second of many starts comes from there too."""
TURNS = ("toe_off", "heel_strike")
"""Times of phases in which a foot turns; without them it stands flat."""
_DIGITS = 4  # of a share, and of a time in seconds

Designer = Callable[[Task, Array | None, DesignOptions], Design]
"""Designs the gait of a task from a first guess, or from the usual one."""


@dataclass(frozen=True)
class TimesChoice:
    """A walk at its best times, or one on flat feet, whichever is cheaper.

    Attributes:
        design: the walk that is kept; what was compared is in its gait's `meta["phase_times"]`.
        sentence: what was compared, for people.
    """

    design: Design
    sentence: str


def searched_times(task: Task, options: DesignOptions | None) -> tuple[str, ...]:
    """Return which times of phases of a task are to be searched, by the names of its fields."""
    options = Search(options or DesignOptions()).options
    asked = {
        "toe_off": options.toe_begin,
        "heel_strike": options.phase_times,
        "double_support": options.phase_times,
    }
    return tuple(
        name for name, how in asked.items() if how == "best" and getattr(task, name) is not None
    )


def best_times(
    robot: Robot,
    task: Task,
    options: DesignOptions,
    designed: Designer,
    start: Array | Gait | None = None,
    stop: Stop = never,
) -> TimesChoice:
    """Design a walk at its best times of phases; where a foot turns the flat one too.

    The cheaper of both is kept. Flat feet are the end of turning less and less; a double support
    has its own end within its range, the landing at zero speed.

    Args:
        robot, task: with times of phases, from which the search sets out.
        options: how walks are searched for, and which times.
        designed: designs the gait of a task, refined and certified.
        start: first guess of the parameters of the task, shape (P,), or a gait; by default
            `first_guess`.
        stop: asked at every iteration; where it says True, the best walk until then is returned,
            with the status INTERRUPTED.

    Raises:
        NoGaitFoundError: none was found; with the diagnosis of the flat one.
        UnreachableError: the step asked for is longer than the legs.
        StoppedError: `stop` said so before there was a walk.
    """
    names, quiet = searched_times(task, options), replace(options, diagnose=False)
    turns = [name for name in names if name in TURNS]
    flat_task = flat_of(task, turns)
    problem = WalkProblem(robot, task)
    start = None if start is None else checked_start(problem, start)
    flat_start = None if start is None else _without_turns(problem, flat_task, start)
    flat = timed = None
    if turns:
        try:
            flat = designed(flat_task, flat_start, quiet)
        except StoppedError:
            raise
        except GaitoptError:
            pass  # there may be one that turns
    if flat is None or flat.solution.status is not Status.INTERRUPTED:
        try:
            for timing, x in walks_at_best_times(robot, task, options, start, stop):
                found = designed(timing, x, quiet)
                timed = found if timed is None or found.rank < timed.rank else timed
                if found.proven or stop():
                    break
        except StoppedError:
            if flat is None:
                raise
        except GaitoptError:
            pass  # the flat one may do
    walks = [one for one in (flat, timed) if one is not None]
    if not walks:
        return TimesChoice(designed(flat_task, flat_start, options), "")  # tells why
    kept = min(walks, key=lambda one: one.rank)
    if stop():
        kept = replace(kept, solution=replace(kept.solution, status=Status.INTERRUPTED))
    record = {
        "asked": {name: getattr(task, name) for name in names},
        "found": None if timed is None else times_of(timed.problem.task, names),
        "cost": None if timed is None else timed.solution.cost,
        "flat_cost": None if flat is None else flat.solution.cost,
        "kept": kept is not flat,
    }
    gait = replace(kept.gait, meta={**kept.gait.meta, "phase_times": record})
    return TimesChoice(replace(kept, gait=gait), _sentence(names, flat, timed, kept))


def flat_of(task: Task, turns: list[str]) -> Task:
    """Return the task of a walk whose feet do not turn so."""
    changes: dict[str, Any] = dict.fromkeys(turns)
    if "heel_strike" in turns:
        changes["foot_flat"] = "gentle"
    return replace(task, **changes)


def times_of(task: Task, names: tuple[str, ...]) -> dict[str, float]:
    """Return times of phases of a task."""
    return {name: getattr(task, name) for name in names}


def _without_turns(problem: WalkProblem, flat: Task, x: Array) -> Array:
    """Return the parameters that a walk on flat feet has too."""
    at = {name: k for k, name in enumerate(problem.layout.names)}
    names = WalkProblem(problem.robot, flat).layout.names
    return x[[at[name] for name in names]]


def walks_at_best_times(
    robot: Robot, task: Task, options: DesignOptions, start: Array | None = None, stop: Stop = never
) -> list[tuple[Task, Array | None]]:
    """Return tasks with the times of phases that cost least, each with its walk (P,); best first.

    Once from the first guess and once from a slower walk, which lead to different optima. Without a
    walk at the times that the task asks for, that task and the start are returned.

    Raises:
        UnreachableError: the step asked for is longer than the legs.
    """
    search = Search(options, stop=stop)
    near = search.changed(approach="direct", differences="none")
    problem, names = WalkProblem(robot, task), searched_times(task, options)
    walks: list[Solution] = []
    for walk in filter(is_walk, _first_walks(problem, search, near, start)):
        known = ((other.cost, other.x) for other in walks)
        # moves from one and the same lead to one and the same
        if not any(same_optimum(problem, (walk.cost, walk.x), one) for one in known):
            walks.append(walk)
    found = [_moved(problem, walk, names, near) for walk in walks]
    found.sort(key=lambda f: f[1].cost)
    return [(timing, walk.x) for timing, walk in found] or [(task, start)]


def _moved(
    problem: WalkProblem, walk: Solution, names: tuple[str, ...], search: Search
) -> tuple[Task, Solution]:
    """Move the times of a walk one after the other, as long as its cost falls."""
    # a walk whose impulse vanishes stays one that lands at zero speed: each other crawls
    problem, walk = landed_softly(problem, walk, search)
    task, robot = problem.task, problem.robot
    tried = {tuple(times_of(task, names).values()): walk}
    for name, way in _ways(names):
        while not search.stop():
            trial = _after(task, name, way)
            key = () if trial is None else tuple(times_of(trial, names).values())
            if trial is None or key in tried:
                break
            moved = WalkProblem(robot, trial)
            found = attempt(moved, search, retimed(walk.x, WalkProblem(robot, task), moved))
            if not is_walk(found):  # a long move may find one from the same postures alone
                found = attempt(moved, search, walk.x)
            tried[key] = found
            if not (is_walk(found) and found.cost < walk.cost):
                break
            task, walk = trial, found
    return task, walk


def _ways(names: tuple[str, ...]) -> Iterator[tuple[str, float]]:
    """Yield moves, the long ones first: of shares what is added, of a duration its factor."""
    for step, factor in zip(STEPS, FACTORS, strict=True):
        for name in names:
            both = (factor, 1.0 / factor) if name == "double_support" else (step, -step)
            yield from ((name, way) for way in both)


def _after(task: Task, name: str, way: float) -> Task | None:
    """Return the task after a move; None where there is no such walk."""
    value = getattr(task, name)
    value = value * way if name == "double_support" else value + way
    try:
        return replace(task, **{name: round(value, _DIGITS)})
    except InputError:
        return None


def _first_walks(
    problem: WalkProblem, search: Search, near: Search, start: Array | None
) -> Iterator[Solution]:
    """Yield walks from the start, or from the usual guess and from a slower walk."""
    x = first_guess(problem) if start is None else start
    yield attempt(problem, search, x)
    if start is not None or search.stop() or problem.task.in_place:
        return
    slower = WalkProblem(problem.robot, problem.task.at_share_of_speed(SLOWER))
    found = attempt(slower, search, first_guess(slower))
    if is_walk(found):
        yield attempt(problem, near, found.x)


_WORDS = {
    "toe_off": "turning about the toe from {:.3g} of the step",
    "heel_strike": "rolling from the heel until {:.3g} of the step",
    "double_support": "standing on both feet for {:.3g} s",
}


def _sentence(
    names: tuple[str, ...], flat: Design | None, timed: Design | None, kept: Design
) -> str:
    if timed is None:
        return "no walk was found whose foot turns so; the flat walk is kept"
    unit, times = kept.problem.task.cost_unit, times_of(timed.problem.task, names)
    words = " and ".join(_WORDS[name].format(value) for name, value in times.items())
    told = f"{words} costs {timed.solution.cost:.6g}"
    if flat is None:
        turns = [name for name in names if name in TURNS]
        return f"{told} {unit}" + ("; no walk was found whose foot stands flat" if turns else "")
    doubt = "" if flat.proven == timed.proven else "; only that one is proven"
    which = "the flat walk" if kept is flat else "the turn"
    return f"{told}, standing flat {flat.solution.cost:.6g} {unit}; {which} is kept{doubt}"
