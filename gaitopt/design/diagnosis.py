"""Why a walk has no gait, and what would give it one: in words and as data.

Suggestions are settings turned as little as possible. The multipliers of the smallest relaxation
tell what turning each would bring; the most promising are turned, one at a time, and if none
suffices alone, several together. Only what led to a proven walk when it was followed, as a person
would follow it, is suggested.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from itertools import combinations

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.deprecation import Renamed
from gaitopt.design.certificate import WorstRow, worst_rows
from gaitopt.design.conflict import (
    PATIENT_CONFLICT_SOLVER,
    RELAXATION_SOLVER,
    SECOND_START_SOLVER,
    Conflict,
    LeastRelaxation,
    conflicts,
    contradictions,
    easier_guess,
    find_least_relaxation,
    first_tries,
    solve_unless_stopped,
)
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import Design, attempt, begins_relaxed, complete, gone_on, is_walk
from gaitopt.design.relaxation import (
    Adjustment,
    EarlyStopping,
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
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Solution, Start, Status
from gaitopt.tolerances import FEASIBLE
from gaitopt.units import digits

SETTINGS_TRIED, ENOUGH = 5, 2
"""Settings that are tried, the most promising first, and suggestions that are enough."""
ENOUGH_EVALUATIONS, MAX_EVALUATIONS = 200, 900
"""Evaluations after which no other setting is begun, if one has been found and if none has."""
PAIRED_SETTINGS, PAIR_EVALUATIONS = 3, 400
"""Settings that are turned in pairs where none suffices alone, and evaluations for that."""
MAIN_SHARE = 0.25
"""Share of the relaxation from which a constraint is a main one. Its setting is tried once more,
wide open from the first guess, where the first did not lead to a walk: what is asked may be so far
from anything that the relaxed walk is no good place to begin."""
LEAST_CHANGE = 0.05
"""Least change worth a suggestion, over the change that matters: smaller ones are made this large.
At the very edge of what can be walked hardly an optimum can be proven."""
CHANGE_FACTORS = (1.1, 2.5)
"""Multiples of the least change that are tried until a walk is certified, ..."""
MAX_ITERATIONS = 70
"""Iterations after which a walk that follows a suggestion is given up."""
ROUNDED_BELOW = 3.0
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
class Suggestion(Change):
    """A change that makes the walk possible; it was followed, and led to a proven walk.

    Its `setting` is empty where nothing but the way to the walk is changed.

    Attributes:
        robot, task, options: as changed.
        found: the design that following it gives, `design(robot, task, options, start=start)`.
        also: what must be changed as well; nothing where one change suffices.
    """

    robot: Robot
    task: Task
    options: DesignOptions
    found: Design
    also: tuple[Change, ...] = ()

    knob = Renamed("setting")

    @property
    def changes(self) -> tuple[Change, ...]:
        """All that is changed; nothing where only the way to the walk is."""
        first = Change(self.setting, self.words, self.before, self.after, self.unit)
        return (first, *self.also) if self.setting else ()

    @property
    def start(self) -> Gait:
        """The gait found: a design that starts from it ends with it."""
        return self.found.gait

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
        proven = "a certified" if self.options.refine else "an optimal (at its samples)"
        walk = f"{proven} walk of cost {self.cost:.5g} {self.task.cost_unit}"
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
            "gait": self.gait.tolist(),
        }


def find_suggestions(
    problem: WalkProblem, relaxed: LeastRelaxation | None, search: Search
) -> tuple[tuple[Suggestion, ...], tuple[str, ...]]:
    """Return what suffices, the most promising first, and the settings changed alone in vain.

    Args:
        relaxed: its smallest relaxation; without one, only what asks for more than is usual is
            changed.

    Raises:
        StoppedError: the search was stopped.
    """
    suggesting = _Suggesting(problem, following(search))
    if relaxed is None:
        suggesting.give_usual_values()
    else:
        suggesting.follow_relaxation(relaxed)
    done = {found.setting for found in suggesting.found if not found.also}
    return tuple(suggesting.found), tuple(name for name in suggesting.tried if name not in done)


def following(search: Search) -> Search:
    """Return how a walk is designed from a walk that is known."""
    return search.changed(approach="direct", diagnose=False)


def followed(robot: Robot, task: Task, x: Array, search: Search) -> Design | None:
    """Return the proven design that going on from a proven walk gives, which x leads to, or None.

    That is what `design(robot, task, options, start=gait)` computes from the gait returned, be it
    in this process or in another. A search that is not done after `MAX_ITERATIONS` is given up; one
    that is done went the same way as without that limit.

    Args:
        x: a walk that nearly keeps the limits, shape (P,).

    Raises:
        StoppedError: the search was stopped.
    """
    search = search.changed(solver=search.options.solver.limited(MAX_ITERATIONS))
    first = _proven(WalkProblem(robot, task), x, search)
    if first is None:
        return None
    # Another process that went this way again might go astray by rounding. What a person runs goes
    # on from the proven walk, so that is what must end in one.
    problem, multipliers = gone_on(WalkProblem(robot, task), first.gait)
    return _proven(problem, first.gait.parameters, search, multipliers)


def _proven(
    problem: WalkProblem, x: Array, search: Search, multipliers: Array | None = None
) -> Design | None:
    """Return the design from x if it is proven."""
    try:
        solution = attempt(problem, search, x, multipliers)
        if search.stop():
            raise StoppedError(solution)
        if not is_walk(solution) or solution.status is Status.ITERATION_LIMIT:
            return None
        found = complete(problem, solution, search)
    except EvaluationError:
        return None
    if search.stop():
        raise StoppedError(solution)
    return found if found.proven else None


class _Suggesting:
    """A search for suggestions.

    Attributes:
        problem: a walk without a gait.
        search: how a walk is designed that follows a suggestion.
        found: suggestions so far.
        tried: names of the settings that were changed alone in vain at least once.
        evaluations: so far.
    """

    def __init__(self, problem: WalkProblem, search: Search) -> None:
        self.problem, self.search = problem, search
        self.found: list[Suggestion] = []
        self.tried: list[str] = []
        self.evaluations = 0

    def follow_relaxation(self, relaxed: LeastRelaxation) -> None:
        """Change the most promising settings alone, then the impulse's limit, then several."""
        promising = _promising(self.problem, relaxed)
        main = _loosened(self.problem, relaxed, MAIN_SHARE * relaxed.amount)
        trials: list[tuple[Adjustment, Callable[[], Suggestion | None]]] = []
        for setting, amount in promising:
            # One unit of the setting is worth this much of what the relaxation minimises.
            worth = amount / relaxed.amount
            multipliers = relaxed.multipliers * worth if np.isfinite(worth) else None
            start = Start(setting.start(relaxed.x, amount), multipliers)
            trials.append((setting, partial(self._least, setting, start)))
            trials.append((setting, partial(self._usual, setting)))
        for setting, _ in promising:
            if not main.isdisjoint(setting.constraints):
                trials.append((setting, partial(self._least_from_afar, setting)))
        self._alone(trials)
        if not self.found and _pushes(self.problem, relaxed, "impulse cop"):
            self._without_impulse_cop(relaxed.x)
        if not self.found:
            limits = [one for one, _ in promising if isinstance(one, LimitAdjustment)]
            most = self.evaluations + PAIR_EVALUATIONS
            for pair in combinations(limits[:PAIRED_SETTINGS], 2):
                if not self.found and self.evaluations < most:
                    self._keep(self._least_of_several(pair, relaxed.x))
        if not self.found:
            self._usual_together([setting for setting, _ in promising])

    def give_usual_values(self) -> None:
        """Give what asks for more than is usual its usual value: alone, then all together."""
        width = step_width_adjustment(self.problem)
        settings = [*limit_adjustments(self.problem), *([] if width is None else [width])]
        if _may_change_duration(self.problem):
            settings += [duration_adjustment(self.problem, shorter) for shorter in (True, False)]
        asked = [one for one in settings if usual_value(self.problem, one) is not None]
        self._alone([(setting, partial(self._usual, setting)) for setting in asked])
        if not self.found:
            self._usual_together(asked)

    def _alone(self, trials: list[tuple[Adjustment, Callable[[], Suggestion | None]]]) -> None:
        """Change one setting after the other, until enough is found or the work is spent."""
        done: set[str] = set()
        for setting, trial in trials:
            spent = self.evaluations >= (ENOUGH_EVALUATIONS if self.found else MAX_EVALUATIONS)
            if len(self.found) == ENOUGH or spent:
                return
            if setting.name not in done:
                if self._keep(trial()):
                    done.add(setting.name)
                elif setting.name not in self.tried:
                    self.tried.append(setting.name)

    def _keep(self, suggestion: Suggestion | None) -> bool:
        self.found += [] if suggestion is None else [suggestion]
        return suggestion is not None

    def _least(self, setting: Adjustment, start: Start) -> Suggestion | None:
        """Change one setting as little as possible, from its variables and multipliers of rows."""
        program = setting.program(self.problem, start.x)
        own = None if start.multipliers is None else program.own_multipliers(start.multipliers)
        z = self._solved(program, Start(start.x, own))
        if z is None:
            return None
        values = _outward(setting.before, setting.value(z), setting.bound, setting.step)
        followed = (self._follow(((setting, value),), setting.walk(z)) for value in values)
        return next((one for one in followed if one is not None), None)

    def _least_from_afar(self, setting: Adjustment) -> Suggestion | None:
        """The same from the first guess with the setting wide open."""
        return self._least(setting, Start(setting.start(easier_guess(self.problem), np.inf)))

    def _least_of_several(
        self, settings: tuple[LimitAdjustment, ...], x: Array
    ) -> Suggestion | None:
        """Change several limits as little as possible, from the relaxed walk x."""
        relaxations = tuple(setting.relaxation(self.problem, x) for setting in settings)
        program = RelaxedProgram(self.problem, relaxations, x)
        z = self._solved(program, Start(program.needed(x)))
        if z is None:
            return None
        x, amounts = program.split(z)
        outward = [
            list(_outward(one.before, one.before + one.step * t, one.bound, one.step))
            for one, t in zip(settings, amounts, strict=True)
        ]
        for trial in range(len(CHANGE_FACTORS)):
            values = [values[min(trial, len(values) - 1)] for values in outward]
            suggestion = self._follow(tuple(zip(settings, values, strict=True)), x)
            if suggestion is not None:
                return suggestion
        return None

    def _solved(self, program: RelaxedProgram, start: Start) -> Array | None:
        """Return the variables of a relaxed program's solution, None if it is not feasible."""
        early = EarlyStopping()
        solution = solve_unless_stopped(RELAXATION_SOLVER, program, start, self.search.stop, early)
        self.evaluations += solution.evaluations
        return solution.x if solution.violation <= FEASIBLE else None

    def _usual(self, setting: Adjustment) -> Suggestion | None:
        """Give a setting its usual value where more is asked for."""
        value = usual_value(self.problem, setting)
        return None if value is None else self._from_first_guess(((setting, value),))

    def _usual_together(self, settings: list[Adjustment]) -> None:
        """Give all settings that ask for more than is usual their usual values."""
        usual = [(setting, usual_value(self.problem, setting)) for setting in settings]
        asked = tuple((setting, value) for setting, value in usual if value is not None)
        if len(asked) > 1:
            self._keep(self._from_first_guess(asked))

    def _from_first_guess(self, changes: Changes) -> Suggestion | None:
        """Follow changes from the first guess, at last by way of a relaxed lift-off."""
        try:
            robot, task = self._changed(changes)
            x = first_guess(WalkProblem(robot, task))
        except (InputError, UnreachableError):
            return None
        suggestion = self._follow(changes, x)
        by_way = self.search.changed(approach="relaxed")
        if suggestion is not None or not begins_relaxed(task, by_way.options):
            return suggestion
        return self._follow(changes, x, by_way)

    def _follow(
        self, changes: Changes, x: Array, search: Search | None = None
    ) -> Suggestion | None:
        """Follow changes from x; return them if they lead to a proven walk."""
        search = search or self.search
        try:
            robot, task = self._changed(changes)
        except InputError:
            return None
        found = followed(robot, task, x, search)
        self.evaluations += MAX_ITERATIONS if found is None else found.solution.evaluations
        if found is None:
            return None
        first, *also = (Change(k.name, k.words, k.before, value, k.unit) for k, value in changes)
        return Suggestion(
            first.setting, first.words, first.before, first.after, first.unit,
            robot, task, search.options, found, tuple(also),
        )  # fmt: skip

    def _changed(self, changes: Changes) -> tuple[Robot, Task]:
        """Return robot and task with settings changed."""
        robot, task = self.problem.robot, self.problem.task
        for setting, value in changes:
            robot, task = setting.changed(robot, task, value)
        return robot, task

    def _without_impulse_cop(self, x: Array) -> None:
        robot, task = self.problem.robot, self.problem.task
        task = replace(task, margins=replace(task.margins, impulse_cop=False))
        found = followed(robot, task, x, self.search)
        if found is None:
            self.tried.append("impulse_cop")
            return
        words = "the limit on the centre of pressure at the impact"
        self.found.append(
            Suggestion("impulse_cop", words, 1.0, 0.0, "", robot, task, self.search.options, found)
        )


