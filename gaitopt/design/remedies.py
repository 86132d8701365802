"""Changes that make a walk possible: settings turned as little as possible, and followed.

The multipliers of the smallest relaxation tell what turning each setting would bring; the most
promising are turned, one at a time, and if none suffices alone, several together. Only what led to
a proven walk when it was followed, as a person would follow it, is suggested.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np

from gaitopt.design.conflict import (
    RELAXATION_SOLVER,
    LeastRelaxation,
    easier_guess,
    solve_unless_stopped,
)
from gaitopt.design.early_stopping import EarlyStopping
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design, attempt, begins_relaxed, complete, is_walk
from gaitopt.design.relaxation import (
    Adjustment,
    LimitAdjustment,
    RelaxedProgram,
    duration_adjustment,
    limit_adjustments,
    step_width_adjustment,
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

SETTINGS_TRIED, ENOUGH = 5, 2
"""Settings that are tried, the most promising first, and suggestions that are enough."""
WORK, MOST_WORK = 200, 900
"""Evaluations after which no other setting is begun, if one has been found and if none has."""
PAIRED, PAIRS_WORK = 3, 400
"""Settings that are turned in pairs where none suffices alone, and evaluations for that."""
MAIN = 0.25
"""Share of the relaxation from which a family is a main one. Its setting is turned a second time,
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

Changes = tuple[tuple[Adjustment, float], ...]


@dataclass(frozen=True)
class Change:
    """One number changed.

    Attributes:
        setting: field of `Task` or `Margins`, or a property of the robot.
        words: for a person.
        before, after: its value in the task, and the one with which a walk was found.
        unit: of both, empty where there is none.
    """

    setting: str
    words: str
    before: float
    after: float
    unit: str

    @property
    def sentence(self) -> str:
        """In words."""
        unit = f" {self.unit}" if self.unit else ""
        return f"{self.words} ({self.setting}) from {self.before:g} to {digits(self.after)}{unit}"


@dataclass(frozen=True)
class Suggestion:
    """A change that makes the walk possible; it was followed, and led to a proven walk.

    Attributes:
        setting: field of `Task` or `Margins`, or a property of the robot; empty where nothing but
            the way to the walk is changed.
        words: for a person.
        before, after: its value in the task, and the one with which a walk was found.
        unit: of both, empty where there is none.
        robot, task, options: as changed.
        start: parameters of a walk that nearly keeps the limits, shape (P,): where to start.
        found: the design that following it gives, `design(robot, task, options, start=start)`.
        also: what must be changed as well; nothing where one change suffices.
    """

    setting: str
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
        first = Change(self.setting, self.words, self.before, self.after, self.unit)
        return (first, *self.also) if self.setting else ()

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
        if not self.setting:
            return f"{self.words} leads to {walk}"
        if self.setting == "impulse_cop":
            return f"without {self.words} (impulse_cop) there is {walk}"
        changes = " and ".join(change.sentence for change in self.changes)
        return f"changing {changes} gives {walk}"

    def record(self) -> dict[str, object]:
        """Return the suggestion as JSON-able data."""
        told = ("setting", "words", "before", "after", "unit", "cost")
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
        tried: names of the settings that were turned in vain at least once.
        done: names of those that led to a suggestion.
    """

    options: DesignOptions
    stop: Stop = never
    evaluations: int = 0
    tried: tuple[str, ...] = ()
    done: tuple[str, ...] = ()

    def spent(self, enough: bool) -> bool:
        """Whether no other setting should be begun."""
        return self.evaluations >= (WORK if enough else MOST_WORK)


def find_suggestions(
    problem: WalkProblem, reason: LeastRelaxation | None, options: DesignOptions, stop: Stop = never
) -> tuple[tuple[Suggestion, ...], tuple[str, ...]]:
    """Return what suffices, the most promising first, and the settings turned alone in vain.

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
    trials: list[tuple[Adjustment, Callable[..., Suggestion | None]]] = []
    for setting, start in _near(reason, promising):
        trials += [(setting, partial(_change_least, start=start)), (setting, _as_usual)]
    for setting, start in _far(problem, main, promising):
        trials += [(setting, partial(_change_least, start=start))]
    for setting, trial in trials:
        if len(found) == ENOUGH or effort.spent(bool(found)):
            break
        suggestion = None if setting.name in effort.done else trial(problem, setting, effort=effort)
        if suggestion is not None:
            found.append(suggestion)
            effort.done += (setting.name,)
        elif setting.name not in effort.tried:
            effort.tried += (setting.name,)
    if not found and _pushes(problem, reason, "impulse cop"):
        found += _without_impulse_cop(problem, x, effort)
    if not found:
        found += _together(problem, reason, [setting for setting, _ in promising], effort)
    return tuple(found), tuple(name for name in effort.tried if name not in effort.done)


