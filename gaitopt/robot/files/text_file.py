"""Text files, and why one cannot be read."""

from __future__ import annotations

from pathlib import Path

from gaitopt.bounds import TEXT, read_bounded
from gaitopt.errors import RobotError


def read_text(path: Path, what: str = "file") -> str:
    """Return the text of a UTF-8 file, without a byte order mark.

    Args:
        path: of the file.
        what: it should hold, for messages.

    Raises:
        RobotError: the file is missing, a directory, empty, too large, or not UTF-8 text.
    """
    try:
        text = read_bounded(path, TEXT).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise RobotError(
            f"cannot read the {what} '{path}': it is not UTF-8 text; save it as UTF-8"
        ) from None
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise RobotError(f"cannot read the {what} '{path}': {reason}; check the path") from None
    if not text.strip():
        raise RobotError(f"cannot read the {what} '{path}': the file is empty")
    return text
