"""The database of a gait library: one SQLite file that is whole whenever its writer ends.

    manifest   one record: what the library is a library of
    points     one record per point of the grid: its walk, tries, line of the table, or refusal

Records are JSON. Each counts only with its digest, so that what was damaged on the disk is told
from what was written. Any program may read the file while a sweep writes it.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from gaitopt.bounds import DATABASE as MOST_BYTES
from gaitopt.bounds import too_large
from gaitopt.errors import GaitFileError, InputError, reason_of

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
    if not path.exists():
        return None
    try:
        reason = too_large(path.stat().st_size, MOST_BYTES) if path.is_file() else "it is no file"
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
        made = [] if lock.exists() else [lock]
        self._lock = _lock(directory)
        # looked at under the lock: until then another sweep may have written it
        self._made = made if self.path.exists() else [self.path, *made]
        try:
            self._connection = _connected(self.path, "rwc")
        except sqlite3.Error as error:
            self._lock.close()
            raise self._unwritable(error) from error
        try:
            self._connection.executescript(_SCHEMA)
        except sqlite3.Error as error:
            self.close(leave=False)
            raise self._unwritable(error) from error

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
            raise self._unwritable(error) from error

    def _unwritable(self, error: sqlite3.Error) -> InputError:
        return InputError(f"cannot write '{self.path}': {reason_of(error)}")


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
    """Refuse a second writer; the system unlocks when a process ends, however it ends.

    The lock of another, empty database serves, which SQLite has on every system.
    """
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
        raise InputError(f"cannot write '{path}': {reason_of(error)}") from error
    return connection
