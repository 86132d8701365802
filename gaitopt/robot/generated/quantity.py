"""Numbers with a unit and a range, and the refusal of those that have no physical sense."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import Field, dataclass, fields, is_dataclass
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from gaitopt.errors import SpecError

KEY = "quantity"
"""Key of a dataclass field's metadata under which its `Quantity` is found."""

Part = TypeVar("Part")


@dataclass(frozen=True)
class Quantity:
    """What a field may hold.

    Attributes:
        unit: SI unit of the number.
        low, high: smallest and largest number accepted, inclusive.
        shape: () for a number, (3,) for a vector along x, y, z, (3, 3) for a matrix.
        optional: whether None is accepted.
    """

    unit: str
    low: float
    high: float
    shape: tuple[int, ...] = ()
    optional: bool = False

    @property
    def allowed(self) -> str:
        """The range in words."""
        return f"{self.low:g} to {self.high:g} {self.unit}"

    @property
    def metadata(self) -> dict[str, Quantity]:
        """What to hand to `dataclasses.field`."""
        return {KEY: self}


def quantity_of(entry: Field[Any]) -> Quantity | None:
    """Return the quantity of a dataclass field, None if the field is a part or a name."""
    found: Quantity | None = entry.metadata.get(KEY)
    return found


def checked(part: Part, expected: type[Part], path: str) -> Part:
    """Return the same dataclass with every quantity below it checked and made of floats.

    Args:
        part: a dataclass whose fields are quantities or again such dataclasses.
        expected: class it must be an instance of.
        path: where it stands in the specification, for messages.

    Raises:
        SpecError: a field has the wrong type, is not finite, or is out of range.
    """
    if not isinstance(part, expected) or not is_dataclass(part):
        raise SpecError(
            f"{path} must be a {expected.__name__}, got {_shown(part)}; build one from its fields"
        )
    changes: dict[str, Any] = {}
    for entry in fields(part):
        value, where = getattr(part, entry.name), f"{path}.{entry.name}"
        quantity = quantity_of(entry)
        if quantity is None:
            changes[entry.name] = checked(value, entry.metadata["part"], where)
        else:
            changes[entry.name] = checked_value(value, quantity, where)
    return expected(**changes)


def checked_value(value: object, quantity: Quantity, path: str) -> Any:
    """Return the value as a float, or as tuples of floats of the quantity's shape.

    Raises:
        SpecError: wrong type or shape, not finite, or out of range.
    """
    if value is None and quantity.optional:
        return None
    return _checked_array(value, quantity, quantity.shape, path)


def _checked_array(value: object, quantity: Quantity, shape: tuple[int, ...], path: str) -> Any:
    if not shape:
        return _checked_number(value, quantity, path)
    rows = _listed(value)
    if rows is None or len(rows) != shape[0]:
        raise SpecError(
            f"{path} must be a list of {' x '.join(map(str, shape))} numbers in {quantity.unit}, "
            f"got {_shown(value)}; give them in the order x, y, z"
        )
    return tuple(
        _checked_array(row, quantity, shape[1:], f"{path}[{i}]") for i, row in enumerate(rows)
    )


def _listed(value: object) -> list[Any] | None:
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return list(value)
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return list(value)
    return None


def _checked_number(value: object, quantity: Quantity, path: str) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise SpecError(
            f"{path} must be a number in {quantity.unit}, got {_shown(value)}; "
            f"allowed: {quantity.allowed}"
        )
    number = _as_float(value)
    if not math.isfinite(number) or not quantity.low <= number <= quantity.high:
        raise SpecError(
            f"{path} = {number:g} {quantity.unit} is not allowed; allowed: {quantity.allowed}; "
            "check the value and its unit"
        )
    return number + 0.0  # -0.0 becomes 0.0: one number, one spelling


def _as_float(value: Real) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
