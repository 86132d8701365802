"""The cubic polynomials between the knots, recovered from the samples of a gait."""

from __future__ import annotations

import numpy as np

from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array

_ROUNDING = 1e-9  # relative: samples this near a knot belong to both sides


def cubic_pieces(gait: Gait) -> Array:
    """Return the spline of each joint as polynomials, shape (n - 1, 12, 4), Eq. (40).

    In piece k the angle is a0 + a1 s + a2 s² + a3 s³ [rad] with s = t - knots[k] in
    seconds. Each piece
    is the least-squares fit to the angles, rates and accelerations sampled in it, which is exact
    for samples of a cubic.

    Raises:
        InputError: a piece has fewer than two samples.
    """
    return np.array([_fit(gait, a, b) for a, b in zip(gait.knots, gait.knots[1:], strict=False)])


def _fit(gait: Gait, start: float, end: float) -> Array:
    slack = _ROUNDING * gait.duration
    inside = (gait.time >= start - slack) & (gait.time <= end + slack)
    if inside.sum() < 2:
        raise InputError(
            f"the gait has {inside.sum()} samples between its knots at {start:.4g} and {end:.4g} s;"
            " two are needed to export its splines, export as CSV instead"
        )
    h = end - start
    s = (gait.time[inside] - start) / h  # scaled: all columns of order one
    one, zero = np.ones_like(s), np.zeros_like(s)
    angle = np.column_stack([one, s, s**2, s**3])
    rate = np.column_stack([zero, one, 2.0 * s, 3.0 * s**2])
    bend = np.column_stack([zero, zero, 2.0 * one, 6.0 * s])
    rows = np.vstack([angle, rate, bend])
    values = np.vstack([gait.q[inside], h * gait.dq[inside], h**2 * gait.ddq[inside]])
    solution = np.linalg.lstsq(rows, values, rcond=None)[0]
    return np.asarray((solution / h ** np.arange(4)[:, None]).T)