def _all_usual(
    problem: WalkProblem, effort: Effort
) -> tuple[tuple[Suggestion, ...], tuple[str, ...]]:
    """Return what suffices of the numbers that ask for more than is usual, alone or together."""
    width = step_width_adjustment(problem)
    settings = [*limit_adjustments(problem), *([] if width is None else [width])]
    if problem.layout.index("duration") is None:
        settings += [duration_adjustment(problem, shorter) for shorter in (True, False)]
    asked = [setting for setting in settings if usual_value(problem, setting) is not None]
    found: list[Suggestion] = []
    for setting in asked:
        if len(found) == ENOUGH or effort.spent(bool(found)):
            break
        suggestion = _as_usual(problem, setting, effort)
        if suggestion is not None:
            found.append(suggestion)
            effort.done += (setting.name,)
        else:
            effort.tried += (setting.name,)
    if not found:
        found += _usual_together(problem, asked, effort)
    return tuple(found), effort.tried


def _near(
    reason: LeastRelaxation, promising: list[tuple[Adjustment, float]]
) -> Iterator[tuple[Adjustment, Start]]:
    """Yield settings with starts from the smallest relaxation."""
    for setting, amount in promising:
        # One unit of this setting is worth reason.amount / amount of what the reason minimises.
        worth = amount / reason.amount
        multipliers = reason.multipliers * worth if np.isfinite(worth) else None
        yield setting, Start(setting.start(reason.x, amount), multipliers)


def _far(
    problem: WalkProblem, main: set[str], promising: list[tuple[Adjustment, float]]
) -> Iterator[tuple[Adjustment, Start]]:
    """Yield the settings of the main families, wide open, with starts from the first guess."""
    for setting, _ in promising:
        if not main.isdisjoint(setting.families):
            yield setting, Start(setting.start(easier_guess(problem), np.inf))


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


def _promising(problem: WalkProblem, reason: LeastRelaxation) -> list[tuple[Adjustment, float]]:
    """Return the settings to try, with how far they should have to be turned by the multipliers.

    Those that ask for more than is usual come first, then those of the main families, whatever the
    multipliers say; then settings that may suffice, of these the ones of families that give, then
    those that have to be turned less.
    """
    rows = problem.values(reason.x).rows
    gives, main = (_giving(problem, reason, least) for least in (FEASIBLE, MAIN * reason.amount))
    found: list[tuple[bool, bool, bool, bool, float, Adjustment]] = []
    for setting in limit_adjustments(problem):
        relaxation = setting.relaxation(problem)
        relief = relaxation.relief(rows, reason.multipliers)
        short = relief * relaxation.largest <= reason.amount
        stands, aside = gives.isdisjoint(setting.families), main.isdisjoint(setting.families)
        far = reason.amount / relief if relief > 0.0 else np.inf
        easy = usual_value(problem, setting) is None
        if not easy or not aside or (np.isfinite(far) and not (short and stands)):
            found.append((easy, aside, short, stands, far, setting))
    others = [(True, *entry) for entry in _promising_duration(problem, reason)]
    others += [(main.isdisjoint(k.families), k, n) for k, n in _promising_width(problem, reason)]
    for aside, other, far in others:
        found.append((usual_value(problem, other) is None, aside, False, True, far, other))
    found.sort(key=lambda entry: entry[:5])
    return [(setting, far) for *_, far, setting in found[:SETTINGS_TRIED]]


def _giving(problem: WalkProblem, reason: LeastRelaxation, least: float) -> set[str]:
    """Return the families that give more than an amount."""
    pairs = zip(problem.blocks, reason.amounts, strict=True)
    return {family.name for family, amount in pairs if amount > least}


def _promising_duration(
    problem: WalkProblem, reason: LeastRelaxation
) -> list[tuple[Adjustment, float]]:
    """The step duration: where it is unusual, or in the direction that the multipliers ask for."""
    if problem.layout.index("duration") is not None:
        return []
    for shorter in (True, False):
        setting = duration_adjustment(problem, shorter)
        start = setting.start(reason.x, 0.0)
        slope = setting.program(problem, start).point(start).jacobian[:, -1]
        relief = -float(reason.multipliers @ slope) * (setting.bound - setting.before)
        if relief > reason.amount or usual_value(problem, setting) is not None:
            return [(setting, reason.amount / relief if relief > reason.amount else 1.0)]
    return []


def _promising_width(
    problem: WalkProblem, reason: LeastRelaxation
) -> list[tuple[Adjustment, float]]:
    """The step width: where it is unusual, or if the multipliers ask for it."""
    setting = step_width_adjustment(problem)
    if setting is None:
        return []
    rate = float(reason.multipliers @ problem.point(reason.x).jacobian[:, setting.index])
    relief = -rate * setting.side * (setting.bound - setting.before)
    if relief > reason.amount:
        return [(setting, reason.amount / relief)]
    return [] if usual_value(problem, setting) is None else [(setting, 1.0)]


