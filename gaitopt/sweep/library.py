"""A gait library on disk: a directory with a gait file per point, a table, and a database.

library.sqlite has what the library is a library of and all that is known of each point: it is the
truth from which a sweep goes on. gaits/ has speed=0.85.npz and so on; index.csv, and index.parquet
if pyarrow is installed, one line per point.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from os.path import exists, isdir, isfile
from pathlib import Path
from typing import Any

from gaitopt.atomic import is_leftover, make_directory, write_atomically
from gaitopt.bounds import GAIT, read_bounded
from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitFileError, GaitoptError, InputError, reason_of
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.plugin import extension_record
from gaitopt.gait.result import Gait
from gaitopt.settings import checked_arguments
from gaitopt.sweep.continuation import WarmStart, warm_start_of
from gaitopt.sweep.database import (
    DAMAGE,
    DATABASE,
    FORMAT,
    LOCK,
    Database,
    Record,
    difference,
    digest,
    grid_of,
    no_library,
    of_another_format,
    read_database,
)
from gaitopt.sweep.grid import Index, TaskGrid
from gaitopt.sweep.library_0_1 import MANIFEST, read_library_0_1
from gaitopt.sweep.table import (
    INFEASIBLE,
    NOT_COMPUTED,
    Row,
    bare_row,
    faulty_row,
    fits_column,
    write_table,
)

GAITS = "gaits"
PERIOD = 5.0  # s between two writings of the table, which takes long when it is long
HELD = 0.5  # s after a writing in which results wait for the next: the disk takes its time

MISSING, DAMAGED, MISFILED = "file missing", "file damaged", "file misplaced"
ALTERED = "file altered"  # a gait of its point, but not the one that was written
UNVOUCHED = "file unvouched"  # a gait of its point, but nothing tells that it was written so
UNREADABLE = "record damaged"  # of the point, in the database
FAULTS = (MISSING, DAMAGED, MISFILED, ALTERED, UNVOUCHED, UNREADABLE)
REMEDY = "give the command of the sweep again to have it made anew"


@dataclass(frozen=True, eq=False)
class PointState:
    """What is known of one point of a sweep.

    Attributes:
        explored: whether it was tried at all.
        walk: the best that is known.
        cold_started: whether it was tried from first guesses.
        due: the neighbour from which it is to be tried in this round of comparison.
        tried: neighbours from which it was tried, with the cost of their walks then.
        row: line of the table, of a finished gait.
        file_digest: of its file as it was written; empty where unknown, and then it does not count.
        refusal: record of a point without a gait, with "sentences".
        fault: one of `FAULTS` that the gait or the record had when the last sweep began, or empty.
        seconds: of processor.
    """

    explored: bool = False
    walk: WarmStart | None = None
    cold_started: bool = False
    due: Index | None = None
    tried: frozenset[tuple[Index, float]] = frozenset()
    row: Row | None = None
    file_digest: str = ""
    refusal: Mapping[str, Any] | None = None
    fault: str = ""
    seconds: float = 0.0

    def record(self) -> Record:
        """Return it as JSON-able data."""
        return {
            **vars(self),
            "walk": None if self.walk is None else self.walk.record(),
            "tried": sorted(self.tried),
        }


def point_state_of(record: Mapping[str, Any], grid: TaskGrid, point: Index) -> PointState:
    """Return the state of a point from its record.

    Raises:
        ValueError, KeyError, TypeError, ...: one of `DAMAGE`; it is none.
    """
    state = PointState(
        **{
            **record,
            "walk": None if record["walk"] is None else warm_start_of(record["walk"]),
            "due": None if record["due"] is None else tuple(record["due"]),
            "tried": frozenset((tuple(other), float(cost)) for other, cost in record["tried"]),
        }
    )
    others = [other for other, _ in state.tried] + ([] if state.due is None else [state.due])
    if not all(other in grid for other in others):
        raise ValueError("it is of a point that the sweep does not have")
    if state.walk is not None and len(state.walk.cost_gradient) != len(grid.axes):
        raise ValueError("its walk is of another sweep")
    if state.row is not None:
        _check_row(state.row, _file_of(grid, point))
    if state.refusal is not None and not all(
        isinstance(sentence, str) for sentence in state.refusal.get("sentences", ())
    ):
        raise ValueError("its sentences are no texts")
    numbers = (state.seconds, *(cost for _, cost in state.tried))
    flags = (state.explored, state.cold_started)
    texts = (state.file_digest, state.fault)
    if not (
        all(isinstance(text, str) for text in texts)
        and all(isinstance(flag, bool) for flag in flags)
        and all(map(math.isfinite, numbers))
    ):
        raise ValueError("it holds something else than it should")
    return state


def _check_row(row: object, file: str) -> None:
    if not isinstance(row, Mapping) or row.get("file") != file:
        raise ValueError(f"its line of the table is not that of '{file}'")
    for name, value in row.items():
        if not fits_column(str(name), value):
            raise ValueError(f"its line of the table has {name} {str(value)[:60]!r}")
    if not isinstance(row.get("status"), str) or not isinstance(row.get("kkt"), int | float):
        raise ValueError("its line of the table lacks its status")


def _file_of(grid: TaskGrid, point: Index) -> str:
    return f"{GAITS}/{grid.name(point)}.npz"


@dataclass(frozen=True)
class Library:
    """A gait library.

    Attributes:
        directory: where it is.
        record: its manifest.
        grid: its points.
        states: what is known of every point of the grid.
    """

    directory: Path
    record: Record
    grid: TaskGrid
    states: Mapping[Index, PointState]

    @cached_property
    def rows(self) -> list[Row]:
        """Lines of the table, in the order of the grid; "status" tells what became of each point.

        Gait files are looked at, once: where one cannot be used, its fault is the status.
        """
        return _rows(self.grid, self.states, self.faults)

    @cached_property
    def faults(self) -> dict[Index, str]:
        """What is wrong with records and with files of finished gaits, one of `FAULTS` each."""
        return _faults(self.directory, self.grid, self.states)

    @property
    def cost(self) -> tuple[str, str]:
        """Words and unit of the cost; libraries of version 0.1 do not say it."""
        task = self.record["first task"]
        cost = task.get("cost") if isinstance(task, Mapping) else None
        record = cost if isinstance(cost, Mapping) else extension_record(TorqueCost())
        return str(record.get("words")), str(record.get("unit"))

    @property
    def seconds(self) -> float:
        """Of processor, for everything."""
        return sum(state.seconds for state in self.states.values())

    def gait(self, point: Index) -> Gait:
        """Return the gait of a point.

        Raises:
            GaitFileError: there is none; its file is missing, damaged, altered, holds the gait of
                another point, or nothing tells what was written.
        """
        state = self.states.get(point, PointState())
        if state.row is None:
            raise GaitFileError(f"'{self.directory}' holds no gait at {self.grid.name(point)}")
        path = self.directory / str(state.row["file"])
        try:
            gait = load_gait(path)
            altered = state.file_digest != digest(read_bounded(path, GAIT))
        except OSError as error:
            raise GaitFileError(f"cannot read '{path}': {reason_of(error)}; {REMEDY}") from error
        except GaitFileError as error:
            reason = str(error).rsplit("; give one", 1)[0]
            raise GaitFileError(f"{reason}; {REMEDY}") from error
        if _values(gait) != self.grid.values(point):
            raise GaitFileError(f"'{path}' holds {_place(gait)}, not that of its name; {REMEDY}")
        if not state.file_digest:
            raise GaitFileError(f"the library does not vouch for '{path}': no digest; {REMEDY}")
        if altered:
            raise GaitFileError(f"'{path}' was altered since the sweep wrote it; {REMEDY}")
        return gait


@checked_arguments
def open_library(directory: str | Path) -> Library:
    """Open a library for reading, finished or not; one of version 0.1 is read as it is.

    Raises:
        GaitFileError: the directory is no gait library, or its manifest is damaged.
        InputError: the journal of a library of version 0.1 is damaged.
    """
    folder = Path(directory)
    found = _read(folder)
    if found is None:
        raise no_library(folder, DATABASE)
    record, records = found
    grid = grid_of(folder, record)
    return Library(folder, record, grid, _states(grid, records))


def _read(folder: Path) -> tuple[Record, dict[str, Any]] | None:
    found = read_database(folder)
    if found is None:
        return read_library_0_1(folder)
    if found[0].get("format") != FORMAT:
        raise of_another_format(folder / DATABASE, found[0].get("format"), FORMAT)
    return found


def _states(grid: TaskGrid, records: Mapping[str, Any]) -> dict[Index, PointState]:
    """Return what is known of every point; of one whose record is damaged, that it is."""
    states = {}
    for point in grid.order:
        states[point] = PointState()
        name = grid.name(point)
        if name in records:
            try:
                states[point] = point_state_of(records[name], grid, point)
            except DAMAGE:
                states[point] = PointState(fault=UNREADABLE)
    return states


def _rows(
    grid: TaskGrid, states: Mapping[Index, PointState], faults: Mapping[Index, str]
) -> list[Row]:
    rows = []
    for point in sorted(states):
        state, values = states[point], grid.values(point)
        if state.row is not None:
            row = dict(state.row)
        elif state.refusal is not None:
            sentences = state.refusal.get("sentences") or ["no gait was found"]
            row = bare_row(values, INFEASIBLE, str(sentences[0]))
        else:
            awaited = "the sweep has not come to it; its command goes on"
            row = bare_row(values, NOT_COMPUTED, awaited)
        rows.append(faulty_row(row, faults[point], REMEDY) if point in faults else row)
    return rows


def _faults(
    directory: Path, grid: TaskGrid, states: Mapping[Index, PointState]
) -> dict[Index, str]:
    found = {}
    for point, state in states.items():
        wrong = state.fault if not state.explored and state.fault == UNREADABLE else ""
        if state.row is not None:
            path = directory / str(state.row["file"])
            wrong = file_fault(path, grid.values(point), state.file_digest)
        if wrong:
            found[point] = wrong
    return found


def file_fault(path: Path, values: Mapping[str, float], written: str) -> str:
    """Return what is wrong with a gait file of a library, one of `FAULTS`, or an empty text.

    Args:
        values: of the swept quantities at its point.
        written: digest of what was written there; empty if unknown.
    """
    try:
        if exists(path) and not isfile(path):
            return DAMAGED  # a pipe would be waited for
        if written and digest(read_bounded(path, GAIT)) == written:
            return ""
        gait = load_gait(path)
    except FileNotFoundError:
        return MISSING
    except (OSError, ValueError, GaitFileError):
        return DAMAGED if exists(path) else MISSING
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


class Writer:
    """The one who writes a library; a context manager. Nothing is ever half-written.

    Results that come within `HELD` of each other are written together: that is what is lost if a
    process is killed. A library of version 0.1 is converted at once, its files left as they are.

    Args:
        directory: made if it does not exist.
        grid: of the sweep.
        record: of the sweep, as of `manifest_record`.

    Attributes:
        states: what is known of every point.
        faults: what is wrong with gaits that are to be finished again, by point.

    Raises:
        InputError: the directory cannot be written, is in use, or holds another sweep or other
            things.
        GaitFileError: its manifest is damaged.
    """

    def __init__(self, directory: Path, grid: TaskGrid, record: Record) -> None:
        self.directory, self.grid = directory, grid
        _claim(directory)
        self._database = Database(directory)
        try:
            self.states, self.faults = self._begun(record)
            (directory / GAITS).mkdir(exist_ok=True)
        except BaseException as error:
            self._database.close(leave=False)
            if isinstance(error, OSError):
                gaits = directory / GAITS
                raise InputError(f"cannot make '{gaits}': {reason_of(error)}") from error
            raise
        self._written, self._taken, self._stale = -PERIOD, 0.0, True
        self._pending: dict[Index, PointState] = {}
        self._noted = -HELD  # when they were last written

    def _begun(self, record: Record) -> tuple[dict[Index, PointState], dict[Index, str]]:
        """Return states and faults, from whichever files there are; write down what is news."""
        found = _read(self.directory)
        if found is None:
            self._database.write({}, record)
            return {point: PointState() for point in self.grid.order}, {}
        there, records = found
        try:
            other = difference(there, record)
        except DAMAGE as error:
            raise GaitFileError(
                f"the manifest of '{self.directory}' is damaged in some of its entries; make the "
                "library again, in another directory"
            ) from error
        if other is not None:
            raise InputError(
                f"'{self.directory}' holds another sweep: {other}; give another directory, or ask "
                "for the same again"
            )
        states = _states(self.grid, records)
        faults = _faults(self.directory, self.grid, states)
        told = {p: replace(state, fault=faults.get(p, "")) for p, state in states.items()}
        if there["format"] < FORMAT:  # a library of version 0.1
            self._write(told, record)
        else:
            self._write({p: told[p] for p in told if told[p].fault != states[p].fault}, None)
        return told, faults

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self.flush()
                self.write_table()
            else:  # the disk may be full; the table can be made again at any time
                with suppress(GaitoptError):
                    self.flush()
                    self.write_table()
        finally:
            self._database.close()

    def has_gait(self, point: Index) -> bool:
        """Whether a point has a gait whose file can be used."""
        return self.states[point].row is not None and point not in self.faults

    def note(self, changes: Mapping[Index, PointState]) -> None:
        """Write what is new of some points, all or none of it, at once or soon.

        Raises:
            InputError: it cannot be written; what was written before is kept.
        """
        self.states.update(changes)
        self._pending.update(changes)
        for point in changes:
            if self.states[point].row is None:  # nothing is left of which it could be a fault
                self.faults.pop(point, None)
        self._stale = True
        if time.monotonic() - self._noted > HELD:
            self.flush()
        if time.monotonic() - self._written > max(PERIOD, 20.0 * self._taken):
            self.write_table()

    def flush(self) -> None:
        """Write what was noted.

        Raises:
            InputError: it cannot be written; what was written before is kept.
        """
        try:
            self._write(self._pending, None)
        except InputError as error:
            raise self._kept(error) from error
        self._pending = {}
        self._noted = time.monotonic()

    def save(self, point: Index, file: bytes, row: Row, state: PointState) -> None:
        """Write the file of a gait, and note its line and the state of its point.

        Raises:
            InputError: one of them cannot be written; what was written before is kept.
        """
        name = _file_of(self.grid, point)
        try:  # its digest vouches for it: should the power fail, it is made anew
            write_atomically(self.directory / name, file, synced=False)
        except InputError as error:
            raise self._kept(error) from error
        self.note({point: replace(state, row={**row, "file": name}, file_digest=digest(file))})
        self.faults.pop(point, None)

    def write_table(self) -> None:
        """Bring index.csv and index.parquet up to date.

        Raises:
            InputError: they cannot be written.
        """
        if not self._stale:
            return
        began = time.monotonic()
        try:
            write_table(_rows(self.grid, self.states, self.faults), self.directory)
        except InputError as error:
            raise self._kept(error) from error
        self._written = time.monotonic()
        self._taken, self._stale = self._written - began, False

    def _write(self, states: Mapping[Index, PointState], manifest: Record | None) -> None:
        records = {self.grid.name(point): state.record() for point, state in states.items()}
        if records or manifest is not None:
            self._database.write(records, manifest)

    def _kept(self, error: InputError) -> InputError:
        reason = str(error).split(";")[0]
        if not isdir(self.directory):
            return InputError(
                f"{reason}; the directory '{self.directory}' was removed or moved meanwhile; put "
                "it back and give the same command again to go on, or begin anew without it"
            )
        gaits = sum(self.has_gait(point) for point in self.states if point not in self._pending)
        kept = "1 gait is" if gaits == 1 else f"{gaits} gaits are"
        return InputError(
            f"{reason}; {kept} kept in '{self.directory}': make room or permission, and give the "
            "same command again to go on"
        )


def _claim(directory: Path) -> None:
    """Make a directory for a library, or see that it holds one already and nothing else."""
    make_directory(directory)
    try:
        others = sorted(e.name for e in directory.iterdir() if not is_leftover(e))
    except OSError as error:
        raise InputError(f"cannot read the directory '{directory}': {reason_of(error)}") from error
    if DATABASE in others or MANIFEST in others:
        return
    others = [name for name in others if name != LOCK]
    if others:
        raise InputError(
            f"'{directory}' holds '{others[0]}' but no sweep; give an empty or a new directory"
        )
