"""The subproblem of one iteration, never infeasible thanks to one elastic variable.

    minimise over d, s   g'd + 1/2 d'H d + nu s + 1/2 w s^2
    subject to           lower - s <= c + J d <= upper + s
                         box_lower <= d <= box_upper,   s >= 0

(Nocedal & Wright, 2006, section 18.5, with the infinity norm in place of the 1-norm.) All in
variables divided by their scale, and H made convex. Of the thousand rows only those that the
step may reach are given to the quadratic program; a row left out and then violated is added and
the program solved again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gaitopt.nlp import Array
from gaitopt.solvers.qp import QuadraticProgram, solve_qp

ROUNDS = 8
"""Times rows are added before all of them are given (almost always one suffices: measured)."""
MISSED = 1e-10
"""Violation from which a row left out is added."""
STIFFNESS = 1e-3
"""w / nu: without the quadratic term the programs are badly conditioned (measured)."""

Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Subproblem:
    """The subproblem in (d, s), and the rows to begin with.

    Attributes:
        slope: linear cost of (d, s), shape (n + 1,).
        curvature: quadratic cost of (d, s), shape (n + 1, n + 1), positive definite.
        jacobian: J, shape (m, n).
        below, above: lower - c and upper - c, shape (m,).
        box_lower, box_upper: shape (n,).
        use_below, use_above: rows whose lower, upper side is given at first, shape (m,).
    """

    slope: Array
    curvature: Array
    jacobian: Array
    below: Array
    above: Array
    box_lower: Array
    box_upper: Array
    use_below: Mask
    use_above: Mask


@dataclass(frozen=True)
class ElasticStep:
    """The solution of a subproblem.

    Attributes:
        d: step, shape (n,).
        slack: s, the violation the linear model still has after the step.
        multipliers: of the rows, shape (m,), positive at upper limits.
        box_multipliers: of the box, shape (n,), positive at upper limits.
        use_below, use_above: the rows that were needed, shape (m,).
    """

    d: Array
    slack: float
    multipliers: Array
    box_multipliers: Array
    use_below: Mask
    use_above: Mask

    @property
    def length(self) -> float:
        """Largest component of d."""
        return float(np.abs(self.d).max(initial=0.0))


def solve_subproblem(problem: Subproblem, backend: str) -> ElasticStep | None:
    """Solve the elastic subproblem, or return None when no quadratic solver could."""
    for attempt in range(ROUNDS + 1):
        if attempt == ROUNDS:
            problem = replace(
                problem,
                use_below=np.isfinite(problem.below),
                use_above=np.isfinite(problem.above),
            )
        step = _solve_screened(problem, backend)
        if step is None:
            return None
        moved = problem.jacobian @ step.d
        missed_below = (problem.below - moved > step.slack + MISSED) & ~problem.use_below
        missed_above = (moved - problem.above > step.slack + MISSED) & ~problem.use_above
        if not (missed_below.any() or missed_above.any()):
            return step
        problem = replace(
            problem,
            use_below=problem.use_below | missed_below,
            use_above=problem.use_above | missed_above,
        )
    return step


def _solve_screened(problem: Subproblem, backend: str) -> ElasticStep | None:
    above = np.flatnonzero(problem.use_above)
    below = np.flatnonzero(problem.use_below)
    solution = solve_qp(_quadratic_program(problem, above, below), backend)
    if solution is None:
        return None
    n = problem.box_lower.size
    multipliers = np.zeros(problem.below.size)
    multipliers[above] += solution.rows[: above.size]
    multipliers[below] -= solution.rows[above.size :]
    return ElasticStep(
        d=np.clip(solution.x[:n], problem.box_lower, problem.box_upper),
        slack=max(0.0, float(solution.x[n])),
        multipliers=multipliers,
        box_multipliers=solution.bounds[:n],
        use_below=problem.use_below,
        use_above=problem.use_above,
    )


def _quadratic_program(problem: Subproblem, above: Indices, below: Indices) -> QuadraticProgram:
    n, k = problem.box_lower.size, above.size
    G = np.empty((k + below.size, n + 1))
    G[:k, :n] = problem.jacobian[above]
    np.negative(problem.jacobian[below], out=G[k:, :n])
    G[:, n] = -1.0
    h = np.concatenate([problem.above[above], -problem.below[below]])
    # d = 0 needs no more slack than the worst row has, so this limit on s is never active.
    enough = 10.0 * max(1.0, -float(h.min(initial=0.0)))
    return QuadraticProgram(
        problem.curvature,
        problem.slope,
        G,
        h,
        np.append(problem.box_lower, 0.0),
        np.append(problem.box_upper, enough),
    )