def _pushes(problem: WalkProblem, reason: LeastRelaxation, name: str) -> bool:
    present = name in (f.name for f in problem.blocks)
    return present and bool(reason.multipliers[problem.rows_of(name)].any())


def _change_least(
    problem: WalkProblem, setting: Adjustment, effort: Effort, start: Start
) -> Suggestion | None:
    """Turn one setting as little as possible; return None if that does not suffice.

    The start is in the setting's variables, with multipliers of the walk's rows.
    """
    program = setting.program(problem, start.x)
    own = None if start.multipliers is None else program.own_multipliers(start.multipliers)
    solution = solve_unless_stopped(
        RELAXATION_SOLVER, program, Start(start.x, own), effort.stop, EarlyStopping()
    )
    effort.evaluations += solution.evaluations
    if not solution.violation <= FEASIBLE:
        return None
    for value in _outward(setting.before, setting.value(solution.x), setting.bound, setting.step):
        suggestion = _suggestion(problem, ((setting, value),), setting.walk(solution.x), effort)
        if suggestion is not None:
            return suggestion
    return None


def _as_usual(problem: WalkProblem, setting: Adjustment, effort: Effort) -> Suggestion | None:
    """Give a setting its usual value where more is asked for; return None if that does not do."""
    value = usual_value(problem, setting)
    return None if value is None else _from_first_guess(problem, ((setting, value),), effort)


def _from_first_guess(problem: WalkProblem, changes: Changes, effort: Effort) -> Suggestion | None:
    """Follow a suggestion from the first guess, at last by way of a relaxed lift-off."""
    try:
        robot, task = _changed(problem, changes)
        x = first_guess(WalkProblem(robot, task))
    except (InputError, UnreachableError):
        return None
    suggestion = _suggestion(problem, changes, x, effort)
    by_way = replace(effort.options, approach="relaxed")
    if suggestion is not None or not begins_relaxed(task, by_way):
        return suggestion
    return _suggestion(problem, changes, x, effort, by_way)


def _together(
    problem: WalkProblem, reason: LeastRelaxation, settings: list[Adjustment], effort: Effort
) -> list[Suggestion]:
    """Turn two settings as little as possible; at last all that ask for more than is usual."""
    most = effort.evaluations + PAIRS_WORK
    limits = [setting for setting in settings if isinstance(setting, LimitAdjustment)]
    for pair in combinations(limits[:PAIRED], 2):
        if effort.evaluations >= most:
            break
        suggestion = _change_together(problem, reason, pair, effort)
        if suggestion is not None:
            return [suggestion]
    return _usual_together(problem, settings, effort)


def _usual_together(
    problem: WalkProblem, settings: list[Adjustment], effort: Effort
) -> list[Suggestion]:
    """Turn all settings that ask for more than is usual to their usual values."""
    usual = [(setting, usual_value(problem, setting)) for setting in settings]
    asked = tuple((setting, value) for setting, value in usual if value is not None)
    suggestion = _from_first_guess(problem, asked, effort) if len(asked) > 1 else None
    return [] if suggestion is None else [suggestion]


def _change_together(
    problem: WalkProblem,
    reason: LeastRelaxation,
    settings: tuple[LimitAdjustment, ...],
    effort: Effort,
) -> Suggestion | None:
    """Turn several settings of limits as little as possible; return None if they do not suffice."""
    relaxations = tuple(setting.relaxation(problem) for setting in settings)
    program = RelaxedProgram(problem, relaxations, reason.x)
    solution = solve_unless_stopped(
        RELAXATION_SOLVER, program, Start(program.needed(reason.x)), effort.stop, EarlyStopping()
    )
    effort.evaluations += solution.evaluations
    if not solution.violation <= FEASIBLE:
        return None
    x, amounts = program.split(solution.x)
    outward = [
        list(_outward(k.before, k.before + k.step * t, k.bound, k.step))
        for k, t in zip(settings, amounts, strict=True)
    ]
    for trial in range(len(OUTWARD)):
        values = [values[min(trial, len(values) - 1)] for values in outward]
        suggestion = _suggestion(problem, tuple(zip(settings, values, strict=True)), x, effort)
        if suggestion is not None:
            return suggestion
    return None


def _changed(problem: WalkProblem, changes: Changes) -> tuple[Robot, Task]:
    """Return robot and task with settings turned.

    Raises:
        InputError: a value is out of range.
    """
    robot, task = problem.robot, problem.task
    for setting, value in changes:
        robot, task = setting.changed(robot, task, value)
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
        robot, task = _changed(problem, changes)
    except InputError:
        return None
    found = followed(robot, task, x, options, effort.stop)
    effort.evaluations += PATIENCE if found is None else found.solution.evaluations
    if found is None:
        return None
    first, *also = (Change(k.name, k.words, k.before, value, k.unit) for k, value in changes)
    return Suggestion(
        first.setting, first.words, first.before, first.after, first.unit,
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
