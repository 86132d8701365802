"""A gait library on disk: a directory with a gait file per point, an index, and a journal.

manifest.json is what it is a library of. journal.jsonl has every result as it came: it is the truth
from which a sweep goes on. gaits/ has speed=0.85.npz and so on; index.csv, and index.parquet if
pyarrow is installed, one line per point.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any

from gaitopt.bounds import JOURNAL as JOURNAL_BYTES
from gaitopt.bounds import read_bounded
from gaitopt.errors import GaitFileError, GaitoptError, InputError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.result import Gait
from gaitopt.sweep.grid import GridPoints, Index
from gaitopt.sweep.manifest import Record, points_of, read_manifest
from gaitopt.sweep.table import Row, awaited_row, faulty_row, fits_column, refused_row, write_index
from gaitopt.sweep.warm_start import Footing, footing_of

MISSING, DAMAGED, MISFILED = "file missing", "file damaged", "file misplaced"
ALTERED = "file altered"  # a gait of its point, but not the one that was written
UNVOUCHED = "file unvouched"  # a gait of its point, but nothing tells that it was written so
FAULTS = (MISSING, DAMAGED, MISFILED, ALTERED, UNVOUCHED)
REMEDY = "give the command of the sweep again to have it made anew"


def digest(path: Path) -> str:
    """Return a short text that differs between the contents of files.

    Raises:
        OSError: the file cannot be read.
    """
    return hashlib.sha256(path.read_bytes()).hexdigest()[:32]


def load_stored(path: Path, values: Mapping[str, float], written: str) -> Gait:
    """Return a gait of a library.

    Args:
        path: of its file.
        values: of the swept quantities, by name, at the point it is filed under.
        written: digest of what was written there; empty if unknown.

    Raises:
        GaitFileError: the file is missing, damaged, altered, holds the gait of another point, or
            nothing tells what was written.
    """
    try:
        gait = load_gait(path)
        altered = written != digest(path)
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise GaitFileError(f"cannot read '{path}': {reason}; {REMEDY}") from error
    except GaitFileError as error:
        reason = str(error).rsplit("; give one", 1)[0]
        raise GaitFileError(f"{reason}; {REMEDY}") from error
    if _values(gait) != dict(values):
        raise GaitFileError(f"'{path}' holds {_place(gait)}, not that of its name; {REMEDY}")
    if not written:
        raise GaitFileError(f"the journal does not vouch for '{path}': no digest; {REMEDY}")
    if altered:
        raise GaitFileError(f"'{path}' was altered since the sweep wrote it; {REMEDY}")
    return gait


def fault(path: Path, values: Mapping[str, float], written: str) -> str | None:
    """Return what is wrong with a gait file of a library, one of `FAULTS`, or None.

    Args:
        path: of the file.
        values: of the swept quantities at its point.
        written: digest of what was written there; empty if unknown.
    """
    try:
        if written and digest(path) == written:
            return None
        gait = load_gait(path)
    except FileNotFoundError:
        return MISSING
    except (OSError, GaitFileError):
        return DAMAGED if path.exists() else MISSING
    if _values(gait) != dict(values):
        return MISFILED
    return ALTERED if written else UNVOUCHED


def _values(gait: Gait) -> object:
    swept = gait.meta.get("sweep")
    return swept.get("values") if isinstance(swept, Mapping) else None


def _place(gait: Gait) -> str:
    values = _values(gait)
    if not isinstance(values, Mapping):
        return "a gait that no sweep has made"
    return "the gait of " + ", ".join(f"{name}={value}" for name, value in values.items())


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


JOURNAL = "journal.jsonl"


def read_journal(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the events of a journal; a last line that was never completed is left out.

    Raises:
        InputError: the file cannot be read, or is damaged before its last line.
    """
    for entry, _ in _entries(path):
        yield entry


def _entries(path: Path) -> Iterator[tuple[dict[str, Any], int]]:
    """Yield events and the length of the file up to the end of each."""
    try:
        data = read_bounded(path, JOURNAL_BYTES) if path.exists() else b""
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(f"cannot read '{path}': {reason}") from error
    end = 0
    lines = data.split(b"\n")
    for number, line in enumerate(lines[:-1], start=1):
        end += len(line) + 1
        try:
            entry = json.loads(line)
        except (ValueError, RecursionError) as error:
            if number == len(lines) - 1:
                return
            raise InputError(
                f"line {number} of '{path}' is damaged; remove the line to compute its point again"
            ) from error
        yield entry, end


class Journal:
    """A journal open for writing, by one process at a time; a context manager.

    Raises:
        InputError: it cannot be written, is damaged, or is in use.
    """

    def __init__(self, directory: Path) -> None:
        self.path = directory / JOURNAL
        self.entries: list[dict[str, Any]] = []
        try:
            self._file = self.path.open("ab", buffering=0)
        except OSError as error:
            raise _unwritable(self.path, error) from error
        try:
            _lock(self._file.fileno(), self.path)
            self._file.truncate(self._read())  # read behind the lock: nobody appends meanwhile
        except BaseException as error:
            self._file.close()
            if isinstance(error, OSError):
                raise _unwritable(self.path, error) from error
            raise

    def _read(self) -> int:
        """Take over the events there are; return the length of the file up to the last end."""
        end = 0
        for entry, length in _entries(self.path):
            self.entries.append(entry)
            end = length
        return end

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self._file.close()

    def append(self, entry: dict[str, Any]) -> None:
        """Write an event, wholly or not at all.

        Raises:
            InputError: it cannot be written; the journal is as before.
        """
        line = json.dumps(entry, allow_nan=False).encode() + b"\n"
        before = os.fstat(self._file.fileno()).st_size
        try:
            written = 0
            while written < len(line):
                written += self._file.write(line[written:]) or 0
            os.fsync(self._file.fileno())
        except BaseException as error:
            with suppress(OSError):
                self._file.truncate(before)
            if isinstance(error, OSError):
                raise _unwritable(self.path, error) from error
            raise


def _unwritable(path: Path, error: OSError) -> InputError:
    reason = (error.strerror or "unknown reason").lower()
    return InputError(f"cannot write '{path}': {reason}")


def _lock(descriptor: int, path: Path) -> None:
    """Refuse a second writer; the system unlocks when a process ends, however it ends."""
    try:
        import fcntl
    except ImportError:  # not a POSIX system: the user must see to it
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise InputError(
            f"'{path.parent}' is in use by another sweep; wait for it, or give another directory"
        ) from error


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
