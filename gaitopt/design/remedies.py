"""Changes that make a walk possible: knobs turned as little as possible, and followed.

The multipliers of the smallest relaxation tell what turning each knob would bring; the most
promising are turned, one at a time, and if none suffices alone, several together. Only what led to
a proven walk when it was followed, as a person would follow it, is suggested.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np

from gaitopt.design.conflict import SEARCHER, Reason, easier_guess, solve_or_stop
from gaitopt.design.early_stopping import Settle
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design, attempt, begins_relaxed, complete, is_walk
from gaitopt.design.relaxation import (
    Knob,
    LimitKnob,
    RelaxedProgram,
    duration_knob,
    limit_knobs,
    step_width_knob,
    usual_value,
)
from gaitopt.errors import EvaluationError, InputError, StoppedError, UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Start, Status, Stop, never
from gaitopt.tolerances import FEASIBLE
from gaitopt.units import digits

KNOBS, ENOUGH = 5, 2
"""Knobs that are tried, the most promising first, and suggestions that are enough."""
WORK, MOST_WORK = 200, 900
"""Evaluations after which no other knob is begun, if one was found that does it and if none was."""
PAIRED, PAIRS_WORK = 3, 400
"""Knobs that are turned in pairs where none suffices alone, and evaluations for that."""
MAIN = 0.25
"""Share of the relaxation from which a family is a main one. Its knob is turned a second time,
wide open from the first guess, where the first did not lead to a walk: what is asked may be so far
from anything that the relaxed walk is no good place to begin."""
LEAST = 0.05
"""Least change worth a suggestion, over the change that matters: smaller ones are made this large.
At the very edge of what can be walked hardly an optimum can be proven."""
OUTWARD = (1.1, 2.5)
"""Multiples of the least change that are tried until a walk is certified, ..."""
PATIENCE = 70
"""Iterations after which a walk that follows a suggestion is given up."""
COARSE = 3.0
"""... each rounded outwards to a power of ten below this part of the change."""

Changes = tuple[tuple[Knob, float], ...]


@dataclass(frozen=True)
class Change:
    """One number changed.

    Attributes:
        knob: field of `Task` or `Margins`, or a property of the robot.
        words: for a person.
        before, after: its value in the task, and the one with which a walk was found.
        unit: of both, empty where there is none.
    """

    knob: str
    words: str
    before: float
    after: float
    unit: str

    @property
    def sentence(self) -> str:
        """In words."""
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.words} ({self.knob}) from {self.before:g} to {digits(self.after)}{unit}"


@dataclass(frozen=True)
class Suggestion:
    """A change that makes the walk possible; it was followed, and led to a proven walk.

    Attributes:
        knob: field of `Task` or `Margins`, or a property of the robot; empty where nothing but
            the way to the walk is changed.
        words: for a person.
        before, after: its value in the task, and the one with which a walk was found.
        unit: of both, empty where there is none.
        robot, task, options: as changed.
        start: parameters of a walk that nearly keeps the limits, shape (P,): where to start.
        found: the design that following it gives, `design(robot, task, options, start=start)`.
        also: what must be changed as well; nothing where one change suffices.
    """

    knob: str
    words: str
    before: float
    after: float
    unit: str
    robot: Robot
    task: Task
    options: DesignOptions
    start: Array
    found: Design
    also: tuple[Change, ...] = ()

    @property
    def changes(self) -> tuple[Change, ...]:
        """All that is changed; nothing where only the way to the walk is."""
        first = Change(self.knob, self.words, self.before, self.after, self.unit)
        return (first, *self.also) if self.knob else ()

    @property
    def gait(self) -> Array:
        """Parameters of the walk found, shape (P,)."""
        return self.found.solution.x

    @property
    def cost(self) -> float:
        """Of the walk, in the unit of the task's cost."""
        return self.found.solution.cost

    @property
    def sentence(self) -> str:
        """In words."""
        proven = "certified" if self.options.refine else "optimal (at its samples)"
        walk = f"a {proven} walk of cost {self.cost:.5g} {self.task.cost.unit}"
        if not self.knob:
            return f"{self.words} leads to {walk}"
        if self.knob == "impulse_cop":
            return f"without {self.words} (impulse_cop) there is {walk}"
        changes = " and ".join(change.sentence for change in self.changes)
        return f"changing {changes} gives {walk}"

    def record(self) -> dict[str, object]:
        """Return the suggestion as JSON-able data."""
        told = ("knob", "words", "before", "after", "unit", "cost")
        return {
            **{name: getattr(self, name) for name in told},
            "also": [asdict(change) for change in self.also],
            "start": self.start.tolist(),
            "gait": self.gait.tolist(),
        }


