"""The database of a gait library: one SQLite file that is whole whenever its writer ends.

    manifest   one record: what the library is a library of
    points     one record per point of the grid: its walk, tries, line of the table, or refusal

Records are JSON. Each counts only with its digest, so that what was damaged on the disk is told
from what was written. Any program may read the file while a sweep writes it.
The manifest tells in what two sweeps differ.
"""

from __future__ import annotations

import hashlib
import json
import re
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict
from os.path import exists, isfile
from pathlib import Path
from types import TracebackType
from typing import Any

from gaitopt.actuators.motors import motor_table_of
from gaitopt.atomic import cannot_go_on
from gaitopt.bounds import DATABASE as MOST_BYTES
from gaitopt.bounds import is_finite, shortened, shown, too_large
from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.parameters import merged
from gaitopt.design.options import DesignOptions
from gaitopt.errors import GaitFileError, InputError, reason_of
from gaitopt.gait.gait_file import gait_inside
from gaitopt.gait.task import Task, task_record
from gaitopt.model.import_options import choices_from_record, choices_record
from gaitopt.sweep.grid import Axis, Index, RobotSource, TaskGrid
from gaitopt.version import __version__

DATABASE = "library.sqlite"
LOCK = "writer.lock"

_SCHEMA = """
    CREATE TABLE IF NOT EXISTS manifest
        (id INTEGER PRIMARY KEY CHECK (id = 0), record TEXT NOT NULL, digest TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS points
        (name TEXT PRIMARY KEY, record TEXT NOT NULL, digest TEXT NOT NULL);
"""
_WAIT = 30.0  # s for another process to end a transaction, which takes milliseconds


def digest(data: bytes) -> str:
    """Return a short text that differs between contents."""
    return hashlib.sha256(data).hexdigest()[:32]


def read_database(directory: Path) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """Return the manifest of a library and the records of its points by name, None if not begun.

    The record of a point that is damaged is None.

    Raises:
        GaitFileError: the file cannot be read, or its manifest is damaged.
    """
    path = directory / DATABASE
    if not exists(path):
        return None
    try:
        reason = too_large(path.stat().st_size, MOST_BYTES) if isfile(path) else "it is no file"
        if reason:
            raise GaitFileError(f"cannot read '{path}': {reason}")
        with closing(_connected(path)) as connection:
            return _read(connection, path)
    except (sqlite3.Error, OSError, OverflowError, UnicodeDecodeError) as error:
        raise GaitFileError(
            f"cannot read '{path}': {reason_of(error)}; make the library again, "
            "in another directory"
        ) from error


def _connected(path: Path, mode: str = "rw") -> sqlite3.Connection:
    return sqlite3.connect(
        f"{path.absolute().as_uri()}?mode={mode}", uri=True, timeout=_WAIT, isolation_level=None
    )


def _read(
    connection: sqlite3.Connection, path: Path
) -> tuple[dict[str, Any], dict[str, Any]] | None:
    tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_master")}
    if not {"manifest", "points"} <= tables:
        return None  # its first writer was killed before it had begun
    with _transaction(connection, "DEFERRED"):  # both tables as they were at one time
        manifests = connection.execute("SELECT record, digest FROM manifest").fetchall()
        rows = connection.execute("SELECT name, record, digest FROM points").fetchall()
    if not manifests:
        return None
    manifest = _valid("", *manifests[0])
    if manifest is None:
        raise GaitFileError(
            f"the manifest of '{path}' is damaged; make the library again, in another directory"
        )
    return manifest, {str(name): _valid(name, record, check) for name, record, check in rows}


def _valid(name: object, record: object, check: object) -> Any:
    """Return what a record holds if its digest is right, else None."""
    if not isinstance(record, str) or check != record_digest(str(name), record):
        return None
    try:
        found = json.loads(record)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def record_digest(name: str, record: str) -> str:
    """Return the digest that vouches for the record of a point; the manifest has an empty name."""
    return digest(f"{name}\n{record}".encode(errors="surrogatepass"))


