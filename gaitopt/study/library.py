"""A gait library on disk: a directory with a gait file per point, an index, and a journal.

manifest.json is what it is a library of. journal.jsonl has every result as it came: it is the truth
from which a sweep goes on. gaits/ has speed=0.85.npz and so on; index.csv, and index.parquet if
pyarrow is installed, one line per point.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from gaitopt.errors import GaitFileError, GaitoptError, InputError
from gaitopt.gait.result import Gait
from gaitopt.gait.result_file import save_gait
from gaitopt.study.grid_points import GridPoints, Index
from gaitopt.study.index import Row, faulty_row, write_index
from gaitopt.study.journal import NAME as JOURNAL
from gaitopt.study.journal import Journal, read_journal
from gaitopt.study.manifest import Record, points_of, read_manifest
from gaitopt.study.state import State, checked, faults_of, index_rows
from gaitopt.study.stored import REMEDY, digest, load_stored

GAITS = "gaits"
EVERY = 5.0  # s between two writings of the index, which takes long when it is long


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
        """Lines of the index, in the order of the grid; "status" tells what became of each point.

        Gait files are looked at, once: where one cannot be used, its fault is the status.
        """
        return [
            faulty_row(row, self.faults[point], REMEDY) if point in self.faults else row
            for point, row in index_rows(self.points, self.state)
        ]

    @cached_property
    def faults(self) -> dict[Index, str]:
        """What is wrong with the files of finished gaits, of those with which something is."""
        return faults_of(self.directory, self.points, self.state)

    def gait(self, point: Index) -> Gait:
        """Return the gait of a point.

        Raises:
            GaitFileError: there is none, its file cannot be read, was altered, or holds that of
                another point.
        """
        if point not in self.state.rows:
            raise GaitFileError(f"'{self.directory}' holds no gait at {self.points.name(point)}")
        file = self.directory / str(self.state.rows[point]["file"])
        written = self.state.digests.get(point, "")
        return load_stored(file, self.points.values(point), written)


def open_library(directory: str | Path) -> Library:
    """Open a library for reading, finished or not.

    Raises:
        GaitFileError: the directory is no gait library.
        InputError: its journal is damaged.
    """
    folder = Path(directory)
    record = read_manifest(folder)
    state = State()
    points = points_of(folder, record)
    _learn(state, read_journal(folder / JOURNAL), points, folder)
    return Library(folder, record, points, state)


def _learn(
    state: State, entries: Iterable[Mapping[str, Any]], points: GridPoints, directory: Path
) -> None:
    """Take over a journal.

    Raises:
        InputError: a line of it is not what a sweep writes.
    """
    for number, entry in enumerate(entries, start=1):
        try:
            state.take(checked(entry, points))
        except ValueError as error:
            raise InputError(
                f"line {number} of '{directory / JOURNAL}' is damaged: {error}; remove the line to "
                "compute its point again"
            ) from error


class Writer:
    """The one who writes a library; a context manager. Nothing is ever half-written.

    Attributes:
        directory: of the library.
        points: its grid.
        state: what is known. Gaits whose files cannot be used are not: their walks are, so that
            they need only be finished again.

    Raises:
        InputError: the directory cannot be written, its journal is damaged, or it is in use.
    """

    def __init__(self, directory: Path, points: GridPoints) -> None:
        self.directory, self.points, self.state = directory, points, State()
        self._journal = Journal(directory)
        try:
            _learn(self.state, self._journal.entries, points, directory)
        except BaseException:
            self._journal.__exit__(None, None, None)
            raise
        self._written, self._taken, self._stale = -EVERY, 0.0, True
        try:
            self._look()
            (directory / GAITS).mkdir(exist_ok=True)
        except BaseException as error:
            self._journal.__exit__(None, None, None)
            if isinstance(error, OSError):
                reason = (error.strerror or "unknown").lower()
                raise InputError(f"cannot make '{directory / GAITS}': {reason}") from error
            raise

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

    def _look(self) -> None:
        """Look at the gait files; write down what is news, in one event."""
        faults = faults_of(self.directory, self.points, self.state)
        for point in faults:
            del self.state.rows[point]
        if faults != self.state.faulty:
            self._append(min(self.points.order), faulty=[*faults.items()])

    def note(self, point: Index, **entry: object) -> None:
        """Write one event to the journal and learn from it.

        Raises:
            InputError: it cannot be written; what was written before is kept.
        """
        self._append(point, **entry)
        self._stale = True
        if time.monotonic() - self._written > max(EVERY, 20.0 * self._taken):
            self.write_index()

    def _append(self, point: Index, **entry: object) -> None:
        whole = {"point": list(point), **entry}
        try:
            self._journal.append(whole)
        except InputError as error:
            raise self._kept(error) from error
        self.state.take(whole)

    def save(self, point: Index, gait: Gait, row: Row, **entry: object) -> None:
        """Write a gait, then the event.

        Raises:
            InputError: one of them cannot be written; what was written before is kept.
        """
        name = f"{GAITS}/{self.points.name(point)}.npz"
        try:
            written = digest(save_gait(gait, self.directory / name))
        except InputError as error:
            raise self._kept(error) from error
        self.note(point, row={**row, "file": name}, digest=written, **entry)

    def write_index(self) -> None:
        """Bring the index up to date.

        Raises:
            InputError: it cannot be written.
        """
        if not self._stale:
            return
        began = time.monotonic()
        try:
            lines = [row for _, row in index_rows(self.points, self.state)]
            write_index(lines, self.directory)
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
