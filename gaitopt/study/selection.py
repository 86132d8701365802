"""Lines of an index that meet conditions such as "speed>0.8"."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable
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


def selected(rows: Iterable[Row], conditions: Iterable[str]) -> list[Row]:
    """Return the lines that meet every condition; one without the quantity meets none of it.

    Args:
        rows: of an index.
        conditions: each a column, one of < <= > >= = !=, and a number or a word; several joined by
            "and" are several.

    Raises:
        InputError: a condition cannot be understood, or there is no such column.
    """
    kept = list(rows)
    names = columns(kept)
    for text in conditions:
        for condition in re.split(r"\s+and\s+", text.strip()):
            name, sign, value = _parsed(condition, names)
            kept = [row for row in kept if _meets(row.get(name), sign, value)]
    return kept


def _parsed(condition: str, names: list[str]) -> tuple[str, str, Value]:
    found = _CONDITION.fullmatch(condition)
    if found is None:
        raise InputError(
            f"'{condition}' is no condition; give a column, one of < <= > >= = !=, and a value, as "
            '"speed>0.8" or "status=certified"'
        )
    name, sign, text = found.groups()
    if names and name not in names:
        raise InputError(f"there is no column '{name}'; there are {', '.join(names)}")
    word = text.strip("'\"")
    try:
        return name, sign, float(word)
    except ValueError:
        return name, sign, _WORDS.get(word.lower(), word)


def _meets(there: Value, sign: str, value: Value) -> bool:
    if there is None:
        return False
    if isinstance(there, str) != isinstance(value, str):
        return sign == "!="
    return bool(_COMPARE[sign](there, value))
