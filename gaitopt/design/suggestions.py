"""Single changes that make a walk possible: knobs turned as little as possible, and a walk found.

The multipliers of the smallest relaxation tell what turning each knob would bring; the most
promising are turned, one at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gaitopt.design.active import placed, pressures
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.diagnosis import Suggestion
from gaitopt.design.knobs import Knob, duration_knob, limit_knobs
from gaitopt.design.reason import SEARCHER, Reason, easier_guess, solve_or_stop
from gaitopt.design.refine import violated_instants
from gaitopt.design.relaxation import RelaxedProgram
from gaitopt.design.settle import Settle
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start, Values, worst_violation
from gaitopt.solvers.sqp import SQP
from gaitopt.tolerances import FEASIBLE

WARM = replace(SEARCHER, max_iterations=15)
"""For relaxations that were solved on a coarser grid (measured: five to ten, or very many)."""
INSIDE = 4e-7
"""Scaled violation of a suggestion's walk: what `violated_instants` lets pass, and less."""
VERIFIER = SQP(max_iterations=20, tolerance=1e-2, feasibility=INSIDE)
"""For the walk of a suggestion, which is nearly feasible: any walk near it will do."""
KNOBS, ENOUGH = 5, 3
"""Knobs that are tried, the most promising first, and suggestions that are enough."""
WORK = 400
"""Evaluations after which no other knob is begun if one was found that does it."""
MAIN = 0.25
"""Share of the relaxation from which a family is a main one. Its knob is turned a second time,
wide open from the first guess, where the first did not lead to a walk: what is asked may be so far
from anything that the relaxed walk is no good place to begin."""
COARSE = 3.0
"""A suggestion is rounded to a power of ten below this part of the change."""
OUTWARD = (0, 1, 3, 8)
"""Last digits by which a knob is turned farther until a walk is found."""
SEARCHES, ROUNDS = 1, 10
"""Times instants are added where a limit is exceeded between the samples: while the knob is
turned, and while a walk is sought."""


@dataclass
class Effort:
    """What a search for suggestions has to do, and has done.

    Attributes:
        refined: whether the gaits found must hold between the samples too.
        evaluations: so far.
    """

    refined: bool
    evaluations: int = 0


