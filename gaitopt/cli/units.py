"""Numbers with a unit behind them, as options take them: 10deg, 8rpm, 35mm, 2km/h."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping

import typer

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d].*?)?\s*")

Units = Mapping[str, float]
"""Units of one dimension, the first of which is that of the option, and their sizes in it."""

_DEGREE = math.pi / 180.0
RAD = {"rad": 1.0, "deg": _DEGREE, "°": _DEGREE}
RAD_PER_S = {"rad/s": 1.0, "deg/s": _DEGREE, "°/s": _DEGREE, "rpm": math.pi / 30.0}
M_PER_S = {"m/s": 1.0, "cm/s": 1e-2, "km/h": 1.0 / 3.6}
M = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
S = {"s": 1.0, "ms": 1e-3}
N = {"N": 1.0, "kN": 1e3}
NM = {"N·m": 1.0, "Nm": 1.0, "N.m": 1.0, "mNm": 1e-3}
OF_NAME = {"rad": RAD, "m": M, "s": S}


def with_unit(text: str, units: Units) -> float:
    """Return a number in the first of the units.

    Args:
        text: the number, and any of the units or none.
        units: with their sizes.

    Raises:
        ValueError: it is no number, or has another unit.
    """
    found = _NUMBER.fullmatch(text)
    if found is None or found[2] is None:
        return float(text)
    if found[2] not in units:
        raise ValueError(f"{found[2]} is none of {', '.join(units)}")
    return float(found[1]) * units[found[2]]


def reader(units: Units) -> Callable[[object], float]:
    """Return what reads an option that has a unit.

    Args:
        units: of it, with their sizes; the first is that of a bare number.
    """

    def read(value: object) -> float:
        """Return the number; a default is one already."""
        if isinstance(value, float | int):
            return float(value)
        try:
            return with_unit(str(value), units)
        except ValueError as error:
            first, *others = units
            raise typer.BadParameter(
                f"{value!r} is no number in {first}; give one, if you like with its unit: "
                f"{first}, {', '.join(others)}"
            ) from error

    return read


def sine(value: object) -> float:
    """Return the sine of an angle that has a unit; a bare number is a sine already."""
    number = reader(RAD)(value)
    return math.sin(number) if str(value).strip()[-1:] in "gd°" else number