class Database:
    """A database open for writing, by one process at a time; a context manager.

    Raises:
        InputError: it cannot be written, or is in use by another process.
    """

    def __init__(self, directory: Path) -> None:
        self.path, lock = directory / DATABASE, directory / LOCK
        made = [] if exists(lock) else [lock]
        self._lock = _lock(directory)
        # looked at under the lock: until then another sweep may have written it
        self._made = made if exists(self.path) else [self.path, *made]
        try:
            self._connection = _connected(self.path, "rwc")
        except sqlite3.Error as error:
            self._lock.close()
            raise cannot_go_on(self.path, error) from error
        try:
            self._connection.executescript(_SCHEMA)
        except sqlite3.Error as error:
            self.close(leave=False)
            if isinstance(error, sqlite3.OperationalError):
                raise cannot_go_on(self.path, error) from error
            raise InputError(
                f"cannot write '{self.path}': {reason_of(error)}; move it away, or give another "
                "directory"
            ) from error

    def __enter__(self) -> Database:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self.close()

    def close(self, leave: bool = True) -> None:
        """Let others write.

        Args:
            leave: whether to leave files that were not there before.
        """
        with suppress(sqlite3.Error):
            self._connection.close()
        for path in [] if leave else self._made:  # while nobody else can have begun to write
            with suppress(OSError):
                path.unlink()
        self._lock.close()

    def write(
        self, points: Mapping[str, Mapping[str, Any]], manifest: Mapping[str, Any] | None = None
    ) -> None:
        """Write records of points, and the manifest if given: all of them, or none.

        Raises:
            InputError: they cannot be written; the database is as before.
        """
        try:
            with _transaction(self._connection, "IMMEDIATE"):
                if manifest is not None:
                    text = json.dumps(manifest, allow_nan=False)
                    self._connection.execute(
                        "INSERT OR REPLACE INTO manifest VALUES (0, ?, ?)",
                        (text, record_digest("", text)),
                    )
                for name, record in points.items():
                    text = json.dumps(record, allow_nan=False)
                    self._connection.execute(
                        "INSERT OR REPLACE INTO points VALUES (?, ?, ?)",
                        (name, text, record_digest(name, text)),
                    )
        except sqlite3.Error as error:
            raise cannot_go_on(self.path, error) from error


@contextmanager
def _transaction(connection: sqlite3.Connection, kind: str) -> Iterator[None]:
    connection.execute(f"BEGIN {kind}")
    try:
        yield
        connection.execute("COMMIT")
    except BaseException:
        with suppress(sqlite3.Error):  # a full disk has rolled it back already
            connection.execute("ROLLBACK")
        raise


def _lock(directory: Path) -> sqlite3.Connection:
    """Refuse a second writer; the system unlocks when a process ends, however it ends."""
    # The lock of another, empty database serves, which SQLite has on every system.
    path = directory / LOCK
    try:
        connection = sqlite3.connect(path, timeout=0.0, isolation_level=None)
        try:
            connection.execute("BEGIN EXCLUSIVE")
        except BaseException:
            connection.close()
            raise
    except sqlite3.Error as error:
        if "locked" in str(error):
            raise InputError(
                f"'{directory}' is in use by another sweep; wait for it, or give another directory"
            ) from error
        raise cannot_go_on(path, error) from error
    return connection


FORMAT = 3
"""Of the records; version 0.1 wrote 2, in other files."""

Record = dict[str, Any]
DAMAGE = (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError)
"""What reading a record raises that is not what a sweep writes."""


def manifest_record(
    grid: TaskGrid, robot: RobotSource, tasks: Mapping[Index, Task], options: DesignOptions
) -> Record:
    """Return what decides the gaits of a sweep, JSON-able: grid, robot, options, first task.

    The other tasks follow from the first and the axes. What a caller's own `task_at` makes of the
    axes beyond that is not seen.
    """
    solver = options.solver
    record = {
        "format": FORMAT,
        "gaitopt": __version__,
        "axes": {axis.name: list(axis.values) for axis in grid.axes},
        "seeds": [list(seed) for seed in grid.seeds],
        "first task": task_record(tasks[grid.order[0]]),
        "robot": robot_source_record(robot),
        "options": {
            "solver": solver.name,
            "solver options": asdict(solver),  # type: ignore[call-overload]
            "refine": options.refine,
            "differences": options.differences,
            "approach": options.approach,
        },
    }
    return dict(json.loads(json.dumps(record)))


def robot_source_record(robot: RobotSource) -> Record:
    """Return a robot without the changes of a point, JSON-able."""
    return {
        "choices": choices_record(robot.choices),
        "spec": None if robot.spec is None else asdict(robot.spec),
        "urdf": robot.urdf,
        **({} if robot.motors is None else {"motors": robot.motors.record()}),
    }


def grid_of(directory: Path, record: Record) -> TaskGrid:
    """Return the grid of a record.

    Args:
        directory: where it was read, for messages.

    Raises:
        GaitFileError: the record does not say it.
    """
    try:
        axes = tuple(Axis(name, tuple(values)) for name, values in record["axes"].items())
        grid = TaskGrid(axes, tuple(tuple(seed) for seed in record["seeds"]))
        for seed in grid.seeds:
            grid.values(seed)
    except (*DAMAGE, InputError) as error:
        raise damaged(directory, "its axes and seeds", error) from error
    return grid


def robot_source_of(directory: Path, record: Record) -> RobotSource:
    """Return the robot of a record, without the changes of a point.

    Raises:
        GaitFileError: the record does not say it.
    """
    try:
        robot = record["robot"]
        urdf, choices, spec = str(robot["urdf"]), robot["choices"], robot["spec"]
        return RobotSource(
            urdf,
            choices_from_record(choices),
            None if spec is None else merged(biped13(), spec),
            motors=motor_table_of(robot["motors"]) if "motors" in robot else None,
        )
    except (*DAMAGE, InputError) as error:
        raise damaged(directory, "its robot", error) from error


