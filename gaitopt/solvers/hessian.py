"""The Hessian of the Lagrangian in scaled variables: exact or learnt from gradients, made convex.

Curvature is changed where the step cannot feel it. With the active rows A d = b of the quadratic
program and their orthonormal range and null space [Q1 Q2], a step d = Q1 r + Q2 t has its r fixed
by the rows. So

    Q2' H Q2  is replaced by its absolute value (Gould & Nocedal, "The modified absolute-value
              factorization norm for trust-region minimization", 1998): only negative curvature
              on the null space, where the step is truly free, is changed;
    sigma/2 |Q1'd - r|^2  is added, r from A Q1 r = b: zero with zero gradient at the solution,
              hence neither step nor multipliers change when the active rows were guessed right.

This keeps the quadratic convergence of Newton's method, which |H| of the whole matrix destroys.

Where the null space has hardly any curvature, Q1' H Q2 makes sigma so large that no quadratic
solver answers. Then a share of that block is taken at the known r: the step does not change,
multipliers do by as much as that share bends along t, which vanishes as the steps do.
"""

from __future__ import annotations

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError
from gaitopt.nlp import Array
from gaitopt.solvers.adapters import Evaluator
from gaitopt.solvers.qp import cholesky
from gaitopt.solvers.solver import Iterate

DAMPING = 0.2
"""Least share of the model's curvature that an update must keep (Powell, 1978)."""
FLOOR = 1e-4
"""Least curvature on the null space, variables scaled, cost of order one to ten (measured)."""
LEAST = 0.5 * FLOOR
"""Least eigenvalue of the convex model: without it, condition numbers of 1e16 (measured)."""
MOST = 1e5
"""Added at most on the range space where no program with more could be solved (measured)."""
RANK = 1e-8
"""Singular values below this fraction of the largest count as zero (measured)."""


def damped_bfgs(B: Array, step: Array, change: Array) -> Array:
    """Update a positive definite approximation; it stays positive definite.

    Nocedal & Wright (2006), Procedure 18.2.

    Args:
        B: the approximation, shape (n, n).
        step: s, the step in the variables, shape (n,).
        change: y, the change of the Lagrangian's gradient along it, shape (n,).
    """
    Bs = B @ step
    sBs = float(step @ Bs)
    sy = float(step @ change)
    if sBs <= 1e-30:
        return B
    theta = 1.0 if sy >= DAMPING * sBs else (1.0 - DAMPING) * sBs / (sBs - sy)
    r = theta * change + (1.0 - theta) * Bs
    updated = B - np.outer(Bs, Bs) / sBs + np.outer(r, r) / float(step @ r)
    return np.asarray(0.5 * (updated + updated.T))


class LagrangianHessian:
    """The Hessian of the Lagrangian in scaled variables, exact or learnt from gradients.

    Attributes:
        matrix: as it is known last, shape (n, n).
        definite: whether the Hessian is positive definite by construction.
        borrowed: whether the last one is that of a neighbour.
    """

    def __init__(self, evaluator: Evaluator, exact: bool, neighbours: Array | None = None) -> None:
        """Begin with the identity.

        In scaled variables that is a fair guess; scaling it by the first step, as Nocedal &
        Wright (2006), Eq. 6.20, do, takes more than twice the iterations (measured).

        Args:
            exact: use its second derivatives if it has any.
            neighbours: exact one of a neighbour, shape (n, n), to begin with.
        """
        self._evaluator = evaluator
        self._exact = exact and evaluator.nlp.has_hessian
        known = neighbours if self._exact else None
        self.matrix = np.eye(evaluator.nlp.variables.scale.size) if known is None else known
        self.definite = known is None
        self.borrowed, self._unused = False, known is not None

    @property
    def last(self) -> Array | None:
        """The last exact one, shape (n, n), None where there was none."""
        return None if self.definite else self.matrix

    def at(self, iterate: Iterate) -> Array:
        """Return the (n, n) Hessian at an iterate; the last known one where it is undefined."""
        if self._exact:
            nlp = self._evaluator.nlp
            scale = nlp.variables.scale
            self.borrowed, self._unused = self._unused, False
            if self.borrowed:
                return self.matrix
            try:
                H = self._evaluator.hessian(iterate.point.x, iterate.multipliers, nlp.cost_scale)
            except EvaluationError:
                return self.matrix
            self.matrix = 0.5 * (H + H.T) * np.outer(scale, scale)
            self.definite = False
        return self.matrix

    def of_cost(self, iterate: Iterate) -> Array | None:
        """Return what the cost alone bends at an iterate, positive definite, shape (n, n).

        None where the Hessian is not exact, and where `NLP.cost_curvature` is none or below zero.
        """
        nlp = self._evaluator.nlp
        bent = nlp.cost_curvature(iterate.point.x) if self._exact else None
        if bent is None:
            return None
        scale = nlp.variables.scale
        bent = bent * np.outer(scale, scale) + FLOOR * np.eye(scale.size)
        return None if cholesky(bent) is None else bent

    def update(self, old: Iterate, new: Iterate) -> None:
        """Update the approximation after a step, with the new multipliers at both ends."""
        if self._exact:
            return
        nlp = self._evaluator.nlp
        scale = nlp.variables.scale
        step = (new.point.x - old.point.x) / scale
        change = nlp.cost_scale * (new.point.gradient - old.point.gradient)
        change = change + (new.point.jacobian - old.point.jacobian).T @ new.multipliers
        change = change * scale
        self.matrix = damped_bfgs(self.matrix, step, change)


