"""The search for the reason why there is no gait, and for the least change that makes one.

First the smallest relaxation of all constraint families together tells which of them conflict;
its multipliers tell what turning each knob would bring. Then the most promising knobs are turned
one at a time, as little as possible, and the walk is solved with the new value.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gaitopt.design.certificate import worst_rows
from gaitopt.design.contradictions import contradictions
from gaitopt.design.diagnosis import Diagnosis, Suggestion, conflicts
from gaitopt.design.knobs import Knob, duration_knob, limit_knobs
from gaitopt.design.refine import violated_instants
from gaitopt.design.relaxation import RelaxedProgram, Relaxation
from gaitopt.errors import UnreachableError
from gaitopt.gait.guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start, Status
from gaitopt.solvers.sqp import SQP

SEARCHER = SQP(max_iterations=80, tolerance=1e-3)
"""For relaxations: they need few digits (measured: half the time of 1e-4)."""
TRAVELLER = SQP(max_iterations=40)
"""For a second opinion: another start."""
VERIFIER = SQP(max_iterations=60, tolerance=1e-3)
"""For the walk of a suggestion: it must be feasible; its cost is right to three digits."""
FEASIBLE = 1e-6
"""Scaled violation below which there is a walk."""
MATTERS = {"walking speed": 0.1, "lift-off": 0.1, "knee": 0.3}
"""Changes of scaled rows that matter as much as one of the others: 0.1 m, 0.1 m/s, 0.3 rad."""
SIGMA = 0.1
"""Standard deviation of the second start [rad], [rad/s]."""
SHORTER = 0.8
"""Where the first guess cannot stand, its step is this share of the longest."""
HOLDS = 0.05
"""Share of the push from which a family that holds belongs to the conflict."""
KNOBS = 5
"""Knobs that are tried, the most promising first."""
COARSE = 3.0
"""A suggestion is rounded to a power of ten below this part of the change."""
OUTWARD = (0, 1, 4, 10)
"""Last digits by which a knob is turned farther until a walk is found."""
ROUNDS = 4
"""Times instants are added where a limit is exceeded between the samples."""


@dataclass(frozen=True)
class _Reason:
    """The smallest relaxation: program and its solution, multipliers of the walk's rows."""

    program: RelaxedProgram
    solution: Solution
    multipliers: Array

    @property
    def amount(self) -> float:
        return float(self.program.split(self.solution.x)[1].sum())


def diagnose(
    problem: WalkProblem, tried: Solution | None = None, refined: bool = True
) -> Diagnosis:
    """Find out why a walk has no feasible gait and what change would give it one.

    Args:
        problem: the walk.
        tried: what a solver made of it, if one could start.
        refined: whether the gaits of suggestions must hold between the samples too.
    """
    started = time.perf_counter()
    impossible = contradictions(problem)
    points = _points(problem, tried)
    walk = next((s for s in points if s.violation <= FEASIBLE), None)
    reason = None if walk is not None else _reason(problem, points)
    if walk is None and reason is not None and reason.amount <= FEASIBLE:
        x = reason.program.split(reason.solution.x)[0]
        walk = TRAVELLER.solve(problem, Start(x))
    least = min(points, key=lambda s: s.violation, default=None)
    if walk is not None and walk.violation <= FEASIBLE:
        return Diagnosis((), walk.violation, None, (), (), walk.x, _since(started))
    conflict, suggestions = (), ()
    if reason is not None:
        conflict = conflicts(problem, reason.program, reason.solution.x, reason.multipliers, HOLDS)
        suggestions = tuple(_suggestions(problem, reason, refined))
    return Diagnosis(
        impossible=tuple(sentence for _, sentence in impossible),
        violation=np.inf if least is None else least.violation,
        worst=None if least is None else worst_rows(problem, least.x)[0],
        conflict=conflict,
        suggestions=suggestions,
        gait=None,
        seconds=_since(started),
    )


def _points(problem: WalkProblem, tried: Solution | None) -> list[Solution]:
    """Return where two runs ended: the one already made, and one from another start."""
    found = []
    if tried is not None and np.isfinite(tried.violation):
        found.append(tried)
    x = _guess(problem)
    for start in (perturbed(problem, x, SIGMA, seed=0), x):
        if len(found) < 2 and not any(s.violation <= FEASIBLE for s in found):
            found.append(TRAVELLER.solve(problem, Start(start)))
    return [s for s in found if np.isfinite(s.violation)]


def _guess(problem: WalkProblem) -> Array:
    """Return the first guess, that of a shorter step if need be."""
    try:
        return first_guess(problem)
    except UnreachableError:
        task, legs = problem.task, problem.robot.legs
        speed = SHORTER * 2.0 * legs.reach / task.duration
        return first_guess(WalkProblem(problem.robot, replace(task, speed=speed), problem.grid))


def _reason(problem: WalkProblem, points: list[Solution]) -> _Reason | None:
    """Return the smallest relaxation of all families that is found from several points."""
    best: _Reason | None = None
    program = RelaxedProgram(problem, _family_relaxations(problem))
    for point in points:
        solution = SEARCHER.solve(program, Start(program.needed(point.x)))
        if not solution.violation <= FEASIBLE:
            continue
        found = _Reason(program, solution, program.base_multipliers(solution.multipliers))
        if best is None or found.amount < best.amount:
            best = found
        if best.amount <= FEASIBLE:
            break
    return best


