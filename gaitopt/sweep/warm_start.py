"""The best walk known at a point, from which its neighbours start, and which of them should.

Along a branch of local optima the cost is a smooth function of the swept quantity, and the
multipliers tell its slope. A neighbour promises what its tangent predicts, give or take what the
change of slope between the two can bend it. Whether two walks are of the same branch cannot be told
from costs and slopes alone (branches 2 % apart pass every such test, measured). So a promise is
tried, once, unless the neighbour itself came from the point in so few iterations that it must have
stayed on the branch.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gaitopt.design.active_set import Pressure
from gaitopt.nlp import Array
from gaitopt.sweep.grid import GridPoints, Index

LEAP = 13  # iterations; a journey of more has not followed a branch (measured: most take 4 to 6)


@dataclass(frozen=True, eq=False)
class Footing:
    """A walk from which neighbours and the finished gait start.

    Attributes:
        x: parameters, shape (P,).
        cost: in the unit of the task's cost.
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


SAME = 1e-4  # relative difference of costs that counts as none
FEW = 8  # iterations of a journey along a branch; one that leaves it takes more (measured)


def promising(
    points: GridPoints, footings: Mapping[Index, Footing | None], point: Index
) -> list[Index]:
    """Return the neighbours from which a point might reach a lower cost, the best first.

    Args:
        points: of the sweep.
        footings: walks known so far, None where none was found.
        point: which; one without a walk is promised one by every neighbour that walks.
    """
    here = footings.get(point)
    found: list[tuple[float, Index]] = []
    for axis, other in points.neighbours(point):
        there = footings.get(other)
        if there is None or (here is not None and _followed(there, points.name(point))):
            continue
        values = points.axes[axis].values
        stride = values[point[axis]] - values[other[axis]]
        slope = there.slopes[axis] or 0.0
        predicted = there.cost + slope * stride
        if here is not None:
            bend = 0.5 * abs((slope - (here.slopes[axis] or 0.0)) * stride)
            if predicted - bend >= here.cost * (1.0 - SAME):
                continue
        found.append((predicted, other))
    return [other for _, other in sorted(found)]


def _followed(there: Footing, name: str) -> bool:
    return there.origin == name and there.journey <= FEW


def lower(found: Footing | None, known: Footing | None) -> bool:
    """Whether a walk is worth taking in place of the one known."""
    if found is None or known is None:
        return found is not None
    return found.cost < known.cost * (1.0 - SAME)
