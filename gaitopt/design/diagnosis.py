"""Why a walk has no gait, and what would give it one: in words and as data."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.deprecation import Renamed
from gaitopt.design.certificate import WorstRow, worst_rows
from gaitopt.design.conflict import (
    PATIENT_CONFLICT_SOLVER,
    SECOND_START_SOLVER,
    Conflict,
    conflicts,
    contradictions,
    easier_guess,
    find_least_relaxation,
    first_tries,
    solve_unless_stopped,
)
from gaitopt.design.options import DesignOptions
from gaitopt.design.suggestions import Suggestion, find_suggestions
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Solution, Start, Stop, never
from gaitopt.tolerances import FEASIBLE

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
        return Diagnosis((), least.violation, None, (), (), (), least.x, _since(started))
    impossible = tuple(sentence for _, sentence in contradictions(problem))
    conflict = () if relaxed is None else conflicts(problem, relaxed)
    suggestions, vain = find_suggestions(problem, relaxed, options, stop)
    return Diagnosis(
        impossible=impossible,
        violation=np.inf if least is None else least.violation,
        worst=None if least is None else _worst(problem, least.x, [c.constraint for c in conflict]),
        conflict=conflict,
        suggestions=suggestions,
        tried=vain,
        gait=None,
        seconds=_since(started),
    )


def _worst(problem: WalkProblem, x: Array, ranked: list[str]) -> WorstRow:
    """Return the worst row; of equals, the one of the constraint that gives first."""
    rows = worst_rows(problem, x)
    equal = [row for row in rows if row.violation >= NEARLY_WORST * rows[0].violation]
    return min(
        equal, key=lambda r: ranked.index(r.constraint) if r.constraint in ranked else len(ranked)
    )


def _since(started: float) -> float:
    return time.process_time() - started
