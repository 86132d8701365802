"""The smallest relaxation of all constraint families together: which of them conflict?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gaitopt.design.diagnosis import Conflict
from gaitopt.design.relaxation import Relaxation, RelaxedProgram
from gaitopt.design.settle import Settle
from gaitopt.errors import StoppedError, UnreachableError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import NLP, Array, Solution, Start, Stop, never, stopping
from gaitopt.solvers.sqp import SQP
from gaitopt.tolerances import FEASIBLE

SEARCHER = SQP(max_iterations=80, tolerance=1e-3, feasibility=0.9 * FEASIBLE)
"""For relaxations: they need few digits (measured: half the time of 1e-4). The tip of a smoothed
friction cone is out of reach by 6e-7; asked for more, the solver would insist on it."""
GATHERER = replace(SEARCHER, max_iterations=60)
"""For the relaxation of all families."""
PATIENT_GATHERER = replace(SEARCHER, max_iterations=300)
"""For the same, where that found none (benchmarks/infeasible.py: they take 60 to 200)."""
TRAVELLER = SQP(max_iterations=40)
"""For a second opinion: another start."""
SIGMA = 0.1
"""Standard deviation of the second start [rad], [rad/s]."""
SHORTER = 0.8
"""Where the first guess cannot stand, its step is this share of the longest."""
GIVES = 1e-2
"""A relaxation below this part of all is left out."""
HOLDS = 0.05
"""Share of the push from which a family that holds belongs to the conflict."""


@dataclass(frozen=True)
class Reason:
    """The smallest relaxation that admits a walk.

    Attributes:
        x: parameters of that walk, shape (P,).
        amounts: by how much each family gives, in changes that matter, shape (families,).
        multipliers: of the walk's rows, shape (m,).
    """

    x: Array
    amounts: Array
    multipliers: Array

    @property
    def amount(self) -> float:
        """All of it."""
        return float(self.amounts.sum())


def journeys(problem: WalkProblem, tried: Sequence[Solution], stop: Stop = never) -> list[Solution]:
    """Return where two runs ended: those already made, others from further starts.

    Raises:
        UnreachableError: not even an easier walk can be guessed.
        StoppedError: `stop` said so.
    """
    found = sorted((s for s in tried if np.isfinite(s.violation)), key=lambda s: s.violation)[:2]
    if len(found) < 2:
        x = easier_guess(problem)
        for start in (perturbed(problem, x, SIGMA, seed=0), x):
            if len(found) < 2 and not any(s.violation <= FEASIBLE for s in found):
                found.append(solve_or_stop(TRAVELLER, problem, Start(start), stop))
    return [s for s in found if np.isfinite(s.violation)]


def easier_guess(problem: WalkProblem) -> Array:
    """Return the first guess, if need be that of an easier walk, shape (P,).

    Raises:
        UnreachableError: there is none either.
    """
    task, legs = problem.task, problem.robot.legs
    slow = min(task.speed, SHORTER * 2.0 * legs.reach / task.duration)
    narrow = replace(task.margins, lateral_gap=min(task.margins.lateral_gap, 0.0))
    for easier in (task, replace(task, speed=slow), replace(task, speed=slow, margins=narrow)):
        try:
            return first_guess(WalkProblem(problem.robot, easier, problem.grid))
        except UnreachableError as error:
            reason = error
    raise reason


def find_reason(
    problem: WalkProblem, points: Sequence[Array], stop: Stop = never, solver: SQP = GATHERER
) -> Reason | None:
    """Return the smallest relaxation of all families that is found from several points.

    Args:
        problem: the walk.
        points: parameters to begin with, shape (P,) each.
        stop: ends the search.
        solver: of the relaxed programs.

    Raises:
        StoppedError: `stop` said so.
    """
    best: Reason | None = None
    relaxations = _family_relaxations(problem)
    for x in points:
        program = RelaxedProgram(problem, relaxations, x)
        solution = solve_or_stop(solver, program, Start(program.needed(x)), stop)
        if not solution.violation <= FEASIBLE:
            continue
        multipliers = program.base_multipliers(solution.multipliers)
        found = Reason(*program.split(solution.x), multipliers)
        if best is None or found.amount < best.amount:
            best = found
        if best.amount <= FEASIBLE:
            break
    return best


def conflicts(problem: WalkProblem, reason: Reason) -> tuple[Conflict, ...]:
    """Return the families in conflict: those that give, most first, then those that push most."""
    matter = np.array([f.change for f in problem.blocks])
    rows = [problem.rows_of(f.name) for f in problem.blocks]
    push = matter * np.array([np.abs(reason.multipliers[r]).sum() for r in rows])
    share = push / max(float(push.sum()), 1e-12)
    gives = reason.amounts > GIVES * reason.amount
    given = np.where(gives, reason.amounts, 0.0)
    order = np.lexsort((-share, -given))
    found = []
    for i in order[(gives | (share >= HOLDS))[order]]:
        family = problem.blocks[i]
        row = rows[i].start + int(np.argmax(np.abs(reason.multipliers[rows[i]])))
        unit = matter[i] * float(family.scale[problem.address(row).entry])
        amount = float(reason.amounts[i]) * unit if gives[i] else 0.0
        found.append(
            Conflict(
                family.name,
                family.words,
                amount,
                family.unit,
                problem.describe(row),
                float(share[i]),
            )
        )
    return tuple(found)


def solve_or_stop(
    solver: SQP, program: NLP, start: Start, stop: Stop = never, early: Settle | None = None
) -> Solution:
    """Solve, until `early` finds it good enough.

    Raises:
        StoppedError: `stop` said so.
    """
    solution = solver.solve(program, start, stop=stopping(stop, early))
    if stop():
        raise StoppedError(solution)
    return solution


def _family_relaxations(problem: WalkProblem) -> tuple[Relaxation, ...]:
    """One per family; the walking speed may only fall."""
    found = []
    for family in problem.blocks:
        gives = np.zeros(problem.rows.lower.size)
        gives[problem.rows_of(family.name)] = family.change
        slower = family.name == "walking speed"
        found.append(Relaxation(family.name, 0.0 * gives if slower else gives, gives))
    return tuple(found)
