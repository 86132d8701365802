"""Why there is no gait, in words and as data."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from gaitopt.design.certificate import WorstRow
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
    "trunk roll": "sideways lean of the trunk",
    "trunk pitch": "lean of the trunk forward or back",
    "trunk yaw": "turn of the trunk",
    "torsion": "torsional friction under the foot",
    "impulse torsion": "torsional friction at the impact",
    "leg gap": "gap between the legs",
    "swing tilt": "tilt of the swing foot",
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
        where = " in every step" if self.family == "walking speed" else f" ({self.row})"
        if self.amount == 0.0:
            return words if self.family == "walking speed" else words + where
        return f"{words} by {self.amount:.2g} {self.unit}{where}"


@dataclass(frozen=True)
class Suggestion:
    """One change that alone makes the walk possible.

    Attributes:
        knob: field of `Task` or `Margins`, or a property of the robot.
        words: for a person.
        before, after: its value in the task, and one with which a gait was found.
        unit: of both, empty where there is none.
        cost: of that gait, which is feasible but not optimal [N²·m·s].
        gait: its parameters, shape (P,).
    """

    knob: str
    words: str
    before: float
    after: float
    unit: str
    cost: float
    gait: Array

    @property
    def sentence(self) -> str:
        """In words."""
        if self.knob == "impulse_cop":
            return f"without {self.words} it is feasible"
        unit = f" {self.unit}" if self.unit else ""
        change = f"{self.words} ({self.knob}) from {self.before:g} to {self.after:g}{unit}"
        fastest = " (about the fastest walk found)" if self.knob == "speed" else ""
        return f"changing {change}{fastest} makes it feasible"

    def record(self) -> dict[str, object]:
        """Return the suggestion as JSON-able data."""
        return {**asdict(self), "gait": self.gait.tolist()}


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
            said.append("the least violation found leaves " + _worst_sentence(self.worst))
        gives = [c for c in self.conflict if c.amount > 0.0]
        if gives:
            said.append(
                "the smallest relaxation found that admits a walk: "
                + "; ".join(map(_sentence, gives))
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
            "suggestions": [s.record() for s in self.suggestions],
            "gait": None if self.gait is None else self.gait.tolist(),
            "seconds": self.seconds,
        }


def _worst_sentence(row: WorstRow) -> str:
    if row.family != "walking speed":
        return row.sentence
    return f"a step that is {abs(row.value):.3g} m too {'short' if row.value > 0.0 else 'long'}"


def _sentence(said: Conflict | Suggestion) -> str:
    return said.sentence
