"""A convex Hessian with the same solution: curvature is changed where the step cannot feel it.

With the active rows A d = b of the quadratic program and their orthonormal range and null space
[Q1 Q2], a step d = Q1 r + Q2 t has its r fixed by the rows. So

    Q2' H Q2  is replaced by its absolute value (Gould & Nocedal, "The modified absolute-value
              factorization norm for trust-region minimization", 1998): only negative curvature
              on the null space, where the step is truly free, is changed;
    sigma/2 |Q1'd - r|^2  is added, r from A Q1 r = b: zero with zero slope at the solution, hence
              neither step nor multipliers change when the active rows were guessed right.

This keeps the quadratic convergence of Newton's method, which |H| of the whole matrix destroys.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import Array

FLOOR = 1e-4
"""Least curvature on the null space, variables scaled, cost of order one to ten (measured)."""
LEAST = 0.5 * FLOOR
"""Least eigenvalue of the convex model: without it, condition numbers of 1e16 (measured)."""
RANK = 1e-8
"""Singular values below this fraction of the largest count as zero (measured)."""


@dataclass(frozen=True)
class ConvexModel:
    """A positive definite Hessian and what its correction adds to the slope.

    Attributes:
        matrix: shape (n, n).
        sigma: curvature added on the range space.
        range_space: Q1, shape (n, r).
        solver: maps the right-hand side b of the active rows (k,) to r (r,); shape (r, k).
    """

    matrix: Array
    sigma: float
    range_space: Array
    solver: Array

    def slope(self, target: Array, radius: float) -> Array:
        """Return -sigma Q1 r (n,), the linear term that goes with the added curvature.

        Args:
            target: right-hand side b of the active rows, shape (k,).
            radius: r is shortened to a step of this infinity norm, which is as far as it can go.
        """
        r = self.solver @ target
        length = float(np.abs(self.range_space @ r).max(initial=0.0))
        return -self.sigma * min(1.0, radius / max(length, 1e-300)) * (self.range_space @ r)


def unchanged(matrix: Array) -> ConvexModel:
    """Wrap a matrix that is positive definite already."""
    n = matrix.shape[0]
    return ConvexModel(matrix, 0.0, np.zeros((n, 0)), np.zeros((0, 0)))


def convexify(hessian: Array, active: Array) -> ConvexModel:
    """Return a positive definite model of a Hessian.

    Args:
        hessian: of the Lagrangian, shape (n, n), symmetric.
        active: gradients of the rows believed active, shape (k, n).
    """
    Q1, Q2, solver = _spaces(active)
    reduced = Q2.T @ hessian @ Q2
    bent = _absolute(reduced)
    coupling = Q1.T @ hessian @ Q2
    sigma = _range_curvature(Q1.T @ hessian @ Q1, coupling, bent)
    matrix = hessian + Q2 @ (bent - reduced) @ Q2.T + sigma * (Q1 @ Q1.T)
    return ConvexModel(0.5 * (matrix + matrix.T), sigma, Q1, solver)


def _spaces(active: Array) -> tuple[Array, Array, Array]:
    """Return range space (n, r), null space (n, n - r) and the map from b to r, shape (r, k)."""
    k, n = active.shape
    if k == 0:
        return np.zeros((n, 0)), np.eye(n), np.zeros((0, 0))
    length = np.maximum(np.linalg.norm(active, axis=1), 1e-300)
    U, s, Vt = np.linalg.svd(active / length[:, None])
    rank = int(np.sum(s > RANK * s[0]))
    solver = (U[:, :rank] / s[:rank]).T / length
    return Vt[:rank].T, Vt[rank:].T, solver


def _absolute(matrix: Array) -> Array:
    if matrix.size == 0:
        return matrix
    eigenvalues, V = np.linalg.eigh(matrix)
    return np.asarray((V * np.maximum(np.abs(eigenvalues), FLOOR)) @ V.T)


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