def _promising(problem: WalkProblem, relaxed: LeastRelaxation) -> list[tuple[Adjustment, float]]:
    """Return the settings to try, with how far they should have to be turned by the multipliers.

    Those that ask for more than is usual come first, then those of the main constraints, whatever
    the multipliers say; then settings that may suffice, of these the ones of constraints that give,
    then those that have to be turned less.
    """
    rows = problem.values(relaxed.x).rows
    gives, main = (
        _loosened(problem, relaxed, least) for least in (FEASIBLE, MAIN_SHARE * relaxed.amount)
    )
    found: list[tuple[bool, bool, bool, bool, float, Adjustment]] = []
    for setting in limit_adjustments(problem):
        relaxation = setting.relaxation(problem, relaxed.x)
        relief = relaxation.relief(rows, relaxed.multipliers)
        short = relief * relaxation.largest <= relaxed.amount
        stands, aside = gives.isdisjoint(setting.constraints), main.isdisjoint(setting.constraints)
        far = relaxed.amount / relief if relief > 0.0 else np.inf
        easy = usual_value(problem, setting) is None
        if not easy or not aside or (np.isfinite(far) and not (short and stands)):
            found.append((easy, aside, short, stands, far, setting))
    others = [(True, *entry) for entry in _promising_duration(problem, relaxed)]
    others += [
        (main.isdisjoint(k.constraints), k, n) for k, n in _promising_width(problem, relaxed)
    ]
    for aside, other, far in others:
        found.append((usual_value(problem, other) is None, aside, False, True, far, other))
    found.sort(key=lambda entry: entry[:5])
    return [(setting, far) for *_, far, setting in found[:SETTINGS_TRIED]]