@dataclass
class Effort:
    """What a search for suggestions may use, and has done.

    Attributes:
        options: how a walk is designed that follows a suggestion.
        stop: ends the search.
        evaluations: so far.
        tried: names of the knobs that were turned in vain at least once.
        done: names of those that led to a suggestion.
    """

    options: DesignOptions
    stop: Stop = never
    evaluations: int = 0
    tried: tuple[str, ...] = ()
    done: tuple[str, ...] = ()

    def spent(self, enough: bool) -> bool:
        """Whether no other knob should be begun."""
        return self.evaluations >= (WORK if enough else MOST_WORK)


def find_suggestions(
    problem: WalkProblem, reason: Reason | None, options: DesignOptions, stop: Stop = never
) -> tuple[tuple[Suggestion, ...], tuple[str, ...]]:
    """Return what suffices, the most promising first, and the knobs turned alone in vain.

    Args:
        problem: a walk without a gait.
        reason: its smallest relaxation; without one, only what asks for more than is usual is
            changed.
        options: how the walk was searched for, and will be.
        stop: ends the search.

    Raises:
        StoppedError: `stop` said so.
    """
    effort = Effort(following(options), stop)
    if reason is None:
        return _all_usual(problem, effort)
    x = reason.x
    found: list[Suggestion] = []
    main = _giving(problem, reason, MAIN * reason.amount)
    promising = _promising(problem, reason)
    trials: list[tuple[Knob, Callable[..., Suggestion | None]]] = []
    for knob, start in _near(reason, promising):
        trials += [(knob, partial(_turn, start=start)), (knob, _as_usual)]
    for knob, start in _far(problem, main, promising):
        trials += [(knob, partial(_turn, start=start))]
    for knob, trial in trials:
        if len(found) == ENOUGH or effort.spent(bool(found)):
            break
        suggestion = None if knob.name in effort.done else trial(problem, knob, effort=effort)
        if suggestion is not None:
            found.append(suggestion)
            effort.done += (knob.name,)
        elif knob.name not in effort.tried:
            effort.tried += (knob.name,)
    if not found and _pushes(problem, reason, "impulse cop"):
        found += _without_impulse_cop(problem, x, effort)
    if not found:
        found += _together(problem, reason, [knob for knob, _ in promising], effort)
    return tuple(found), tuple(name for name in effort.tried if name not in effort.done)


def _all_usual(
    problem: WalkProblem, effort: Effort
) -> tuple[tuple[Suggestion, ...], tuple[str, ...]]:
    """Return what suffices of the numbers that ask for more than is usual, alone or together."""
    width = step_width_knob(problem)
    knobs = [*limit_knobs(problem), *([] if width is None else [width])]
    if problem.layout.index("duration") is None:
        knobs += [duration_knob(problem, shorter) for shorter in (True, False)]
    asked = [knob for knob in knobs if usual_value(problem, knob) is not None]
    found: list[Suggestion] = []
    for knob in asked:
        if len(found) == ENOUGH or effort.spent(bool(found)):
            break
        suggestion = _as_usual(problem, knob, effort)
        if suggestion is not None:
            found.append(suggestion)
            effort.done += (knob.name,)
        else:
            effort.tried += (knob.name,)
    if not found:
        found += _usual_together(problem, asked, effort)
    return tuple(found), effort.tried


