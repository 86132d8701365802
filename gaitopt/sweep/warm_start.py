"""The best walk known at a point, from which its neighbours start, and which of them should.

Along a branch of local optima the cost is a smooth function of the swept quantity, and the
multipliers tell its derivative. A neighbour promises what its tangent predicts, give or take what
the change of the derivative between the two can bend it. Whether two walks are of the same branch
cannot be told from costs and derivatives alone (branches 2 % apart pass every such test, measured).
So a promise is tried, once, unless the neighbour itself came from the point in so few iterations
that it must have stayed on the branch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.design.active_set import ActiveRow
from gaitopt.design.starts import SAME_COST
from gaitopt.nlp import Array
from gaitopt.sweep.grid import Index, TaskGrid

ON_BRANCH = 8  # iterations from a neighbour that stay on its branch; leaving takes more (measured)
OFF_BRANCH = 13  # iterations; more have not followed a branch (measured: most take 4 to 6)


@dataclass(frozen=True, eq=False)
class WarmStart:
    """A walk from which neighbours and the finished gait start.

    Attributes:
        x: parameters, shape (P,).
        cost: in the unit of the task's cost.
        active: limits at which it is, with their multipliers.
        cost_gradient: derivative of the optimal cost with respect to each swept quantity, from the
            multipliers; None where it could not be had.
        first_iterations: that led to it from its origin, before instants were added.
        iterations, evaluations: of everything.
        seconds: of processor.
        origin: "cold", "slower walk", "disturbed", or the name of the point it was reached from.
        beside: names of other points through whose walks, of the same branch, it was foretold.
    """

    x: Array
    cost: float
    active: tuple[ActiveRow, ...]
    cost_gradient: tuple[float | None, ...]
    first_iterations: int
    iterations: int
    evaluations: int
    seconds: float
    origin: str
    beside: tuple[str, ...] = ()

    @property
    def left_branch(self) -> bool:
        """Whether it took so many iterations that the walk may be of any branch."""
        return self.first_iterations > OFF_BRANCH

    def record(self) -> dict[str, object]:
        """Return it as JSON-able data."""
        return {
            **asdict(self),
            "x": self.x.tolist(),
            "active": [[p.constraint, p.entry, p.instant, p.multiplier] for p in self.active],
        }


def warm_start_of(record: Mapping[str, Any]) -> WarmStart:
    """Return the warm start of a record.

    Raises:
        KeyError, TypeError, ValueError: it is none.
    """
    if not isinstance(record["origin"], str):
        raise TypeError("the origin of a walk is no text")
    gradient, beside = record["cost_gradient"], tuple(record.get("beside", ()))
    if not all(isinstance(name, str) for name in beside):
        raise TypeError("a walk was foretold by what is no text")
    return WarmStart(
        x=np.array(record["x"], dtype=np.float64),
        cost=float(record["cost"]),
        active=tuple(_active(*entry) for entry in record["active"]),
        cost_gradient=tuple(None if slope is None else float(slope) for slope in gradient),
        first_iterations=int(record["first_iterations"]),
        iterations=int(record["iterations"]),
        evaluations=int(record["evaluations"]),
        seconds=float(record["seconds"]),
        origin=record["origin"],
        beside=beside,
    )


def _active(constraint: object, entry: object, instant: Any, multiplier: Any) -> ActiveRow:
    if not isinstance(constraint, str) or not isinstance(entry, int):
        raise TypeError("an active limit has no name or no number")
    return ActiveRow(constraint, entry, float(instant), float(multiplier))


def promising(
    grid: TaskGrid,
    walk_at: Callable[[Index], WarmStart | None],
    point: Index,
    neighbours: Iterable[tuple[int, Index]],
) -> list[Index]:
    """Return the neighbours from which a point might reach a lower cost, the best first.

    Args:
        grid: of the sweep.
        walk_at: returns the walk known at a point, None where none was found.
        point: which; one without a walk is promised one by every neighbour that walks.
        neighbours: of the point, each with its axis, see `GridLevel.neighbours`.
    """
    here = walk_at(point)
    found: list[tuple[float, Index]] = []
    for axis, other in neighbours:
        there = walk_at(other)
        if there is None or (here is not None and _followed(there, grid.name(point))):
            continue
        values = grid.axes[axis].values
        stride = values[point[axis]] - values[other[axis]]
        slope = there.cost_gradient[axis] or 0.0
        predicted = there.cost + slope * stride
        if here is not None:
            curved = 0.5 * abs((slope - (here.cost_gradient[axis] or 0.0)) * stride)
            if predicted - curved >= here.cost * (1.0 - SAME_COST):
                continue
        found.append((predicted, other))
    return [other for _, other in sorted(found)]


def _followed(there: WarmStart, name: str) -> bool:
    return name in (there.origin, *there.beside) and there.first_iterations <= ON_BRANCH


def is_better(found: WarmStart | None, known: WarmStart | None) -> bool:
    """Whether a walk is worth taking in place of the one known."""
    if found is None or known is None:
        return found is not None
    return found.cost < known.cost * (1.0 - SAME_COST)
