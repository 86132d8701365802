"""Whether the gait files of a library are there, whole, and of the point they are filed under."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from gaitopt.errors import GaitFileError
from gaitopt.gait.result import Gait
from gaitopt.gait.result_file import load_gait

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