def _near(reason: Reason, promising: list[tuple[Knob, float]]) -> Iterator[tuple[Knob, Start]]:
    """Yield knobs with starts from the smallest relaxation."""
    for knob, amount in promising:
        # One unit of this knob is worth reason.amount / amount of what the reason minimises.
        worth = amount / reason.amount
        multipliers = reason.multipliers * worth if np.isfinite(worth) else None
        yield knob, Start(knob.start(reason.x, amount), multipliers)


def _far(
    problem: WalkProblem, main: set[str], promising: list[tuple[Knob, float]]
) -> Iterator[tuple[Knob, Start]]:
    """Yield the knobs of the main families, wide open, with starts from the first guess."""
    for knob, _ in promising:
        if not main.isdisjoint(knob.families):
            yield knob, Start(knob.start(easier_guess(problem), np.inf))


def following(options: DesignOptions) -> DesignOptions:
    """Return how a walk is designed from a walk that is known."""
    return replace(options, approach="direct", diagnose=False)


def followed(
    robot: Robot, task: Task, x: Array, options: DesignOptions, stop: Stop = never
) -> Design | None:
    """Return the proven design from x, or None.

    A search that is not done after `PATIENCE` iterations is given up. One that is done went the
    same way as without that limit.

    Args:
        robot, task: as changed.
        x: a walk that nearly keeps the limits, shape (P,).
        options: as `following` returns them.
        stop: ends the search.

    Raises:
        StoppedError: `stop` said so.
    """
    problem = WalkProblem(robot, task)
    options = replace(options, solver=options.solver.limited(PATIENCE))
    try:
        solution = attempt(problem, options, x, stop=stop)
        if stop():
            raise StoppedError(solution)
        if not is_walk(solution) or solution.status is Status.ITERATION_LIMIT:
            return None
        found = complete(problem, solution, options, stop=stop)
    except EvaluationError:
        return None
    if stop():
        raise StoppedError(solution)
    return found if found.proven else None


def _promising(problem: WalkProblem, reason: Reason) -> list[tuple[Knob, float]]:
    """Return the knobs to try, with how far they should have to be turned by the multipliers.

    Those that ask for more than is usual come first, then those of the main families, whatever the
    multipliers say; then knobs that may suffice, of these the ones of families that give, then
    those that have to be turned less.
    """
    rows = problem.values(reason.x).rows
    gives, main = (_giving(problem, reason, least) for least in (FEASIBLE, MAIN * reason.amount))
    found: list[tuple[bool, bool, bool, bool, float, Knob]] = []
    for knob in limit_knobs(problem):
        relaxation = knob.relaxation(problem)
        relief = relaxation.relief(rows, reason.multipliers)
        short = relief * relaxation.largest <= reason.amount
        stands, aside = gives.isdisjoint(knob.families), main.isdisjoint(knob.families)
        far = reason.amount / relief if relief > 0.0 else np.inf
        easy = usual_value(problem, knob) is None
        if not easy or not aside or (np.isfinite(far) and not (short and stands)):
            found.append((easy, aside, short, stands, far, knob))
    others = [(True, *entry) for entry in _promising_duration(problem, reason)]
    others += [(main.isdisjoint(k.families), k, n) for k, n in _promising_width(problem, reason)]
    for aside, other, far in others:
        found.append((usual_value(problem, other) is None, aside, False, True, far, other))
    found.sort(key=lambda entry: entry[:5])
    return [(knob, far) for *_, far, knob in found[:KNOBS]]


def _giving(problem: WalkProblem, reason: Reason, least: float) -> set[str]:
    """Return the families that give more than an amount."""
    pairs = zip(problem.blocks, reason.amounts, strict=True)
    return {family.name for family, amount in pairs if amount > least}


