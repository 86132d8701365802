"""What a sweep varies: one quantity of the task or of the robot's specification, and its values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sized
from dataclasses import dataclass, fields, replace
from itertools import islice, pairwise

from gaitopt.bounds import POINTS, at_most
from gaitopt.errors import InputError
from gaitopt.gait.parameters import DURATION, GEOMETRY_NAMES, set_quantities
from gaitopt.gait.task import Margins, Task

DIGITS = 10  # of grid values: 0.4 + 3 * 0.05 is 0.55, not 0.55000000000000004

_TASK = ("speed", "duration", "penalty_weight")
_MARGINS = tuple(f.name for f in fields(Margins) if f.name not in ("joint_range", "impulse_cop"))
_GEOMETRY = {
    f"hold.{name}" if name in _MARGINS else name: name
    for name in GEOMETRY_NAMES
    if name != GEOMETRY_NAMES[DURATION]
}
"""Geometric quantities by the name of their axis: trunk_pitch is a limit, hold.trunk_pitch a value
of the double support."""
_PARTS = ("geometry", "links", "joints")


@dataclass(frozen=True)
class Axis:
    """One quantity and the values it takes.

    Attributes:
        name: a field of `Task` or `Margins`, a geometric quantity (held at the value; as
            "hold.trunk_pitch" where a limit has the same name), or the path of an entry of a
            specification, as "geometry.d3".
        values: increasing, SI units of the quantity.

    Raises:
        InputError: unknown name; values missing, not finite, or not increasing.
    """

    name: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(f"a sweep is over a quantity by its name, not {self.name!r}")
        if self.name not in (*_TASK, *_MARGINS, *_GEOMETRY) and not self.of_robot:
            raise InputError(
                f"there is no quantity '{self.name}' to sweep over; there are {', '.join(_TASK)}; "
                f"the limits {', '.join(_MARGINS)}; the geometric quantities, held at the value, "
                f"{', '.join(_GEOMETRY)}; and the entries of a specification, as geometry.d3"
            )
        values = _numbers(self.name, self.values)
        if not values or not all(map(math.isfinite, values)):
            raise InputError(f"{self.name} has no values, or not finite ones; give at least one")
        if any(b <= a for a, b in pairwise(values)):
            raise InputError(f"the values of {self.name} do not increase; give each once, in order")
        object.__setattr__(self, "values", values)

    @property
    def of_robot(self) -> bool:
        """Whether the quantity is one of the robot's specification."""
        return self.name.split(".")[0] in _PARTS and "." in self.name


def _numbers(name: str, values: Iterable[float]) -> tuple[float, ...]:
    try:
        numbers = tuple(round(float(v), DIGITS) for v in islice(values, POINTS + 1))
        at_most(len(values) if isinstance(values, Sized) else len(numbers), POINTS, "values")
        return numbers
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"the values of {name} are {values!r}; give numbers, as (0.8, 1.0)") from (
            error
        )


def parse_axis(name: str, text: str) -> Axis:
    """Return the axis of a range "first:last:step" (both ends included) or of a list "a,b,c".

    Raises:
        InputError: the text is neither, or no text.
    """
    if not isinstance(text, str):
        raise InputError(
            f"the range of {name} is {text!r}, no text; give one as '0.4:1.3:0.05', or "
            f"Axis({name!r}, (0.4, 0.6))"
        )
    try:
        parts = [float(word) for word in text.split(":" if ":" in text else ",")]
    except ValueError:
        parts = []
    if ":" not in text and parts:
        return Axis(name, tuple(parts))
    if len(parts) != 3 or not all(map(math.isfinite, parts)) or not parts[2] > 0.0:
        raise InputError(
            f"'{text}' is no range of {name}; give first:last:step with a step above 0, as "
            "0.4:1.3:0.05, or the values, as 0.4,0.6,1.0"
        )
    first, last, step = parts
    if first > last:
        raise InputError(
            f"the range {text} of {name} begins above its end; give the lower value first: "
            f"{last:g}:{first:g}:{step:g}"
        )
    count = math.floor((last - first) / step + 1e-6) + 1
    at_most(count, POINTS, f"values of {name}", "with a larger step, or in several sweeps")
    return Axis(name, tuple(first + i * step for i in range(count)))


def with_values(task: Task, values: Iterable[tuple[str, float]]) -> Task:
    """Return the task with some quantities changed; those of the robot are passed over.

    Raises:
        InputError: a value is out of range.
    """
    changes: dict[str, float] = {}
    margins: dict[str, float] = {}
    geometry: dict[str, dict[str, float | bool]] = {}
    for name, value in values:
        if name in _TASK:
            changes[name] = value
        elif name in _MARGINS:
            margins[name] = value
        elif name in _GEOMETRY:
            geometry[_GEOMETRY[name]] = {"free": False, "value": value}
    return replace(
        task,
        **changes,  # type: ignore[arg-type]
        margins=replace(task.margins, **margins),  # type: ignore[arg-type]
        geometry=set_quantities(task.geometry, geometry),
    )
