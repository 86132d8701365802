"""Text and TOML files, and why one cannot be read."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gaitopt.bounds import MEGABYTE, TABLE, TEXT, read_bounded
from gaitopt.errors import InputError, RobotError, reason_of, there_are

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_LONGEST_MESSAGE = 200  # characters of a parser's message


def read_text(
    path: Path,
    what: str,
    advice: str = "check the path",
    kind: type[InputError] = RobotError,
    most: int = TEXT,
) -> str:
    """Return the text of a UTF-8 file, without a byte order mark.

    Args:
        what: it is, for messages.
        advice: what to do where it is not there or empty, for messages.
        most: bytes that are read.

    Raises:
        InputError: the file is missing, a directory, empty, too large, or not UTF-8 text; of the
            class asked for.
    """
    try:
        text = read_bounded(path, most).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise kind(
            f"cannot read the {what} '{path}': it is not UTF-8 text; save it as UTF-8"
        ) from None
    except (OSError, ValueError) as error:
        raise kind(f"cannot read the {what} '{path}': {reason_of(error)}; {advice}") from None
    if not text.strip():
        raise kind(f"cannot read the {what} '{path}': the file is empty; {advice}")
    return text


def parse_toml(
    text: str | bytes,
    where: str,
    advice: str = "correct that line",
    kind: type[InputError] = InputError,
) -> dict[str, Any]:
    """Return the table that a TOML text holds, bytes being UTF-8 with a byte order mark or not.

    Raises:
        InputError: it is not TOML, or too large; of the class asked for.
    """
    if len(text) > TABLE:
        size, most = len(text) / MEGABYTE, TABLE / MEGABYTE
        raise kind(f"{where}: it has {size:.1f} MB; at most {most:g} MB of TOML are read")
    try:
        words = text if isinstance(text, str) else text.decode("utf-8-sig")
        return tomllib.loads(words, parse_float=_finite_or_inf)
    except UnicodeDecodeError:
        raise kind(f"{where}: not TOML: it is not UTF-8 text; {advice}") from None
    except (ValueError, RecursionError) as error:
        raise kind(f"{where}: not TOML: {str(error)[:_LONGEST_MESSAGE]}; {advice}") from None


def check_keys(
    where: str,
    table: Mapping[str, object],
    known: Iterable[str],
    kind: type[InputError] = InputError,
) -> None:
    """Check that a table has no other entries than those known.

    Raises:
        InputError: it has; of the class asked for.
    """
    names = [*known]
    for name in table:
        if name not in names:
            raise kind(f"{where}: unknown entry '{name}'; {there_are(names, name)}")


def _finite_or_inf(word: str) -> float:
    """Return a number; only the word `inf` is infinite."""
    value = float(word)
    if math.isinf(value) and "inf" not in word:
        raise ValueError(f"the number {word} is too large")
    return value
