"""TOML texts, and why one cannot be read."""

from __future__ import annotations

import math
import sys
from typing import Any

from gaitopt.bounds import MEGABYTE, TABLE
from gaitopt.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_LONGEST = 200  # characters of a parser's message


def parse_toml(
    text: str | bytes,
    where: str,
    advice: str = "correct that line",
    kind: type[InputError] = InputError,
) -> dict[str, Any]:
    """Return the table that a TOML text holds.

    Args:
        text: of a file, as text or as the bytes of UTF-8, with or without a byte order mark.
        where: it comes from, for messages: a path, say.
        advice: what to do about a damaged one, for messages.
        kind: of the error.

    Raises:
        InputError: it is not TOML, or too large; of the class asked for.
    """
    if len(text) > TABLE:
        size, most = len(text) / MEGABYTE, TABLE / MEGABYTE
        raise kind(f"{where}: it has {size:.1f} MB; at most {most:g} MB of TOML are read")
    try:
        words = text if isinstance(text, str) else text.decode("utf-8-sig")
        return tomllib.loads(words, parse_float=_finite_or_inf)
    except (ValueError, RecursionError) as error:
        raise kind(f"{where}: not TOML: {str(error)[:_LONGEST]}; {advice}") from None


def _finite_or_inf(word: str) -> float:
    """Return a number; only the word `inf` is infinite."""
    value = float(word)
    if math.isinf(value) and "inf" not in word:
        raise ValueError(f"the number {word} is too large")
    return value
