"""Write a file completely or not at all."""

from __future__ import annotations

import os
import secrets
from contextlib import suppress
from pathlib import Path

from gaitopt.errors import InputError


def write_atomically(path: str | os.PathLike[str], data: bytes) -> Path:
    """Write bytes to a file so that a reader sees the old or the new content, never a part.

    The data go to a temporary file in the same directory, to the disk, then take the name.

    Args:
        path: file to write; replaced if it exists.
        data: its content.

    Returns:
        The path written.

    Raises:
        InputError: the path cannot be written.
    """
    target = Path(path)
    try:
        _write(Path(os.path.realpath(target)), data)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(
            f"cannot write '{target}': {(reason or 'unknown reason').lower()}; "
            "give a file name in a directory that exists and may be written"
        ) from error
    return target


def _write(target: Path, data: bytes) -> None:
    if target.is_dir():
        raise IsADirectoryError(None, "it is a directory")
    temporary = target.with_name(f".{secrets.token_hex(6)}.tmp")
    try:
        with temporary.open("xb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(temporary, target)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise
