"""The diary of a sweep: one JSON line per event, appended, on the disk before the next begins."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from gaitopt.bounds import JOURNAL, read_bounded
from gaitopt.errors import InputError

NAME = "journal.jsonl"


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
        data = read_bounded(path, JOURNAL) if path.exists() else b""
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
        self.path = directory / NAME
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
