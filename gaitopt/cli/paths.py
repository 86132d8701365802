"""Whether what was asked for can be written, found out before the work."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path

from gaitopt.errors import InputError


def require_writable(directory: Path, option: str = "--output") -> None:
    """Check, before any work and leaving no trace, that a directory can be made and written.

    Args:
        directory: which need not exist.
        option: that names it, for the error.

    Raises:
        InputError: it cannot.
    """
    whole = directory.absolute()
    missing = [path for path in (whole, *whole.parents) if not path.exists()]
    nearest = missing[-1].parent if missing else whole
    try:
        if not nearest.is_dir():
            raise NotADirectoryError
        whole.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=whole):
            pass
    except OSError as error:
        reason = f"in '{nearest}': {(error.strerror or str(error)).lower()}"
        if not nearest.is_dir():
            reason = f"'{nearest}' is a file"
        raise InputError(
            f"cannot write to '{directory}': {reason}; give another {option} directory"
        ) from error
    finally:
        for path in missing:
            with suppress(OSError):
                path.rmdir()


def require_files(*files: tuple[Path | None, str]) -> None:
    """Check, before any work, that files can be written.

    Args:
        files: each with the option that names it; None where none is asked for.

    Raises:
        InputError: a directory is not there or cannot be written, the file is a directory, or two
            are the same.
    """
    taken: dict[Path, str] = {}
    for path, option in files:
        if path is None:
            continue
        if (other := taken.setdefault(path.resolve(), option)) != option:
            raise InputError(
                f"{option} {path}: {other} is to write the same file; give two file names"
            )
        folder = path.absolute().parent
        if path.is_dir() or not folder.is_dir():
            reason = "it is a directory" if path.is_dir() else f"there is no directory '{folder}'"
            raise InputError(f"{option} {path}: cannot write it: {reason}; give another file name")
        require_writable(folder, option)
