"""Newton's method on the optimality conditions, to confirm another solver's answer.

The rows and bounds that press, told by least-squares multipliers of the point alone, are held as
equalities, and the conditions (Nocedal & Wright, "Numerical Optimization", 2006, Eq. 18.9) solved
by steps in the null space of those (section 18.3):

    A r = b                                 the rows arrive at their limits
    Z' H Z t = -Z' (g + H r),  d = r + Z t

It has nothing of the SQP's that could be wrong there: no quadratic solver, slack, filter, trust
region or altered curvature. Z' H Z must have a Cholesky factor, so that what is confirmed is a
strict local minimum (Theorem 12.6), and not only a point where the first-order conditions hold.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP, Array, Point, Solution, Start, Status
from gaitopt.settings import checked
from gaitopt.solvers.adapters import Evaluator
from gaitopt.solvers.hessian import RANK
from gaitopt.solvers.qp import cholesky
from gaitopt.solvers.solver import Iterate, Recorder, SingleStage, with_least_squares_multipliers
from gaitopt.tolerances import FEASIBILITY, OPTIMALITY

PRESSING = 1e-6
"""Multipliers below this fraction of the largest belong to rows that are near their limit only."""
DAMPING = 1e-5
"""Singular value of the rows' gradients, over the largest, below which rows count as dependent."""


@checked
@dataclass(frozen=True)
class Newton(SingleStage):
    """Newton's method from a start that is nearly a solution; from elsewhere it goes nowhere.

    At least one step is taken: a start's own optimality is no news. Its multipliers are not used.

    Attributes:
        tolerance: on the gradient of the Lagrangian and on complementarity.
        feasibility: on the largest violation of a row or bound.
        max_iterations: steps (measured: one, where the start is optimal).
    """

    name: ClassVar[str] = "newton"
    tolerance: float = OPTIMALITY
    feasibility: float = FEASIBILITY
    max_iterations: int = 4

    def _solved(self, recorder: Recorder, point: Point, start: Start) -> Solution:
        del start  # it finds its own multipliers
        nlp = recorder.evaluator.nlp
        iterate, status = with_least_squares_multipliers(nlp, point, self.tolerance), Status.STALLED
        recorder.record(iterate)
        for _ in range(self.max_iterations):
            if recorder.stopped:
                status = Status.INTERRUPTED
                break
            step = newton_step(nlp, recorder.evaluator, iterate)
            if step is None:
                break
            try:
                point = recorder.evaluator.point(iterate.point.x + step)
            except EvaluationError:
                break
            iterate = with_least_squares_multipliers(nlp, point, self.tolerance)
            recorder.record(iterate)
            if iterate.is_optimal(self.tolerance, self.feasibility):
                status = Status.OPTIMAL
                break
        return recorder.solution(status, recorder.answer(status, iterate))


def newton_step(nlp: NLP, evaluator: Evaluator, iterate: Iterate) -> Array | None:
    """Return the step in x (n,) from an iterate, None where there is no strict minimum near it.

    Args:
        iterate: with multipliers that tell what presses.
    """
    if not nlp.has_hessian:
        return None
    point, scale, rows, bounds = iterate.point, nlp.variables.scale, nlp.rows, nlp.variables
    y, z = iterate.multipliers, iterate.bound_multipliers
    held, at_bound = _pressing(nlp, iterate)
    limit = np.where(y > 0.0, rows.upper, rows.lower)[held]
    bound = np.where(z > 0.0, bounds.upper, bounds.lower)[at_bound]
    missing = np.append(limit - point.rows[held], (bound - point.x[at_bound]) / scale[at_bound])
    try:
        H = evaluator.hessian(point.x, y, nlp.cost_scale) * np.outer(scale, scale)
    except EvaluationError:
        return None
    d, Z = _spaces(_gradients(nlp, point, held, at_bound), missing)
    if Z.shape[1]:
        factor = cholesky(Z.T @ H @ Z)
        if factor is None:
            return None
        gradient = nlp.cost_scale * point.gradient * scale + H @ d
        d = d - Z @ np.linalg.solve(factor.T, np.linalg.solve(factor, Z.T @ gradient))
    return np.asarray(d * scale)


def is_strict_minimum(nlp: NLP, iterate: Iterate, hessian: Array) -> bool:
    """Return whether a point where the first-order conditions hold is a strict minimum.

    Args:
        iterate: the point, with multipliers.
        hessian: of the Lagrangian there in scaled variables, shape (n, n).
    """
    active = _gradients(nlp, iterate.point, *_pressing(nlp, iterate))
    _, Z = _spaces(active, np.zeros(len(active)))
    return cholesky(Z.T @ hessian @ Z) is not None


def _pressing(nlp: NLP, iterate: Iterate) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the numbers of the rows and of the variables' bounds that press."""
    y, z = np.abs(iterate.multipliers), np.abs(iterate.bound_multipliers)
    least = PRESSING * max(float(y.max(initial=0.0)), float(z.max(initial=0.0)))
    equal = nlp.rows.lower == nlp.rows.upper
    return np.flatnonzero((y > least) | equal), np.flatnonzero(z > least)


def _gradients(nlp: NLP, point: Point, held: NDArray[np.intp], at_bound: NDArray[np.intp]) -> Array:
    """Return the gradients in scaled variables of rows, then of bounds, shape (k, n)."""
    scale = nlp.variables.scale
    return np.vstack([point.slopes[held] * scale, np.eye(scale.size)[at_bound]])


def _spaces(active: Array, missing: Array) -> tuple[Array, Array]:
    """Return the shortest step (n,) that brings rows to their limits, and their null space (n, f).

    Where rows are nearly dependent, as those of a limit held at two instants close together are,
    what they miss is rounding, which is not followed: the step is damped there (Levenberg, 1944).

    Args:
        active: gradients of the rows, shape (k, n).
        missing: what they lack, shape (k,).
    """
    if not len(active):
        return np.zeros(active.shape[1]), np.eye(active.shape[1])
    length = np.maximum(np.linalg.norm(active, axis=1), 1e-300)
    U, s, Vt = np.linalg.svd(active / length[:, None])
    rank = int(np.sum(s > RANK * s[0]))
    s = s[:rank]
    along = (s / (s**2 + (DAMPING * s[0]) ** 2)) * (U[:, :rank].T @ (missing / length))
    return Vt[:rank].T @ along, Vt[rank:].T
