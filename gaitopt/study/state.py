"""What a sweep knows, as its journal tells it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gaitopt.study.footing import Footing, footing_of
from gaitopt.study.grid_points import GridPoints, Index
from gaitopt.study.index import Row, awaited_row, fits_column, refused_row
from gaitopt.study.stored import fault

Try = tuple[Index, Index, float]
"""Point, the neighbour it was tried from, and that neighbour's cost then."""


@dataclass
class State:
    """What a sweep knows.

    Attributes:
        footings: walks; None where none has been found so far.
        due: points that are to be tried in this round, each from a neighbour.
        tried: what has been tried, so that it is not tried again.
        probed: points that were tried from first guesses.
        rows: lines of the index of finished gaits.
        digests: of their files as they were written; empty where unknown, and then they do not
            count.
        faulty: what was wrong with such files when the last sweep began, as of `faults_of`.
        refusals: records of the points without a gait, with "sentences".
        seconds: of processor.
    """

    footings: dict[Index, Footing | None] = field(default_factory=dict)
    due: dict[Index, Index] = field(default_factory=dict)
    tried: set[Try] = field(default_factory=set)
    probed: set[Index] = field(default_factory=set)
    rows: dict[Index, Row] = field(default_factory=dict)
    digests: dict[Index, str] = field(default_factory=dict)
    faulty: dict[Index, str] = field(default_factory=dict)
    refusals: dict[Index, dict[str, Any]] = field(default_factory=dict)
    seconds: float = 0.0

    def take(self, entry: Mapping[str, Any]) -> None:
        """Learn from one event of the journal, which is as `checked` or made by this gaitopt."""
        point = tuple(entry["point"])
        self.seconds += float(entry.get("seconds", 0.0))
        self.due |= {tuple(p): tuple(q) for p, q in entry.get("round", ())}
        if "tried" in entry:
            self.due.pop(point, None)
            self.tried |= {(point, tuple(q), cost) for q, cost in entry["tried"]}
        if "footing" in entry:
            known = entry["footing"]
            self.footings[point] = None if known is None else footing_of(known)
        if entry.get("probed"):
            self.probed.add(point)
        if "row" in entry:
            self.rows[point] = entry["row"]
            self.digests[point] = entry.get("digest", "")
        if "faulty" in entry:
            self.faulty = {tuple(p): wrong for p, wrong in entry["faulty"]}
        if "refusal" in entry:
            self.refusals[point] = entry["refusal"]


def checked(entry: object, points: GridPoints) -> Mapping[str, Any]:
    """Return an event of a journal if it has the shape of one.

    Args:
        entry: a line of it, read as JSON.
        points: of the sweep.

    Raises:
        ValueError: it is none.
    """
    if not isinstance(entry, Mapping):
        raise ValueError("it is no event")
    try:
        trial = State()
        trial.take(entry)
        own = {tuple(entry["point"])}
        named = own | {p for pair in trial.due.items() for p in pair} | {*trial.digests}
        named |= {*trial.faulty} | {q for _, q, _ in trial.tried}
        for point in named:
            for index, axis in zip(point, points.axes, strict=True):
                if not (type(index) is int and 0 <= index < len(axis.values)):
                    raise ValueError("it is of a point that the sweep does not have")
        for point, row in trial.rows.items():
            _check_row(row, f"gaits/{points.name(point)}.npz")
        for refusal in trial.refusals.values():
            if not all(isinstance(s, str) for s in refusal.get("sentences", ())):
                raise ValueError("its sentences are no texts")
        texts = (*trial.digests.values(), *trial.faulty.values())
        numbers = (trial.seconds, *(float(cost) for _, _, cost in trial.tried))
        if not all(isinstance(t, str) for t in texts) or not all(map(math.isfinite, numbers)):
            raise ValueError("it holds something else than it should")
    except (KeyError, TypeError, AttributeError, IndexError, OverflowError) as error:
        raise ValueError("it has not the shape of an event") from error
    return entry


def _check_row(row: object, file: str) -> None:
    if not isinstance(row, Mapping) or row.get("file") != file:
        raise ValueError(f"its line of the index is not that of '{file}'")
    for name, value in row.items():
        if not fits_column(str(name), value):
            raise ValueError(f"its line of the index has {name} {str(value)[:60]!r}")
    if not isinstance(row.get("status"), str) or not isinstance(row.get("kkt"), int | float):
        raise ValueError("its line of the index lacks its status")


def index_rows(points: GridPoints, state: State) -> Iterator[tuple[Index, Row]]:
    """Yield each point of the grid with its line of the index."""
    for point in sorted(points.order):
        if point in state.rows:
            yield point, state.rows[point]
        elif point in state.refusals:
            sentences = state.refusals[point].get("sentences") or ["no gait was found"]
            yield point, refused_row(points.values(point), str(sentences[0]))
        else:
            yield point, awaited_row(points.values(point))


def faults_of(directory: Path, points: GridPoints, state: State) -> dict[Index, str]:
    """Return what is wrong with gait files, one of `stored.FAULTS` each, by point."""
    found = {}
    for point, row in state.rows.items():
        file, values = directory / str(row["file"]), points.values(point)
        wrong = fault(file, values, state.digests.get(point, ""))
        if wrong is not None:
            found[point] = wrong
    return found
