"""Why there is no gait, in words and as data."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from gaitopt.design.certificate import WorstRow
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from gaitopt.units import digits


@dataclass(frozen=True)
class Conflict:
    """A constraint family that stands in the way.

    Attributes:
        family, words: its name, and what a person calls it.
        amount, unit: by how much its limits give in the smallest relaxation; zero for a family
            that holds but pushes the others.
        row: joint and instant where it pushes most.
        share: of all push (multipliers of the smallest relaxation), from 0 to 1.
    """

    family: str
    words: str
    amount: float
    unit: str
    row: str
    share: float

    @property
    def sentence(self) -> str:
        """In words."""
        where = " in every step" if self.family == "walking speed" else f" ({self.row})"
        if self.amount == 0.0:
            return self.words if self.family == "walking speed" else self.words + where
        return f"{self.words} by {self.amount:.2g} {self.unit}{where}"


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
        """Of the walk [N²·m·s]."""
        return self.found.solution.cost

    @property
    def sentence(self) -> str:
        """In words."""
        proven = "certified" if self.options.refine else "optimal (at its samples)"
        walk = f"a {proven} walk of cost {self.cost:.5g} N²·m·s"
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


@dataclass(frozen=True)
class Diagnosis:
    """Why there is no gait.

    Attributes:
        impossible: sentences on what no motion can meet, if that was seen at once.
        violation: least violation found, scaled.
        worst: the row that has it; None where nothing could be evaluated.
        conflict: families in the way, most first; empty if a gait was found after all.
        suggestions: single changes that suffice, most promising first; if none does, several
            changes that do together.
        tried: what was changed in vain, by the names of `Suggestion.knob`.
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

    @property
    def families(self) -> tuple[str, ...]:
        """Names of the families in conflict."""
        return tuple(c.family for c in self.conflict)

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
    if row.family != "walking speed":
        return row.sentence
    return f"a step that is {abs(row.value):.3g} m too {'short' if row.value > 0.0 else 'long'}"
