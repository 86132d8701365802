"""The identification itself: the five values that bring eight costs near those of Table 3."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gaitopt.nlp import Array
from gaitopt.study.reproduce.curve import Curve, cost_curve, warm_curve
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.sensitivity import relative_errors
from gaitopt.study.reproduce.unknowns import UNKNOWNS, identified_values, walks_with

POWER = 10  # of the mean of the relative errors: near to the largest, but smooth
BEYOND = 1.0  # the misfit of values outside their ranges is more than this
FIRST_STRIDE = 0.03  # of the ranges

OnBetter = Callable[[Array, Array], None]


def misfit(errors: Array) -> float:
    """Return the power mean of the relative errors; walks that were not found count as 1."""
    size = np.where(np.isfinite(errors), np.abs(errors), 1.0)
    return float((size**POWER).mean() ** (1.0 / POWER))


def identify(
    start: Array | None = None, *, evaluations: int = 200, on_better: OnBetter | None = None
) -> Array:
    """Return values of the unknowns with a small largest error, by the method of Nelder and Mead.

    No command does this; to search on from the values that are shipped, in Python:

        from gaitopt.study.reproduce.identify import identify
        identify(on_better=print)

    Each try starts from the walks of the best one so far; the costs of a better one are then
    searched along the speeds, so that they are those of the best walks known.

    Args:
        start: in the order of `UNKNOWNS`, shape (5,); by default the values that are shipped.
        evaluations: tries; a second or two each.
        on_better: told the values and the relative errors of each better try.

    Raises:
        InputError: the start is out of range.
        KeyboardInterrupt: Ctrl-C was pressed; `on_better` was told the best values until then.
    """
    from scipy import optimize

    lower = np.array([u.lower for u in UNKNOWNS])
    ranges = np.array([u.upper - u.lower for u in UNKNOWNS])
    first = identified_values() if start is None else np.asarray(start, dtype=np.float64)
    search = _Search(cost_curve(walks_with(first)), on_better)
    simplex = np.vstack([np.zeros(len(first)), FIRST_STRIDE * np.eye(len(first))])
    origin = (first - lower) / ranges
    minimise: Any = optimize.minimize  # the published types do not admit our arrays
    minimise(
        lambda share: search.misfit_at(lower + ranges * share, share),
        origin,
        method="Nelder-Mead",
        options={"initial_simplex": origin + simplex, "maxfev": evaluations},
    )
    return first if search.best is None else search.best


class _Search:
    """Keeps the best values and their walks."""

    def __init__(self, curve: Curve, on_better: OnBetter | None) -> None:
        self.best: Array | None = None
        self._least = np.inf
        self._curve, self._on_better = curve, on_better

    def misfit_at(self, values: Array, share: Array) -> float:
        """Return the misfit of values; share: where they are in their ranges, 0 to 1."""
        outside = float(np.maximum(0.0, np.maximum(-share, share - 1.0)).sum())
        if outside > 0.0:
            return BEYOND + outside
        near = {v: self._curve[v].solution.x for v in printed().speeds if v in self._curve}
        walks = walks_with(values)
        curve = warm_curve([w for w in walks if w.task.speed in near], near)
        first = misfit(relative_errors(curve))
        if first >= self._least:
            return first
        curve = cost_curve(walks, {v: o.solution.x for v, o in curve.items()})
        errors = relative_errors(curve)
        least = misfit(errors)
        if least < self._least:
            self.best, self._least, self._curve = values, least, curve
            if self._on_better is not None:
                self._on_better(values, errors)
        return least
