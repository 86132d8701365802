"""Which neighbour might lead a point to a lower cost?

Along a branch of local optima the cost is a smooth function of the swept quantity, and the
multipliers tell its slope. A neighbour promises what its tangent predicts, give or take what the
change of slope between the two can bend it. Whether two walks are of the same branch cannot be told
from costs and slopes alone (branches 2 % apart pass every such test, measured). So a promise is
tried, once, unless the neighbour itself came from the point in so few iterations that it must have
stayed on the branch.
"""

from __future__ import annotations

from collections.abc import Mapping

from gaitopt.study.footing import Footing
from gaitopt.study.grid_points import GridPoints, Index

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
