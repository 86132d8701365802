"""Checks of the single values of choices, which come from files and from Python alike."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping

from gaitopt.errors import RobotError


def check_one_of(name: str, value: object, allowed: Collection[str | None]) -> None:
    """Check that a value is one of a few.

    Raises:
        RobotError: it is not; the message lists them.
    """
    if value not in allowed:
        names = ", ".join(f"'{a}'" for a in allowed if a is not None)
        raise RobotError(f"{name} is {value!r}; it must be one of {names}")


def as_tuple(value: object, name: str) -> tuple[object, ...]:
    """Return the entries of a list.

    Raises:
        RobotError: the value is no list.
    """
    if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
        raise RobotError(f"{name} must be a list, got {value!r}")
    return tuple(value)


def number(value: object, name: str) -> float:
    """Return a number, which may be infinite.

    Raises:
        RobotError: the value is no number.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value:
        raise RobotError(f"{name} must be a number, got {value!r}")
    try:
        return float(value)
    except OverflowError:  # whole numbers have no largest one
        raise RobotError(f"{name} is too large: {len(str(value))} digits") from None


def finite(value: object, name: str) -> float:
    """Return a finite number.

    Raises:
        RobotError: the value is not one.
    """
    found = number(value, name)
    if not math.isfinite(found):
        raise RobotError(f"{name} is {found}; it must be finite")
    return found