def _family_relaxations(problem: WalkProblem) -> tuple[Relaxation, ...]:
    """One per family; the walking speed may only fall."""
    found = []
    for family in problem.families:
        gives = np.zeros(problem.rows.lower.size)
        gives[problem.family_rows(family.name)] = MATTERS.get(family.name, 1.0)
        slower = family.name == "walking speed"
        found.append(Relaxation(family.name, 0.0 * gives if slower else gives, gives))
    return tuple(found)


def _suggestions(problem: WalkProblem, reason: _Reason, refined: bool) -> Iterator[Suggestion]:
    """Yield what suffices alone, the smallest relative change first."""
    x, _ = reason.program.split(reason.solution.x)
    found = [
        suggestion
        for knob, amount in _promising(problem, reason)
        if (suggestion := _turn(problem, knob, knob.start(x, amount), refined)) is not None
    ]
    if _pushes(problem, reason, "impulse cop"):
        found.extend(_without_impulse_cop(problem, x, refined))
    yield from found


def _promising(problem: WalkProblem, reason: _Reason) -> list[tuple[Knob, float]]:
    """Return knobs with how far they should have to be turned, by the multipliers."""
    x, _ = reason.program.split(reason.solution.x)
    rows = problem.values(x).rows
    found: list[tuple[Knob, float]] = []
    for knob in limit_knobs(problem):
        relaxation = knob.relaxation(problem)
        relief = relaxation.relief(rows, reason.multipliers)
        if relief * relaxation.largest > reason.amount:
            found.append((knob, reason.amount / relief))
    found.extend(_promising_duration(problem, reason, x))
    return sorted(found, key=lambda pair: pair[1])[:KNOBS]


def _promising_duration(
    problem: WalkProblem, reason: _Reason, x: Array
) -> list[tuple[Knob, float]]:
    """The step duration, in the direction that the multipliers ask for."""
    if problem.layout.index("duration") is not None:
        return []
    for shorter in (True, False):
        knob = duration_knob(problem, shorter)
        slope = knob.program(problem).point(knob.start(x, 0.0)).jacobian[:, -1]
        relief = -float(reason.multipliers @ slope) * (knob.bound - knob.before)
        if relief > reason.amount:
            return [(knob, reason.amount / relief)]
    return []


def _pushes(problem: WalkProblem, reason: _Reason, name: str) -> bool:
    present = name in (f.name for f in problem.families)
    return present and bool(reason.multipliers[problem.family_rows(name)].any())


def _turn(problem: WalkProblem, knob: Knob, start: Array, refined: bool) -> Suggestion | None:
    """Turn one knob as little as possible; return None if that does not suffice."""
    problem, solution = _least_turn(problem, knob, start, refined)
    if not solution.violation <= FEASIBLE:
        return None
    for value in _outward(knob.before, knob.value(solution.x), knob.bound):
        robot, task = knob.turned(problem.robot, problem.task, value)
        walk = _walk(WalkProblem(robot, task, problem.grid), solution.x[:-1], refined)
        if walk is not None:
            return Suggestion(knob.name, knob.words, knob.before, value, knob.unit, True, walk.cost)
    return None


def _least_turn(
    problem: WalkProblem, knob: Knob, start: Array, refined: bool
) -> tuple[WalkProblem, Solution]:
    """Return the solution of a knob's program, and the walk with the instants that matter to it."""
    solution = SEARCHER.solve(knob.program(problem), Start(start))
    for _ in range(ROUNDS if refined else 0):
        if not solution.violation <= FEASIBLE:
            break
        robot, task = knob.turned(problem.robot, problem.task, knob.value(solution.x))
        extra = violated_instants(WalkProblem(robot, task, problem.grid), solution.x[:-1])
        if extra.size == 0:
            break
        problem = problem.with_grid(problem.grid.with_instants(extra))
        solution = SEARCHER.solve(knob.program(problem), Start(solution.x))
    return problem, solution


def _without_impulse_cop(problem: WalkProblem, x: Array, refined: bool) -> list[Suggestion]:
    margins = replace(problem.task.margins, impulse_cop=False)
    task = replace(problem.task, margins=margins)
    walk = _walk(WalkProblem(problem.robot, task, problem.grid), x, refined)
    if walk is None:
        return []
    words = "the limit on the centre of pressure at the impact (impulse_cop)"
    return [Suggestion("impulse_cop", words, 1.0, 0.0, "", True, walk.cost)]


def _walk(problem: WalkProblem, x: Array, refined: bool) -> Solution | None:
    """Return a gait of a changed task, found from x, or None."""
    for _ in range(ROUNDS):
        solution = VERIFIER.solve(problem, Start(x))
        if not solution.violation <= FEASIBLE:
            return None
        extra = violated_instants(problem, solution.x) if refined else np.zeros(0)
        if extra.size == 0:
            return solution
        problem, x = problem.with_grid(problem.grid.with_instants(extra)), solution.x
    return None


def _outward(before: float, exact: float, bound: float) -> Iterator[float]:
    """Yield rounded values beyond the exact one, ever farther from the value before."""
    sign = 1.0 if bound > before else -1.0
    digit = 10.0 ** np.floor(np.log10(max(abs(exact - before), 1e-9) / COARSE))
    nearest = np.ceil(sign * exact / digit - 1e-9)
    for more in OUTWARD:
        value = round(float(sign * (nearest + more) * digit), 9) + 0.0
        if sign * (bound - value) <= 0.0:
            yield bound
            return
        yield value


def _since(started: float) -> float:
    return time.perf_counter() - started