def find_suggestions(problem: WalkProblem, reason: Reason, refined: bool) -> tuple[Suggestion, ...]:
    """Return what suffices alone, the most promising first.

    Args:
        problem: a walk without a gait.
        reason: its smallest relaxation.
        refined: whether the gaits found must hold between the samples too.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    x, effort = reason.x, Effort(refined)
    main = _giving(problem, reason, MAIN * reason.amount)
    found: list[Suggestion] = []
    for knob, amount in _promising(problem, reason):
        # One unit of this knob is worth reason.amount / amount of what the reason minimises.
        worth = amount / reason.amount
        multipliers = reason.multipliers * worth if np.isfinite(worth) else None
        start = Start(knob.start(x, amount), multipliers)
        suggestion = _turn(problem, knob, start, effort)
        if suggestion is None and not main.isdisjoint(knob.families):
            far = Start(knob.start(easier_guess(problem), np.inf))
            suggestion = _turn(problem, knob, far, effort)
        found += [] if suggestion is None else [suggestion]
        if len(found) == ENOUGH or (found and effort.evaluations >= WORK):
            return tuple(found)
    if _pushes(problem, reason, "impulse cop"):
        found += _without_impulse_cop(problem, x, effort)
    return tuple(found)


def _promising(problem: WalkProblem, reason: Reason) -> list[tuple[Knob, float]]:
    """Return the knobs to try, with how far they should have to be turned by the multipliers.

    Those of the main families come first, whatever the multipliers say; then knobs that may
    suffice, of these the ones of families that give, then those that have to be turned less.
    """
    rows = problem.values(reason.x).rows
    gives, main = (_giving(problem, reason, least) for least in (FEASIBLE, MAIN * reason.amount))
    found: list[tuple[bool, bool, bool, float, Knob]] = []
    for knob in limit_knobs(problem):
        relaxation = knob.relaxation(problem)
        relief = relaxation.relief(rows, reason.multipliers)
        short = relief * relaxation.largest <= reason.amount
        stands, aside = gives.isdisjoint(knob.families), main.isdisjoint(knob.families)
        far = reason.amount / relief if relief > 0.0 else np.inf
        if not aside or (np.isfinite(far) and not (short and stands)):
            found.append((aside, short, stands, far, knob))
    others = _promising_duration(problem, reason)
    found += [(True, False, True, far, knob) for knob, far in others]
    found.sort(key=lambda entry: entry[:4])
    return [(knob, far) for *_, far, knob in found[:KNOBS]]


def _giving(problem: WalkProblem, reason: Reason, least: float) -> set[str]:
    """Return the families that give more than an amount."""
    pairs = zip(problem.families, reason.amounts, strict=True)
    return {family.name for family, amount in pairs if amount > least}


def _promising_duration(problem: WalkProblem, reason: Reason) -> list[tuple[Knob, float]]:
    """The step duration, in the direction that the multipliers ask for."""
    if problem.layout.index("duration") is not None:
        return []
    for shorter in (True, False):
        knob = duration_knob(problem, shorter)
        start = knob.start(reason.x, 0.0)
        slope = knob.program(problem, start).point(start).jacobian[:, -1]
        relief = -float(reason.multipliers @ slope) * (knob.bound - knob.before)
        if relief > reason.amount:
            return [(knob, reason.amount / relief)]
    return []


def _pushes(problem: WalkProblem, reason: Reason, name: str) -> bool:
    present = name in (f.name for f in problem.families)
    return present and bool(reason.multipliers[problem.family_rows(name)].any())


def _turn(problem: WalkProblem, knob: Knob, start: Start, effort: Effort) -> Suggestion | None:
    """Turn one knob as little as possible; return None if that does not suffice.

    The start is in the knob's variables, with multipliers of the walk's rows.
    """
    problem, solution = _least_turn(problem, knob, start, effort)
    if not solution.violation <= FEASIBLE:
        return None
    for value in _outward(knob.before, knob.value(solution.x), knob.bound):
        robot, task = knob.turned(problem.robot, problem.task, value)
        walk = _walk(WalkProblem(robot, task, problem.grid), solution.x[:-1], effort)
        if walk is not None:
            return Suggestion(
                knob.name, knob.words, knob.before, value, knob.unit, walk.cost, walk.x
            )
    return None


def _least_turn(
    problem: WalkProblem, knob: Knob, start: Start, effort: Effort
) -> tuple[WalkProblem, Solution]:
    """Return the solution of a knob's program, and the walk with the instants that matter to it."""
    solution, multipliers = _solved(SEARCHER, knob, problem, start, effort)
    if not effort.refined or not solution.violation <= FEASIBLE:
        return problem, solution
    for _ in range(SEARCHES):
        robot, task = knob.turned(problem.robot, problem.task, knob.value(solution.x))
        extra = violated_instants(on_fine_grid(WalkProblem(robot, task)), solution.x[:-1])
        finer = problem.with_grid(problem.grid.with_instants(extra))
        if finer.grid.count == problem.grid.count:
            break
        warm = Start(solution.x, placed(finer, pressures(problem, multipliers)))
        again, multipliers = _solved(WARM, knob, finer, warm, effort)
        if not again.violation <= FEASIBLE:
            break
        problem, solution = finer, again
    return problem, solution


def _solved(
    solver: SQP, knob: Knob, problem: WalkProblem, start: Start, effort: Effort
) -> tuple[Solution, Array]:
    """Turn a knob from a start with multipliers of the walk's rows; return such ones too."""
    program = knob.program(problem, start.x)
    own = None if start.multipliers is None else program.own_multipliers(start.multipliers)
    solution = solve_or_stop(solver, program, Start(start.x, own), Settle())
    effort.evaluations += solution.evaluations
    return solution, program.base_multipliers(solution.multipliers)


def _without_impulse_cop(problem: WalkProblem, x: Array, effort: Effort) -> list[Suggestion]:
    margins = replace(problem.task.margins, impulse_cop=False)
    task = replace(problem.task, margins=margins)
    walk = _walk(WalkProblem(problem.robot, task, problem.grid), x, effort)
    if walk is None:
        return []
    words = "the limit on the centre of pressure at the impact (impulse_cop)"
    return [Suggestion("impulse_cop", words, 1.0, 0.0, "", walk.cost, walk.x)]


def _walk(problem: WalkProblem, x: Array, effort: Effort) -> Values | None:
    """Return a gait of a changed task near x, or None.

    It is not optimised: an optimum would lean on the limits between the samples again.
    """
    fine = on_fine_grid(problem)
    for _ in range(ROUNDS):
        if worst_violation(problem, problem.values(x))[0] > INSIDE:
            nearest = solve_or_stop(VERIFIER, RelaxedProgram(problem, (), x), Start(x))
            effort.evaluations += nearest.evaluations
            if not nearest.violation <= FEASIBLE:
                return None
            x = nearest.x
        extra = violated_instants(fine, x) if effort.refined else np.zeros(0)
        finer = problem.with_grid(problem.grid.with_instants(extra))
        if finer.grid.count == problem.grid.count:
            return problem.values(x)
        problem = finer
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
