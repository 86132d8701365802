"""Second derivatives of the Lagrangian: exact ones, or those learnt from gradients."""

from __future__ import annotations

import numpy as np

from gaitopt.nlp import Array

DAMPING = 0.2
"""Least share of the model's curvature that an update must keep (Powell, 1978)."""


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
