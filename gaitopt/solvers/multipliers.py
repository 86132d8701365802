"""Lagrange multipliers of a point, from the point alone.

    minimise over y, z   | cost_scale grad f + J'y + z |_2
    subject to           y, z >= 0 at upper limits, <= 0 at lower ones, 0 away from limits

(Nocedal & Wright, 2006, Eq. 18.21, with signs.) No solver's word is used, so that a certificate
made from these does not depend on how the point was found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gaitopt.nlp import NLP, Array, Point, Variables
from gaitopt.tolerances import ACTIVITY


def least_squares_multipliers(
    nlp: NLP, point: Point, activity_tolerance: float = ACTIVITY
) -> tuple[Array, Array]:
    """Return the multipliers that come nearest to making a point stationary.

    Args:
        point: values and derivatives at the point.
        activity_tolerance: limits nearer than this may carry a multiplier.

    Returns:
        Multipliers of the rows (m,) and of the bounds (n,), signs as in `gaitopt.nlp`.
    """
    m, scale = point.rows.size, nlp.variables.scale
    sides = [
        nlp.rows.upper - point.rows <= activity_tolerance,
        point.rows - nlp.rows.lower <= activity_tolerance,
        nlp.variables.upper - point.x <= activity_tolerance * scale,
        point.x - nlp.variables.lower <= activity_tolerance * scale,
    ]
    row_up, row_down, up, down = (np.flatnonzero(side) for side in sides)
    unit = np.eye(point.x.size)
    columns = np.vstack([point.slopes[row_up], -point.slopes[row_down], unit[up], -unit[down]]).T
    if columns.shape[1] == 0:
        return np.zeros(m), np.zeros(point.x.size)
    target = -nlp.cost_scale * point.gradient
    # Columns of equal length make the active-set method immune to badly scaled rows.
    length = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    size = nonnegative_least_squares(columns / length, target) / length
    parts = np.split(size, np.cumsum([row_up.size, row_down.size, up.size]))
    multipliers, bound_multipliers = np.zeros(m), np.zeros(point.x.size)
    np.add.at(multipliers, row_up, parts[0])
    np.add.at(multipliers, row_down, -parts[1])
    np.add.at(bound_multipliers, up, parts[2])
    np.add.at(bound_multipliers, down, -parts[3])
    return multipliers, bound_multipliers


def nonnegative_least_squares(A: Array, b: Array) -> Array:
    """Return the x >= 0 that minimises | A x - b |_2.

    Lawson & Hanson, "Solving Least Squares Problems" (1974), chapter 23. It begins with all
    columns less those that are negative then. Begun with none, as SciPy's, it may never see a
    column that differs by 1e-8 from one in use, though their difference is needed. SciPy, which
    takes longer to import than a gait to be certified, is asked where rounding decides.

    Args:
        A: shape (n, k).
        b: shape (n,).

    Returns:
        x, shape (k,).
    """
    used = np.ones(A.shape[1], dtype=np.bool_)
    x = _least_squares(A, b, used)
    while (negative := x < 0.0).any():  # all at once: what was needed comes back below
        used &= ~negative
        x = _least_squares(A, b, used)
    refused = np.zeros(used.size, dtype=np.bool_)  # columns that rounding alone made look useful
    tolerance = 10.0 * max(A.shape) * np.finfo(np.float64).eps * max(1.0, float(np.abs(b).max()))
    for _ in range(3 * used.size):
        gain = np.where(used | refused, -np.inf, A.T @ (b - A @ x))
        entering = int(gain.argmax())
        if gain[entering] <= tolerance:
            if refused.any():
                break
            return x
        used[entering] = True
        free = _least_squares(A, b, used)
        if free[entering] <= 0.0:
            used[entering], refused[entering] = False, True
            continue
        refused[:] = False
        while (blocked := used & (free <= 0.0)).any():
            share = x[blocked] / np.maximum(x[blocked] - free[blocked], 1e-300)
            x += share.min() * (free - x)
            used &= x > tolerance
            x[~used] = 0.0
            free = _least_squares(A, b, used)
        x = free
    from scipy.optimize import lsq_linear, nnls  # for sets that go round in circles

    try:
        return np.asarray(nnls(A, b)[0])
    except RuntimeError:  # its iteration limit
        return np.asarray(lsq_linear(A, b, bounds=(0.0, np.inf)).x)


def _least_squares(A: Array, b: Array, used: NDArray[np.bool_]) -> Array:
    """Return the shortest x that minimises | A x - b |_2 with the used columns alone."""
    x = np.zeros(used.size)
    x[used] = np.linalg.lstsq(A[:, used], b, rcond=None)[0]
    return x


def one_sided(multipliers: Array, lower: Array, upper: Array) -> Array:
    """Return multipliers without those that belong to a limit which does not exist.

    Args:
        multipliers: of rows or variables, shape (m,).
        lower: their lower limits, shape (m,).
        upper: their upper limits, shape (m,).
    """
    at_upper = np.where(np.isfinite(upper), np.maximum(multipliers, 0.0), 0.0)
    at_lower = np.where(np.isfinite(lower), np.minimum(multipliers, 0.0), 0.0)
    return np.asarray(at_upper + at_lower)


def bounds_pressing(nlp: NLP, point: Point, multipliers: Array) -> Array:
    """Return the multipliers (n,) of bounds that a point is at, from those of the rows.

    Args:
        point: with derivatives.
        multipliers: of the rows, shape (m,); where all are 0, those of bounds are.
    """
    held, variables = np.flatnonzero(multipliers), nlp.variables
    if held.size == 0:
        return np.zeros(point.x.size)
    room = ACTIVITY * variables.scale
    push = -nlp.cost_scale * point.gradient - multipliers[held] @ point.slopes[held]
    upper = (push > 0.0) & (variables.upper - point.x <= room)
    lower = (push < 0.0) & (point.x - variables.lower <= room)
    return np.where(upper | lower, push, 0.0)


def bound_multipliers(
    variables: Variables, x: Array, box_multipliers: Array, radius: float
) -> Array:
    """Return the multipliers of a step's box that belong to bounds, not to the trust region.

    Args:
        variables: with their bounds and scales.
        x: where the step began, shape (n,).
        box_multipliers: of the box in scaled variables, shape (n,), positive at upper limits.
        radius: of the trust region, in scaled variables.
    """
    held, room = box_multipliers / variables.scale, radius * variables.scale
    upper = (held > 0.0) & (variables.upper - x <= room)
    lower = (held < 0.0) & (x - variables.lower <= room)
    return np.where(upper | lower, held, 0.0)