@dataclass(frozen=True)
class ConvexModel:
    """A positive definite Hessian and what its correction adds to the gradient.

    Attributes:
        matrix: shape (n, n).
        sigma: curvature added on the range space.
        range_space: Q1, shape (n, r).
        solver: maps the right-hand side b of the active rows (k,) to r (r,); shape (r, k).
        at_known: Q2 times the share of Q2' H Q1 that is taken at the known r, shape (n, r); None
            where that is nothing.
    """

    matrix: Array
    sigma: float
    range_space: Array
    solver: Array
    at_known: Array | None = None

    def linear_term(self, target: Array, radius: float) -> Array:
        """Return the linear term (n,) that goes with what was changed: -sigma Q1 r and the like.

        Args:
            target: right-hand side b of the active rows, shape (k,).
            radius: r is shortened to a step of this infinity norm, which is as far as it can go.
        """
        r = self.solver @ target
        length = float(np.abs(self.range_space @ r).max(initial=0.0))
        r *= min(1.0, radius / max(length, 1e-300))
        term = -self.sigma * (self.range_space @ r)
        return np.asarray(term if self.at_known is None else term + self.at_known @ r)


def unchanged(matrix: Array) -> ConvexModel:
    """Wrap a matrix (n, n) that is positive definite already."""
    n = matrix.shape[0]
    return ConvexModel(matrix, 0.0, np.zeros((n, 0)), np.zeros((0, 0)))


def convexify(hessian: Array, active: Array, most: float = np.inf) -> ConvexModel:
    """Return a positive definite model of a Hessian.

    Args:
        hessian: of the Lagrangian, shape (n, n), symmetric.
        active: gradients of the rows believed active, shape (k, n).
        most: about the most that sigma may be for the sake of Q1' H Q2.
    """
    Q, rank, solver = _spaces(active)
    Q1, Q2, bent = Q[:, :rank], Q[:, rank:], Q.T @ hessian @ Q
    inner, coupling, reduced = bent[:rank, :rank], bent[:rank, rank:], bent[rank:, rank:]
    matrix, positive = hessian, reduced
    if cholesky(reduced - FLOOR * np.eye(reduced.shape[0])) is None:
        eigenvalues, V = np.linalg.eigh(reduced)
        gain = np.maximum(np.abs(eigenvalues), FLOOR) - eigenvalues
        changed = np.flatnonzero(gain)
        added, W = gain[changed] * V[:, changed], Q2 @ V[:, changed]
        positive = reduced + added @ V[:, changed].T
        matrix = matrix + (gain[changed] * W) @ W.T
    sigma, at_known = _range_curvature(inner, coupling, positive), None
    if sigma > most:
        kept = np.sqrt(most / sigma)
        sigma = _range_curvature(inner, kept * coupling, positive)
        at_known = (1.0 - kept) * (Q2 @ coupling.T)
        matrix = matrix - (at_known @ Q1.T + Q1 @ at_known.T)
    matrix = matrix + (sigma * Q1) @ Q1.T
    return ConvexModel(0.5 * (matrix + matrix.T), sigma, Q1, solver, at_known)


def _spaces(active: Array) -> tuple[Array, int, Array]:
    """Return Q = [Q1 Q2] (n, n), the columns of Q1, r, and the map from b to r, shape (r, k)."""
    k, n = active.shape
    if k == 0:
        return np.eye(n), 0, np.zeros((0, 0))
    length = np.maximum(np.linalg.norm(active, axis=1), 1e-300)
    U, s, Vt = np.linalg.svd(active / length[:, None])
    rank = int(np.sum(s > RANK * s[0]))
    return Vt.T, rank, (U[:, :rank] / s[:rank]).T / length


def _range_curvature(range_block: Array, coupling: Array, null_block: Array) -> float:
    """Return the sigma from which on the model less LEAST is positive semidefinite.

    It is when its null block, which is, and the Schur complement of that block are (Boyd &
    Vandenberghe, "Convex Optimization", 2004, section A.5.5).
    """
    if range_block.size == 0:
        return 0.0
    schur = range_block - LEAST * np.eye(range_block.shape[0])
    if null_block.size:
        above = null_block - LEAST * np.eye(null_block.shape[0])
        schur = schur - coupling @ np.linalg.solve(above, coupling.T)
    return max(0.0, -float(np.linalg.eigvalsh(schur)[0]))
