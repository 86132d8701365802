"""Why a walk has no gait, and what would give it one."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from gaitopt.design.certificate import WorstRow, worst_rows
from gaitopt.design.contradictions import contradictions
from gaitopt.design.diagnosis import Diagnosis
from gaitopt.design.options import DesignOptions
from gaitopt.design.reason import (
    PATIENT_GATHERER,
    TRAVELLER,
    conflicts,
    easier_guess,
    find_reason,
    journeys,
    solve_or_stop,
)
from gaitopt.design.suggestions import find_suggestions
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start, Stop, never
from gaitopt.tolerances import FEASIBLE

EQUAL = 0.98
"""Rows violated at least this share of the most violated are its equals."""


def diagnose(
    problem: WalkProblem,
    tried: Sequence[Solution] = (),
    options: DesignOptions | None = None,
    stop: Stop = never,
) -> Diagnosis:
    """Find out why a walk has no feasible gait and what change would give it one.

    Args:
        problem: the walk.
        tried: what solvers made of it, where they could start.
        options: how the walk was searched for; suggestions are followed in the same way.
        stop: ends the diagnosis.

    Raises:
        UnreachableError: not even an easier walk can be guessed.
        StoppedError: `stop` said so.
    """
    started, options = time.process_time(), options or DesignOptions()
    points = journeys(problem, tried, stop)
    least = min(points, key=lambda s: s.violation, default=None)
    reason = None
    if least is None or least.violation > FEASIBLE:
        places = [point.x for point in points]
        reason = find_reason(problem, places, stop)
        if reason is None:
            places.append(easier_guess(problem))
            reason = find_reason(problem, places, stop, PATIENT_GATHERER)
        if reason is not None and reason.amount <= FEASIBLE:
            least = solve_or_stop(TRAVELLER, problem, Start(reason.x), stop)
    if least is not None and least.violation <= FEASIBLE:
        return Diagnosis((), least.violation, None, (), (), (), least.x, _since(started))
    impossible = tuple(sentence for _, sentence in contradictions(problem))
    conflict = () if reason is None else conflicts(problem, reason)
    suggestions, vain = find_suggestions(problem, reason, options, stop)
    return Diagnosis(
        impossible=impossible,
        violation=np.inf if least is None else least.violation,
        worst=None if least is None else _worst(problem, least.x, [c.family for c in conflict]),
        conflict=conflict,
        suggestions=suggestions,
        tried=vain,
        gait=None,
        seconds=_since(started),
    )


def _worst(problem: WalkProblem, x: Array, ranked: list[str]) -> WorstRow:
    """Return the worst row; of equals, the one of the family that gives first."""
    rows = worst_rows(problem, x)
    equal = [row for row in rows if row.violation >= EQUAL * rows[0].violation]
    return min(equal, key=lambda r: ranked.index(r.family) if r.family in ranked else len(ranked))


def _since(started: float) -> float:
    return time.process_time() - started
