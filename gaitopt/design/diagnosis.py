"""Why there is no gait, in words and as data."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from gaitopt.design.certificate import WorstRow
from gaitopt.design.relaxation import RelaxedProgram
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array

PLAIN_WORDS = {
    "torque": "joint torque",
    "speed": "joint speed",
    "range": "joint range",
    "load": "load on the stance foot",
    "friction": "friction on the ground",
    "cop": "centre of pressure",
    "impulse": "vertical impulse at the impact",
    "impulse friction": "friction at the impact",
    "impulse cop": "centre of pressure at the impact",
    "lift-off": "lift-off of the rear foot",
    "clearance": "clearance of the swing foot",
    "lateral": "gap between the feet",
    "knee": "bend of the knees",
    "leg length": "length of the legs",
    "walking speed": "walking speed",
}
"""What a constraint family is to a person."""


@dataclass(frozen=True)
class Conflict:
    """A constraint family that stands in the way.

    Attributes:
        family: its name.
        amount, unit: by how much its limits give in the smallest relaxation; zero for a family
            that holds but pushes the others.
        row: joint and instant where it pushes most.
        share: of all push (multipliers of the smallest relaxation), from 0 to 1.
    """

    family: str
    amount: float
    unit: str
    row: str
    share: float

    @property
    def sentence(self) -> str:
        """In words."""
        words = PLAIN_WORDS.get(self.family, self.family)
        where = "" if self.family == "walking speed" else f" ({self.row})"
        if self.amount == 0.0:
            return words + where
        return f"{words} by {self.amount:.2g} {self.unit}{where}"


@dataclass(frozen=True)
class Suggestion:
    """One change that alone makes the walk possible.

    Attributes:
        knob: field of `Task` or `Margins`, or a property of the robot.
        words: for a person.
        before, after: its value in the task, and one with which a gait was found.
        unit: of both, empty where there is none.
        verified: whether a gait of the changed task was found.
        cost: of that gait [N²·m·s].
    """

    knob: str
    words: str
    before: float
    after: float
    unit: str
    verified: bool
    cost: float

    @property
    def sentence(self) -> str:
        """In words."""
        if self.knob == "impulse_cop":
            change = f"dropping {self.words} makes it feasible"
        else:
            unit = f" {self.unit}" if self.unit else ""
            change = (
                f"changing {self.words} ({self.knob}) from {self.before:g} to {self.after:g}{unit} "
                "makes it feasible"
            )
        return f"{change} (a gait of cost {self.cost:.5g} was found)" if self.verified else change


@dataclass(frozen=True)
class Diagnosis:
    """Why there is no gait.

    Attributes:
        impossible: sentences on what no motion can meet, if that was seen at once.
        violation: least violation found, scaled.
        worst: the row that has it; None where nothing could be evaluated.
        conflict: families in the way, most first; empty if a gait was found after all.
        suggestions: single changes that suffice, smallest first.
        gait: parameters of a feasible walk, shape (P,), if one was found after all.
        seconds: spent on the diagnosis.
    """

    impossible: tuple[str, ...]
    violation: float
    worst: WorstRow | None
    conflict: tuple[Conflict, ...]
    suggestions: tuple[Suggestion, ...]
    gait: Array | None
    seconds: float

    @property
    def families(self) -> tuple[str, ...]:
        """Names of the families in conflict."""
        return tuple(c.family for c in self.conflict)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The diagnosis for people, one thought each."""
        if self.gait is not None:
            return ("a feasible walk exists: start from the one that the diagnosis found",)
        said = list(self.impossible)
        if self.worst is not None:
            said.append(f"the least violation found leaves {self.worst.sentence}")
        gives = [c for c in self.conflict if c.amount > 0.0]
        if gives:
            said.append(
                "the smallest relaxation that admits a walk: " + "; ".join(map(_sentence, gives))
            )
        holds = [c for c in self.conflict if c.amount == 0.0]
        if holds:
            said.append("what stands against it: " + "; ".join(map(_sentence, holds)))
        if not self.suggestions:
            said.append("no change of a single number was found that makes it feasible")
        return (*said, *map(_sentence, self.suggestions))

    def record(self) -> dict[str, object]:
        """Return the diagnosis as JSON-able data."""
        return {
            "sentences": list(self.sentences),
            "impossible": list(self.impossible),
            "violation": self.violation if np.isfinite(self.violation) else None,
            "worst": None if self.worst is None else asdict(self.worst),
            "conflict": [asdict(c) for c in self.conflict],
            "suggestions": [asdict(s) for s in self.suggestions],
            "gait": None if self.gait is None else self.gait.tolist(),
            "seconds": self.seconds,
        }


def conflicts(
    problem: WalkProblem, program: RelaxedProgram, z: Array, multipliers: Array, least: float
) -> tuple[Conflict, ...]:
    """Return the families in conflict at the solution of a program that relaxes each of them.

    Args:
        problem: the walk.
        program: one relaxation per family, in their order.
        z: its solution.
        multipliers: of the walk's rows there, shape (m,).
        least: share from which a family that holds counts.
    """
    _, t = program.split(z)
    matter = np.array([max(r.upper.max(), r.lower.max()) for r in program.relaxations])
    push = {
        f.name: float(np.abs(multipliers[problem.family_rows(f.name)]).sum()) * matter[i]
        for i, f in enumerate(problem.families)
    }
    total = sum(push.values())
    found = []
    for i, family in enumerate(problem.families):
        rows = problem.family_rows(family.name)
        row = rows.start + int(np.argmax(np.abs(multipliers[rows])))
        share = push[family.name] / total if total > 0.0 else 0.0
        scale = float(family.scale[problem.address(row).entry])
        gives = t[i] > GIVES * t.sum()
        if gives or share >= least:
            amount = float(t[i] * matter[i]) * scale if gives else 0.0
            there = Conflict(family.name, amount, family.unit, problem.describe(row), share)
            found.append((float(t[i]), there))
    found.sort(key=lambda pair: (-pair[0] if pair[1].amount else 0.0, -pair[1].share))
    return tuple(there for _, there in found)


GIVES = 1e-2
"""A relaxation below this part of all is left out."""


def _sentence(said: Conflict | Suggestion) -> str:
    return said.sentence