def _promising_duration(problem: WalkProblem, reason: Reason) -> list[tuple[Knob, float]]:
    """The step duration: where it is unusual, or in the direction that the multipliers ask for."""
    if problem.layout.index("duration") is not None:
        return []
    for shorter in (True, False):
        knob = duration_knob(problem, shorter)
        start = knob.start(reason.x, 0.0)
        slope = knob.program(problem, start).point(start).jacobian[:, -1]
        relief = -float(reason.multipliers @ slope) * (knob.bound - knob.before)
        if relief > reason.amount or usual_value(problem, knob) is not None:
            return [(knob, reason.amount / relief if relief > reason.amount else 1.0)]
    return []


def _promising_width(problem: WalkProblem, reason: Reason) -> list[tuple[Knob, float]]:
    """The step width: where it is unusual, or if the multipliers ask for it."""
    knob = step_width_knob(problem)
    if knob is None:
        return []
    rate = float(reason.multipliers @ problem.point(reason.x).jacobian[:, knob.index])
    relief = -rate * knob.side * (knob.bound - knob.before)
    if relief > reason.amount:
        return [(knob, reason.amount / relief)]
    return [] if usual_value(problem, knob) is None else [(knob, 1.0)]


def _pushes(problem: WalkProblem, reason: Reason, name: str) -> bool:
    present = name in (f.name for f in problem.blocks)
    return present and bool(reason.multipliers[problem.rows_of(name)].any())


def _turn(problem: WalkProblem, knob: Knob, effort: Effort, start: Start) -> Suggestion | None:
    """Turn one knob as little as possible; return None if that does not suffice.

    The start is in the knob's variables, with multipliers of the walk's rows.
    """
    program = knob.program(problem, start.x)
    own = None if start.multipliers is None else program.own_multipliers(start.multipliers)
    solution = solve_or_stop(SEARCHER, program, Start(start.x, own), effort.stop, Settle())
    effort.evaluations += solution.evaluations
    if not solution.violation <= FEASIBLE:
        return None
    for value in _outward(knob.before, knob.value(solution.x), knob.bound, knob.step):
        suggestion = _suggestion(problem, ((knob, value),), knob.walk(solution.x), effort)
        if suggestion is not None:
            return suggestion
    return None


def _as_usual(problem: WalkProblem, knob: Knob, effort: Effort) -> Suggestion | None:
    """Turn a knob to its usual value where more is asked for; return None if that does not do."""
    value = usual_value(problem, knob)
    return None if value is None else _from_first_guess(problem, ((knob, value),), effort)


def _from_first_guess(problem: WalkProblem, changes: Changes, effort: Effort) -> Suggestion | None:
    """Follow a suggestion from the first guess, at last by way of a relaxed lift-off."""
    try:
        robot, task = _turned(problem, changes)
        x = first_guess(WalkProblem(robot, task))
    except (InputError, UnreachableError):
        return None
    suggestion = _suggestion(problem, changes, x, effort)
    by_way = replace(effort.options, approach="relaxed")
    if suggestion is not None or not begins_relaxed(task, by_way):
        return suggestion
    return _suggestion(problem, changes, x, effort, by_way)


def _together(
    problem: WalkProblem, reason: Reason, knobs: list[Knob], effort: Effort
) -> list[Suggestion]:
    """Turn two knobs as little as possible; at last all that ask for more than is usual."""
    most = effort.evaluations + PAIRS_WORK
    limits = [knob for knob in knobs if isinstance(knob, LimitKnob)]
    for pair in combinations(limits[:PAIRED], 2):
        if effort.evaluations >= most:
            break
        suggestion = _turn_together(problem, reason, pair, effort)
        if suggestion is not None:
            return [suggestion]
    return _usual_together(problem, knobs, effort)