def _loosened(problem: WalkProblem, relaxed: LeastRelaxation, least: float) -> set[str]:
    """Return the constraints that give more than an amount."""
    pairs = zip(problem.blocks, relaxed.amounts, strict=True)
    return {constraint.name for constraint, amount in pairs if amount > least}


def _may_change_duration(problem: WalkProblem) -> bool:
    """Whether the task gives the step duration, and the ground has no shape as long as the step."""
    given = problem.layout.index("duration") is None and problem.task.double_support is None
    return given and not problem.task.ground.shaped


def _promising_duration(
    problem: WalkProblem, relaxed: LeastRelaxation
) -> list[tuple[Adjustment, float]]:
    """The step duration: where it is unusual, or in the direction that the multipliers ask for."""
    if not _may_change_duration(problem):
        return []
    for shorter in (True, False):
        setting = duration_adjustment(problem, shorter)
        start = setting.start(relaxed.x, 0.0)
        column = setting.program(problem, start).point(start).jacobian[:, -1]
        relief = -float(relaxed.multipliers @ column) * (setting.bound - setting.before)
        if relief > relaxed.amount or usual_value(problem, setting) is not None:
            return [(setting, relaxed.amount / relief if relief > relaxed.amount else 1.0)]
    return []


def _promising_width(
    problem: WalkProblem, relaxed: LeastRelaxation
) -> list[tuple[Adjustment, float]]:
    """The step width: where it is unusual, or if the multipliers ask for it."""
    setting = step_width_adjustment(problem)
    if setting is None:
        return []
    rate = float(relaxed.multipliers @ problem.point(relaxed.x).jacobian[:, setting.index])
    relief = -rate * setting.side * (setting.bound - setting.before)
    if relief > relaxed.amount:
        return [(setting, relaxed.amount / relief)]
    return [] if usual_value(problem, setting) is None else [(setting, 1.0)]


