"""Lines of an index that meet conditions such as "speed>0.8"."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from typing import Any

from gaitopt.errors import InputError
from gaitopt.study.index import Row, Value, columns

_CONDITION = re.compile(r"\s*([\w.]+)\s*(<=|>=|==|!=|<|>|=)\s*(.+?)\s*")
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "==": operator.eq,
    "!=": operator.ne,
}
_WORDS = {"true": True, "false": False}
_JOIN = re.compile(r"(?:^|\s+)and(?:\s+|$)")
_STRAY = re.compile(r"[<>=!&|]|\bor\b")  # in a value without quotes: part of another condition
_FORM = (
    'give a column, one of < <= > >= = !=, and a value, as "speed>0.8" or "status=certified"; '
    "several are joined by 'and' only"
)


def selected(rows: Iterable[Row], conditions: Iterable[str]) -> list[Row]:
    """Return the lines that meet every condition; one without the quantity meets none of it.

    Args:
        rows: of an index.
        conditions: each a column, one of < <= > >= = !=, and a number or a word; several joined by
            "and" are several.

    Raises:
        InputError: a condition cannot be understood, or there is no such column.
    """
    every = list(rows)
    kept = every
    for text in conditions:
        for condition in _JOIN.split(text.strip()):
            name, sign, value = _parsed(condition, text, every)
            kept = [row for row in kept if _meets(row.get(name), sign, value)]
    return kept


def _parsed(condition: str, whole: str, rows: list[Row]) -> tuple[str, str, Value]:
    """Return column, sign and value of one condition of a text, which may hold several."""
    found = _CONDITION.fullmatch(condition)
    if found is None or (found[3][0] not in "'\"" and _STRAY.search(found[3])):
        raise InputError(f"'{condition or whole}' is no condition; {_FORM}")
    name, sign, text = found.groups()
    names = columns(rows)
    if names and name not in names:
        raise InputError(unknown_column(name, names))
    value = _value(text.strip("'\""))
    there = [row[name] for row in rows if row.get(name) is not None]
    if there and value != value:
        raise InputError(f"'{condition}' compares with no number; {_FORM}")
    if there and not any(isinstance(v, str) == isinstance(value, str) for v in there):
        kind = "numbers" if isinstance(value, str) else f"words, as '{there[0]}'"
        raise InputError(f"'{condition}' is no condition: {name} holds {kind}; {_FORM}")
    return name, sign, value


def unknown_column(name: str, names: list[str]) -> str:
    """Return the sentence that there is no such column, with the names nearest to it."""
    close = get_close_matches(name, names, n=3, cutoff=0.4)
    hint = f"did you mean {' or '.join(close)}? " if close else ""
    return f"there is no column '{name}'; {hint}'gaitopt library DIR --columns list' lists all"


def _value(word: str) -> Value:
    try:
        return float(word)
    except ValueError:
        return _WORDS.get(word.lower(), word)


def _meets(there: Value, sign: str, value: Value) -> bool:
    if there is None:
        return False
    if isinstance(there, str) != isinstance(value, str):
        return sign == "!="
    return bool(_COMPARE[sign](there, value))