def damaged(directory: Path, what: str, error: Exception) -> GaitFileError:
    """Return the error that a part of the manifest of a library cannot be used."""
    reason = str(error) if isinstance(error, InputError) else "they are not there, or of no use"
    return GaitFileError(
        f"the manifest of '{directory}' is damaged in {what}: {reason}; make the library again, in "
        "another directory"
    )


def no_library(directory: Path, file: str) -> GaitFileError:
    """Return the error that a directory has no file that makes it a library."""
    return GaitFileError(
        f"'{directory}' is no gait library: it has no readable {file}{gait_inside(directory)}; "
        "give a directory that gaitopt sweep has written"
    )


def of_another_format(path: Path, found: object, form: int) -> GaitFileError:
    """Return the error that a file of a library is of another format than the one that is read."""
    newer = is_finite(found) and found > form
    advice = "install a newer gaitopt" if newer else "make the library again, in another directory"
    return GaitFileError(
        f"the format of '{path}' is {shown(found)}, this gaitopt reads {form}; {advice}"
    )


Entry = tuple[str, ...]
Found = tuple[Entry, Any, Any]

_PARTS = {
    ("first task", "margins"): "limit",
    ("first task", "geometry"): "",
    ("first task",): "",
    ("options", "solver options", "travel"): "solver option",
    ("options", "solver options", "certify"): "second solver's option",
    ("options", "solver options"): "solver option",
    ("options",): "option",
}
"""What to call the entries below each part of a record; the longest that fits counts."""


def difference(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    """Return the first thing in which two records of sweeps differ, the robot first, or None.

    Robots are the same if their URDF and what was chosen about it are: the specification from which
    a URDF was made counts only where a sweep changes it.

    Args:
        there, asked: as of `manifest_record`. Of a record of version 0.1, whose solvers had other
            options, only those count that both have.
    """
    if there["format"] < FORMAT:
        there = {**there, "options": _aligned(there["options"], asked["options"])}
    return _robot(there, asked) or _points(there, asked) or _rest(there, asked)


def _robot(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    a, b = there["robot"], asked["robot"]
    names = _name(a["urdf"]), _name(b["urdf"])
    same = a["urdf"] == b["urdf"]
    if names[0] != names[1]:
        return f"it is of the robot '{names[0]}', asked for is '{names[1]}'"
    varied = any("." in axis and axis.split(".")[0] in (a["spec"] or ()) for axis in there["axes"])
    if not same or varied:
        found = first_difference(a["spec"], b["spec"])
        if found is not None and a["spec"] and b["spec"]:
            return f"of its robot '{names[0]}', {_compared(*found)}"
        if not same or found is not None:
            return f"it is of another robot named '{names[0]}': their URDF or tables differ"
    found = first_difference(a.get("motors"), b.get("motors"))
    if found is not None:
        return f"of its robot's motors, {_compared(*found)}"
    found = first_difference(a["choices"], b["choices"])
    return None if found is None else f"of what was chosen about its robot, {_compared(*found)}"


def _points(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    if [*there["axes"]] != [*asked["axes"]]:
        return f"it is over {', '.join(there['axes'])}, asked for is {', '.join(asked['axes'])}"
    found = first_difference(there["axes"], asked["axes"])
    if found is not None:
        (name, *_), old, new = found
        return f"its values of {name} are {shortened(old)}, asked for are {shortened(new)}"
    if there["seeds"] != asked["seeds"]:
        return "it began at other points than is asked for"
    return None


def _rest(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    parts = ("first task", "options")
    found = first_difference({p: there[p] for p in parts}, {p: asked[p] for p in parts})
    if found is None:
        return None
    path, old, new = found
    whole = max((p for p in _PARTS if path[: len(p)] == p), key=len)
    return f"its {_compared((_PARTS[whole], *path[len(whole) :]), old, new)}"


def _aligned(there: Any, asked: Any) -> Any:
    """Return a record with the entries of another, with its own values where it has them."""
    if not (isinstance(there, Mapping) and isinstance(asked, Mapping)):
        return there
    return {key: _aligned(there[key], v) if key in there else v for key, v in asked.items()}


def first_difference(there: Any, asked: Any) -> Found | None:
    """Return the first entry in which two records differ: its path and both values."""
    if isinstance(there, Mapping) and isinstance(asked, Mapping):
        for key in dict.fromkeys([*asked, *there]):
            found = first_difference(there.get(key), asked.get(key))
            if found is not None:
                path, old, new = found
                return (key, *path), old, new
        return None
    return None if there == asked else ((), there, asked)


def _compared(path: Entry, old: object, new: object) -> str:
    name = " ".join(filter(None, path))
    return f"{name} is {shortened(old)}, asked for is {shortened(new)}"


def _name(urdf: str) -> str:
    found = re.search(r"<(?:robot|mujoco)\b[^>]*?\b(?:name|model)\s*=\s*[\"']([^\"']*)", urdf)
    return found[1] if found else "without a name"
