"""Write a file completely or not at all, and make directories for files."""

from __future__ import annotations

import errno
import os
import re
from contextlib import suppress
from os.path import exists, isdir, isfile
from pathlib import Path
from typing import BinaryIO

from gaitopt.errors import InputError, reason_of

try:
    import fcntl
except ImportError:  # not a POSIX system: there nothing is swept away
    fcntl = None  # type: ignore[assignment]

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_LEFTOVER = re.compile(r"\.[0-9a-f]{12}\.tmp")


def write_atomically(path: str | os.PathLike[str], data: bytes, *, synced: bool = True) -> Path:
    """Write bytes to a file so that a reader sees the old or the new content, never a part.

    The data go to a temporary file in the same directory, to the disk, then take the name. Such
    files that killed processes have left in the directory are removed.

    Args:
        path: file to write; replaced if it exists.
        data: its content.
        synced: whether to wait until the disk has it, so that it survives a failure of the power.

    Returns:
        The path written.

    Raises:
        InputError: the path cannot be written.
    """
    target = Path(path)
    try:
        _write(Path(os.path.realpath(target)), data, synced)
    except (OSError, ValueError) as error:
        remedy = "give a file name in a directory that exists and may be written"
        if isinstance(error, OSError) and error.errno in _FULL:
            remedy = "make room, or give a file name on another disk"
        raise InputError(f"cannot write '{target}': {reason_of(error)}; {remedy}") from error
    return target


def cannot_go_on(path: Path, error: Exception) -> InputError:
    """Return the error that a file which work goes on from cannot be written."""
    return InputError(
        f"cannot write '{path}': {reason_of(error)}; make room or permission where it is, and give "
        "the same command again to go on"
    )


def make_directory(path: Path) -> Path:
    """Make a directory with those above it, unless it is there; return it.

    Raises:
        InputError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(
            f"cannot make the directory '{path}': {reason_of(error)}; give one in a directory that "
            "exists and may be written"
        ) from error
    return path


def taken_by(path: Path) -> str:
    """Return what stands where a file is to be written, if a file cannot take its place."""
    if isdir(path):
        return "it is a directory"
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return ""  # so far
    except (OSError, ValueError) as error:
        return reason_of(error)
    # replaced by a file, a device or a pipe would be gone for every other program
    return "it is a device or a pipe" if exists(path) and not isfile(path) else ""


def is_leftover(path: Path | os.DirEntry[str]) -> bool:
    """Whether a file is what a killed process may leave of its writing, judged by its name."""
    return _LEFTOVER.fullmatch(path.name) is not None


def _write(target: Path, data: bytes, synced: bool) -> None:
    if reason := taken_by(target):
        raise OSError(None, reason)
    _sweep(target.parent)
    temporary = target.parent / f".{os.urandom(6).hex()}.tmp"
    try:  # an interrupt may come as soon as the file is there
        with _locked(temporary) as stream:
            stream.write(data)
            stream.flush()
            if synced:
                os.fsync(stream.fileno())
            if fcntl is not None:
                os.replace(temporary, target)  # before the lock goes with the stream
        if fcntl is None:
            os.replace(temporary, target)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise


def _locked(path: Path) -> BinaryIO:
    """Return a new file, open and locked: it is being written as long as the lock is held."""
    while True:
        stream = path.open("xb")
        if fcntl is None:
            return stream
        try:
            with suppress(OSError):  # a file system without locks
                fcntl.flock(stream, fcntl.LOCK_EX)
            if exists(path):  # else it was swept away before the lock was ours
                return stream
        except BaseException:
            stream.close()
            raise
        stream.close()


def _sweep(directory: Path) -> None:
    """Remove what killed processes have left; what is being written is locked, and stays."""
    if fcntl is None:
        return
    with suppress(OSError):
        for entry in os.scandir(directory):
            if is_leftover(entry) and entry.is_file(follow_symlinks=False):
                with suppress(OSError), open(entry.path, "rb") as stream:
                    fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    os.unlink(entry.path)
