"""Which limits an expensive method is given: the nearest ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import NLP, Array, Point, violations
from gaitopt.solvers.elastic import Indices


@dataclass(frozen=True)
class RowChoice:
    """Rows and bounds given to a method.

    Attributes:
        rows: indices of rows, ascending.
        bounds: indices of variables with a finite bound, ascending.
    """

    rows: Indices
    bounds: Indices


def choose_rows(nlp: NLP, point: Point, multipliers: Array, count: int) -> RowChoice:
    """Choose the rows nearest to a limit, and all that are equalities or carry a multiplier.

    Args:
        nlp: the program.
        point: where the distances are measured: margin over the 1-norm of the row's gradient,
            which is how far the variables must move, in units of their scale.
        multipliers: of the rows, shape (m,), zero where unknown.
        count: how many rows to choose at least, if there are as many.
    """
    lower, upper = nlp.rows.lower, nlp.rows.upper
    margin = np.minimum(upper - point.rows, point.rows - lower)
    reach = np.abs(point.jacobian * nlp.variables.scale).sum(axis=1)
    distance = margin / np.maximum(reach, 1e-12)
    distance[(lower == upper) | (multipliers != 0.0)] = -np.inf
    needed = int(np.isneginf(distance).sum())
    nearest = np.argsort(distance, kind="stable")[: max(count, needed)]
    rows = np.sort(nearest[np.isfinite(margin[nearest])])
    finite = np.isfinite(nlp.variables.lower) | np.isfinite(nlp.variables.upper)
    return RowChoice(rows, np.flatnonzero(finite))


def missed_rows(nlp: NLP, point: Point, choice: RowChoice, tolerance: float) -> Indices:
    """Return the indices of violated rows that are not in the choice."""
    excess = violations(nlp.rows.lower, nlp.rows.upper, point.rows)
    return np.setdiff1d(np.flatnonzero(excess > tolerance), choice.rows)