def _pushes(problem: WalkProblem, relaxed: LeastRelaxation, name: str) -> bool:
    present = name in (f.name for f in problem.blocks)
    return present and bool(relaxed.multipliers[problem.rows_of(name)].any())


def _outward(before: float, exact: float, bound: float, step: float) -> Iterator[float]:
    """Yield rounded values beyond the exact one to the bound; `step` is a change that matters."""
    sign = 1.0 if bound > before else -1.0
    change = max(abs(exact - before), LEAST_CHANGE * abs(step))
    digit = 10.0 ** np.floor(np.log10(change / ROUNDED_BELOW))
    last = before
    for factor in CHANGE_FACTORS:
        least = np.ceil((sign * before + factor * change) / digit - 1e-9)
        value = round(float(sign * least * digit), 9) + 0.0
        value = bound if sign * (bound - value) <= 0.0 else value
        if value != last:
            yield value
        if value == bound:
            return
        last = value


NEARLY_WORST = 0.98
"""Rows violated at least this share of the most violated are its equals."""


@dataclass(frozen=True)
class Diagnosis:
    """Why there is no gait.

    Attributes:
        impossible: sentences on what no motion can meet, if that was seen at once.
        violation: least violation found, scaled.
        worst: the row that has it; None where nothing could be evaluated.
        conflict: constraints in the way, most first; empty if a gait was found after all.
        suggestions: single changes that suffice, most promising first; if none does, several
            changes that do together.
        tried: what was changed in vain, by the names of `Suggestion.setting`.
        gait: parameters of a feasible walk, shape (P,), if one was found after all.
        seconds: of CPU time spent on the diagnosis.
    """

    impossible: tuple[str, ...]
    violation: float
    worst: WorstRow | None
    conflict: tuple[Conflict, ...]
    suggestions: tuple[Suggestion, ...]
    tried: tuple[str, ...]
    gait: Array | None
    seconds: float

    families = Renamed("constraints")

    @property
    def constraints(self) -> tuple[str, ...]:
        """Names of the constraints in conflict."""
        return tuple(c.constraint for c in self.conflict)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The diagnosis for people, one thought each."""
        return (*self.reasons, *(s.sentence for s in self.suggestions))

    @property
    def reasons(self) -> tuple[str, ...]:
        """The sentences without the suggestions."""
        if self.gait is not None:
            known = "a walk that keeps every limit at its samples exists"
            rest = "" if self.suggestions else "; from there no proven one was found"
            return (known + rest,)
        said = list(self.impossible)
        if self.worst is not None:
            said.append("the least violation found leaves " + _worst_sentence(self.worst))
        gives = [c.sentence for c in self.conflict if c.amount > 0.0]
        if gives:
            said.append("the smallest relaxation found that admits a walk: " + "; ".join(gives))
        holds = [c.sentence for c in self.conflict if c.amount == 0.0]
        if holds:
            said.append("what stands against it: " + "; ".join(holds))
        if not self.suggestions:
            tried = f"; tried were {', '.join(self.tried)}" if self.tried else ""
            said.append(
                "no change of one number, nor of several together, was found that leads to a "
                "certified walk" + tried
            )
        return tuple(said)

    def record(self) -> dict[str, object]:
        """Return the diagnosis as JSON-able data."""
        return {
            "sentences": list(self.sentences),
            "impossible": list(self.impossible),
            "violation": self.violation if np.isfinite(self.violation) else None,
            "worst": None if self.worst is None else asdict(self.worst),
            "conflict": [asdict(c) for c in self.conflict],
            "suggestions": [s.record() for s in self.suggestions],
            "tried": list(self.tried),
            "gait": None if self.gait is None else self.gait.tolist(),
            "cpu_seconds": self.seconds,
        }


def _worst_sentence(row: WorstRow) -> str:
    if row.constraint != "walking speed":
        return row.sentence
    return f"a step that is {abs(row.value):.3g} m too {'short' if row.value > 0.0 else 'long'}"


def diagnose(
    problem: WalkProblem, tried: Sequence[Solution] = (), search: Search | None = None
) -> Diagnosis:
    """Find out why a walk has no feasible gait and what change would give it one.

    Args:
        tried: what solvers made of it, where they could start.
        search: how the walk was searched for; suggestions are followed in the same way.

    Raises:
        UnreachableError: not even an easier walk can be guessed.
        StoppedError: the search was stopped.
    """
    started, search = time.process_time(), (search or Search()).quiet
    stop = search.stop
    points = first_tries(problem, tried, stop)
    least = min(points, key=lambda s: s.violation, default=None)
    relaxed = None
    if least is None or least.violation > FEASIBLE:
        places = [point.x for point in points]
        relaxed = find_least_relaxation(problem, places, stop)
        if relaxed is None:
            places.append(easier_guess(problem))
            relaxed = find_least_relaxation(problem, places, stop, PATIENT_CONFLICT_SOLVER)
        if relaxed is not None and relaxed.amount <= FEASIBLE:
            least = solve_unless_stopped(SECOND_START_SOLVER, problem, Start(relaxed.x), stop)
    if least is not None and least.violation <= FEASIBLE:
        seconds = time.process_time() - started
        return Diagnosis((), least.violation, None, (), (), (), least.x, seconds)
    impossible = tuple(sentence for _, sentence in contradictions(problem))
    conflict = () if relaxed is None else conflicts(problem, relaxed)
    suggestions, vain = find_suggestions(problem, relaxed, search)
    return Diagnosis(
        impossible=impossible,
        violation=np.inf if least is None else least.violation,
        worst=None if least is None else _worst(problem, least.x, [c.constraint for c in conflict]),
        conflict=conflict,
        suggestions=suggestions,
        tried=vain,
        gait=None,
        seconds=time.process_time() - started,
    )


def _worst(problem: WalkProblem, x: Array, ranked: list[str]) -> WorstRow:
    """Return the worst row; of equals, the one of the constraint that gives first."""
    rows = worst_rows(problem, x)
    equal = [row for row in rows if row.violation >= NEARLY_WORST * rows[0].violation]
    return min(
        equal, key=lambda r: ranked.index(r.constraint) if r.constraint in ranked else len(ranked)
    )
