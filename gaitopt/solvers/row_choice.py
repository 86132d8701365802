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
        row_limits, bound_limits: lower and upper limits of them, shape (2, k).
    """

    rows: Indices
    bounds: Indices
    row_limits: Array
    bound_limits: Array


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
    return given_rows(nlp, rows)


def given_rows(nlp: NLP, rows: Indices) -> RowChoice:
    """Choose these rows, with their own limits, and all bounds."""
    finite = np.isfinite(nlp.variables.lower) | np.isfinite(nlp.variables.upper)
    bounds = np.flatnonzero(finite)
    return RowChoice(
        rows,
        bounds,
        np.stack([nlp.rows.lower[rows], nlp.rows.upper[rows]]),
        np.stack([nlp.variables.lower[bounds], nlp.variables.upper[bounds]]),
    )


def held_rows(nlp: NLP, multipliers: Array, bound_multipliers: Array) -> RowChoice:
    """Choose the rows and bounds that carry a multiplier, as equalities at the limit it tells."""
    rows = np.flatnonzero((multipliers != 0.0) | (nlp.rows.lower == nlp.rows.upper))
    bounds = np.flatnonzero(bound_multipliers)
    at_row = np.where(multipliers > 0.0, nlp.rows.upper, nlp.rows.lower)[rows]
    variables = nlp.variables
    at_bound = np.where(bound_multipliers > 0.0, variables.upper, variables.lower)[bounds]
    return RowChoice(rows, bounds, np.stack([at_row, at_row]), np.stack([at_bound, at_bound]))


def missed_rows(nlp: NLP, point: Point, choice: RowChoice, tolerance: float) -> Indices:
    """Return the indices of violated rows that are not in the choice."""
    excess = violations(nlp.rows.lower, nlp.rows.upper, point.rows)
    return np.setdiff1d(np.flatnonzero(excess > tolerance), choice.rows)
