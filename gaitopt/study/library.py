"""A gait library on disk: a directory with a gait file per point, an index, and a journal.

manifest.json is what it is a library of. journal.jsonl has every result as it came: it is the truth
from which a sweep goes on. gaits/ has speed=0.85.npz and so on; index.csv, and index.parquet if
pyarrow is installed, one line per point.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gaitopt.errors import GaitFileError, GaitoptError, InputError
from gaitopt.gait.result import Gait
from gaitopt.gait.result_file import load_gait, save_gait
from gaitopt.study.footing import Footing, footing_of
from gaitopt.study.grid_points import GridPoints, Index
from gaitopt.study.index import Row, refused_row, write_index
from gaitopt.study.journal import NAME as JOURNAL
from gaitopt.study.journal import Journal, read_journal
from gaitopt.study.manifest import Record, points_of, read_manifest

GAITS = "gaits"
EVERY = 5.0  # s between two writings of the index, which takes long when it is long

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
        refusals: records of the points without a gait, with "sentences".
        seconds: of processor.
    """

    footings: dict[Index, Footing | None] = field(default_factory=dict)
    due: dict[Index, Index] = field(default_factory=dict)
    tried: set[Try] = field(default_factory=set)
    probed: set[Index] = field(default_factory=set)
    rows: dict[Index, Row] = field(default_factory=dict)
    refusals: dict[Index, dict[str, Any]] = field(default_factory=dict)
    seconds: float = 0.0

    def take(self, entry: Mapping[str, Any]) -> None:
        """Learn from one event of the journal."""
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
        if "refusal" in entry:
            self.refusals[point] = entry["refusal"]


@dataclass(frozen=True)
class Library:
    """A gait library.

    Attributes:
        directory: where it is.
        record: its manifest.
        points: its grid.
        state: what is known.
    """

    directory: Path
    record: Record
    points: GridPoints
    state: State

    @property
    def rows(self) -> list[Row]:
        """Lines of the index, in the order of the grid; points not reached yet are left out."""
        return list(index_rows(self.points, self.state))

    def gait(self, point: Index) -> Gait:
        """Return the gait of a point.

        Raises:
            GaitFileError: there is none, or it cannot be read.
        """
        if point not in self.state.rows:
            raise GaitFileError(f"'{self.directory}' holds no gait at {self.points.name(point)}")
        return load_gait(self.directory / str(self.state.rows[point]["file"]))


def open_library(directory: str | Path) -> Library:
    """Open a library for reading, finished or not.

    Raises:
        GaitFileError: the directory is no gait library.
        InputError: its journal is damaged.
    """
    folder = Path(directory)
    record = read_manifest(folder)
    state = State()
    for entry in read_journal(folder / JOURNAL):
        state.take(entry)
    return Library(folder, record, points_of(record), state)


def index_rows(points: GridPoints, state: State) -> Iterable[Row]:
    """Yield the lines of the index."""
    for point in sorted(points.order):
        if point in state.rows:
            yield state.rows[point]
        elif point in state.refusals:
            sentences = state.refusals[point].get("sentences") or ["no gait was found"]
            yield refused_row(points.values(point), str(sentences[0]))


class Writer:
    """The one who writes a library; a context manager. Nothing is ever half-written."""

    def __init__(self, directory: Path, points: GridPoints) -> None:
        self.directory, self.points, self.state = directory, points, State()
        self._journal = Journal(directory)
        for entry in self._journal.entries:
            self.state.take(entry)
        self._written, self._taken, self._stale = -EVERY, 0.0, True
        try:
            (directory / GAITS).mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cannot make '{directory / GAITS}': {(error.strerror or 'unknown').lower()}"
            ) from error

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self.write_index()
            else:  # the disk may be full; the index can be made again at any time
                with suppress(GaitoptError):
                    self.write_index()
        finally:
            self._journal.__exit__(None, None, None)

    def note(self, point: Index, **entry: object) -> None:
        """Write one event to the journal and learn from it.

        Raises:
            InputError: it cannot be written; what was written before is kept.
        """
        whole = {"point": list(point), **entry}
        try:
            self._journal.append(whole)
        except InputError as error:
            raise self._kept(error) from error
        self.state.take(whole)
        self._stale = True
        if time.monotonic() - self._written > max(EVERY, 20.0 * self._taken):
            self.write_index()

    def save(self, point: Index, gait: Gait, row: Row, **entry: object) -> None:
        """Write a gait, then the event.

        Raises:
            InputError: one of them cannot be written; what was written before is kept.
        """
        name = f"{GAITS}/{self.points.name(point)}.npz"
        try:
            save_gait(gait, self.directory / name)
        except InputError as error:
            raise self._kept(error) from error
        self.note(point, row={**row, "file": name}, **entry)

    def write_index(self) -> None:
        """Bring the index up to date.

        Raises:
            InputError: it cannot be written.
        """
        if not self._stale:
            return
        began = time.monotonic()
        try:
            write_index(list(index_rows(self.points, self.state)), self.directory)
        except InputError as error:
            raise self._kept(error) from error
        self._written = time.monotonic()
        self._taken, self._stale = self._written - began, False

    def _kept(self, error: InputError) -> InputError:
        reason = str(error).split(";")[0]
        return InputError(
            f"{reason}; the {len(self.state.rows)} gaits in '{self.directory}' are kept: make room "
            "or permission, and give the same command again to go on"
        )
