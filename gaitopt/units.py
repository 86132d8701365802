"""Units: numbers as people write them, 10deg, 8rpm, 35mm, 2 km/h, read into SI."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

_NUMBER = re.compile(
    r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*([^\s\d].*?)?\s*"
)
_DEGREE = math.pi / 180.0
_NEWTON_METRE = {"N·m": 1.0, "Nm": 1.0, "N.m": 1.0, "mNm": 1e-3, "kNm": 1e3}

SINE = "sin(rad)"
"""Unit of a limit on the sine of an angle; with an angle's unit behind it, the angle is meant."""

SLOPE = "rad (slope)"
"""Unit of a slope: an angle, or 10%, the rise over the run."""

UNITS: Mapping[str, Mapping[str, float]] = {
    "rad": {"rad": 1.0, "deg": _DEGREE, "°": _DEGREE},
    "rad/s": {"rad/s": 1.0, "deg/s": _DEGREE, "°/s": _DEGREE, "rpm": math.pi / 30.0},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "km/h": 1.0 / 3.6},
    "m/s²": {"m/s²": 1.0, "m/s2": 1.0, "m/s^2": 1.0},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3},
    "kg": {"kg": 1.0, "g": 1e-3},
    "N": {"N": 1.0, "kN": 1e3},
    "W": {"W": 1.0, "kW": 1e3},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
    "N·m": _NEWTON_METRE,
    "N·m/A": {"N·m/A": 1.0, "Nm/A": 1.0, "mN·m/A": 1e-3, "mNm/A": 1e-3},
    "A": {"A": 1.0, "mA": 1e-3},
    "V": {"V": 1.0},
    "Ω": {"Ω": 1.0, "Ohm": 1.0, "ohm": 1.0, "mΩ": 1e-3, "mOhm": 1e-3},
    "kg·m²": {"kg·m²": 1.0, "kgm²": 1.0, "kgm2": 1.0, "kg·m2": 1.0, "g·cm²": 1e-7, "gcm2": 1e-7},
    SINE: {"rad": 1.0, "deg": _DEGREE, "°": _DEGREE},
    SLOPE: {"rad": 1.0, "deg": _DEGREE, "°": _DEGREE, "%": 1e-2},
}
"""Units of one dimension by the SI unit of it, and their sizes in that."""
RPM = UNITS["rad/s"]["rpm"]
"""One turn a minute [rad/s]."""

DEGREES = "for degrees write 6deg, in Python math.radians(6)"
"""Advice after an angle that is too large: options and files take units, Python takes numbers."""

_LINEAR = {
    "torque": "force", "angle": "travel",
    "N·m": "N", "N.m": "N", "Nm": "N", "kg·m²": "kg", "rad": "m",
}  # fmt: skip
_ANGULAR = re.compile(r"torque|angle|N[·.]?m|kg·m²|(?<![a-z])rad(?![a-z])")


def motion_words(words: str, *, slides: bool) -> str:
    """Return names, units and keys of a joint that turns as those of one that slides, if it does.

    Torque [N·m], angle [rad], speed [rad/s], armature [kg·m²] become force [N], travel [m],
    speed [m/s], armature [kg]; "peak_torque_Nm" becomes "peak_force_N".
    """
    return _ANGULAR.sub(lambda found: _LINEAR[found[0]], words) if slides else words


def read_number(text: str) -> float:
    """Return the number that a text holds in digits 0 to 9, or one that is infinite or none.

    Raises:
        ValueError: it holds none. Python's `float` takes 1_0 and digits of other scripts besides,
            which few readers of numbers do.
    """
    try:
        return float(text if text.isascii() and "_" not in text else "")
    except ValueError:
        raise ValueError("give a number in digits 0 to 9") from None


def read_quantity(value: object, unit: str) -> float:
    """Return a quantity in its SI unit.

    Args:
        value: a number in that unit, or a text with a number and any unit of the dimension.
        unit: a key of `UNITS`, or any other for a number that has no unit to choose.

    Raises:
        ValueError: it is no number, or has another unit; the message says what to give.
    """
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ValueError(_advice(unit))
    found = _NUMBER.fullmatch(str(value))
    if found is None or found[2] is None:
        try:
            return read_number(str(value))
        except ValueError:
            raise ValueError(_advice(unit)) from None
    if found[2] not in (known := UNITS.get(unit, {})):
        raise ValueError(_advice(unit))
    number = float(found[1]) * known[found[2]]
    if unit == SLOPE and found[2] == "%":
        return math.atan(number)
    return math.sin(number) if unit == SINE else number


def read_motion(value: str, unit: str) -> tuple[float, str]:
    """Return a quantity of a joint and the SI unit it has; "" for a plain number.

    Args:
        value: a number, with a unit of joints that turn, of joints that slide, or without.
        unit: SI unit where the joint turns; `motion_words` has that where it slides.

    Raises:
        ValueError: it is no number, or has another unit; the message says what to give.
    """
    found = _NUMBER.fullmatch(value)
    if found is None or found[2] is None:
        return read_quantity(value, unit), ""
    linear = motion_words(unit, slides=True)
    for one in (unit, linear):
        if found[2] in UNITS[one]:
            return read_quantity(value, one), one
    raise ValueError(f"{_advice(unit)}; for a joint that slides: {', '.join(UNITS[linear])}")


def in_si(value: object, unit: str) -> object:
    """Return a text of a number with a unit of the dimension as that number; others as they are."""
    found = _NUMBER.fullmatch(value) if isinstance(value, str) else None
    known = found is not None and found[2] in UNITS.get(unit, {})
    return read_quantity(value, unit) if known else value


def _advice(unit: str) -> str:
    if unit not in UNITS:
        return "give a number"
    return f"give a number in {unit}, if you like with its unit: {', '.join(UNITS[unit])}"


def digits(value: float) -> str:
    """Return a number with as many digits as it has: read again, it is the same."""
    short = f"{value:.12g}"
    return short if float(short) == value else repr(value)
