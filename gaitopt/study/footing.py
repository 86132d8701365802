"""What is known of the best walk at a point of a sweep before it is finished: enough to go on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gaitopt.design.active import Pressure
from gaitopt.nlp import Array

LEAP = 13  # iterations; a journey of more has not followed a branch (measured: most take 4 to 6)


@dataclass(frozen=True, eq=False)
class Footing:
    """A walk from which neighbours and the finished gait start.

    Attributes:
        x: parameters, shape (P,).
        cost: [N²·m·s].
        active: limits it presses on.
        slopes: derivative of the optimal cost with respect to each swept quantity, from the
            multipliers; None where it could not be had.
        journey: iterations that it took from there, before limits were kept between the samples.
        iterations, evaluations: work of everything.
        seconds: of processor.
        origin: "cold", "slower walk", "disturbed", or the name of the point it was reached from.
    """

    x: Array
    cost: float
    active: tuple[Pressure, ...]
    slopes: tuple[float | None, ...]
    journey: int
    iterations: int
    evaluations: int
    seconds: float
    origin: str

    @property
    def leapt(self) -> bool:
        """Whether the journey was so long that the walk may be of any branch."""
        return self.journey > LEAP

    def record(self) -> dict[str, object]:
        """Return it as JSON-able data."""
        return {
            **asdict(self),
            "x": self.x.tolist(),
            "active": [[p.family, p.entry, p.instant, p.multiplier] for p in self.active],
        }


def footing_of(record: Mapping[str, Any]) -> Footing:
    """Return the footing of a record.

    Raises:
        KeyError, TypeError, ValueError: it is none.
    """
    if not isinstance(record["origin"], str):
        raise TypeError("the origin of a walk is no text")
    return Footing(
        x=np.array(record["x"], dtype=np.float64),
        cost=float(record["cost"]),
        active=tuple(_pressure(*entry) for entry in record["active"]),
        slopes=tuple(None if slope is None else float(slope) for slope in record["slopes"]),
        journey=int(record["journey"]),
        iterations=int(record["iterations"]),
        evaluations=int(record["evaluations"]),
        seconds=float(record["seconds"]),
        origin=record["origin"],
    )


def _pressure(family: object, entry: object, instant: Any, multiplier: Any) -> Pressure:
    if not isinstance(family, str) or not isinstance(entry, int):
        raise TypeError("an active limit has no name or no number")
    return Pressure(family, entry, float(instant), float(multiplier))