def _usual_together(problem: WalkProblem, knobs: list[Knob], effort: Effort) -> list[Suggestion]:
    """Turn all knobs that ask for more than is usual to their usual values."""
    usual = [(knob, usual_value(problem, knob)) for knob in knobs]
    asked = tuple((knob, value) for knob, value in usual if value is not None)
    suggestion = _from_first_guess(problem, asked, effort) if len(asked) > 1 else None
    return [] if suggestion is None else [suggestion]


def _turn_together(
    problem: WalkProblem, reason: Reason, knobs: tuple[LimitKnob, ...], effort: Effort
) -> Suggestion | None:
    """Turn several knobs of limits as little as possible; return None if they do not suffice."""
    relaxations = tuple(knob.relaxation(problem) for knob in knobs)
    program = RelaxedProgram(problem, relaxations, reason.x)
    solution = solve_or_stop(
        SEARCHER, program, Start(program.needed(reason.x)), effort.stop, Settle()
    )
    effort.evaluations += solution.evaluations
    if not solution.violation <= FEASIBLE:
        return None
    x, amounts = program.split(solution.x)
    outward = [
        list(_outward(k.before, k.before + k.step * t, k.bound, k.step))
        for k, t in zip(knobs, amounts, strict=True)
    ]
    for trial in range(len(OUTWARD)):
        values = [values[min(trial, len(values) - 1)] for values in outward]
        suggestion = _suggestion(problem, tuple(zip(knobs, values, strict=True)), x, effort)
        if suggestion is not None:
            return suggestion
    return None


def _turned(problem: WalkProblem, changes: Changes) -> tuple[Robot, Task]:
    """Return robot and task with knobs turned.

    Raises:
        InputError: a value is out of range.
    """
    robot, task = problem.robot, problem.task
    for knob, value in changes:
        robot, task = knob.turned(robot, task, value)
    return robot, task


def _suggestion(
    problem: WalkProblem,
    changes: Changes,
    x: Array,
    effort: Effort,
    options: DesignOptions | None = None,
) -> Suggestion | None:
    """Follow a suggestion, by default as all of them; return it if it leads to a proven walk."""
    options = options or effort.options
    try:
        robot, task = _turned(problem, changes)
    except InputError:
        return None
    found = followed(robot, task, x, options, effort.stop)
    effort.evaluations += PATIENCE if found is None else found.solution.evaluations
    if found is None:
        return None
    first, *also = (Change(k.name, k.words, k.before, value, k.unit) for k, value in changes)
    return Suggestion(
        first.knob, first.words, first.before, first.after, first.unit,
        robot, task, options, x, found, tuple(also),
    )  # fmt: skip


def _without_impulse_cop(problem: WalkProblem, x: Array, effort: Effort) -> list[Suggestion]:
    margins = replace(problem.task.margins, impulse_cop=False)
    robot, task = problem.robot, replace(problem.task, margins=margins)
    found = followed(robot, task, x, effort.options, effort.stop)
    if found is None:
        effort.tried += ("impulse_cop",)
        return []
    words = "the limit on the centre of pressure at the impact"
    return [Suggestion("impulse_cop", words, 1.0, 0.0, "", robot, task, effort.options, x, found)]


def _outward(before: float, exact: float, bound: float, step: float) -> Iterator[float]:
    """Yield rounded values beyond the exact one, ever farther from the value before.

    Args:
        before: the value asked for.
        exact: the nearest with which a walk may exist.
        bound: the farthest allowed.
        step: a change that matters.
    """
    sign = 1.0 if bound > before else -1.0
    change = max(abs(exact - before), LEAST * abs(step))
    digit = 10.0 ** np.floor(np.log10(change / COARSE))
    last = before
    for factor in OUTWARD:
        least = np.ceil((sign * before + factor * change) / digit - 1e-9)
        value = round(float(sign * least * digit), 9) + 0.0
        value = bound if sign * (bound - value) <= 0.0 else value
        if value != last:
            yield value
        if value == bound:
            return
        last = value
