"""Small linear systems straight from LAPACK: NumPy's wrapper costs more than the elimination."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgesv

from gaitopt.nlp import Array


def solve(matrix: Array, rhs: Array) -> Array:
    """Return the solution of matrix @ x = rhs, in the shape of rhs.

    Args:
        matrix: square, shape (n, n).
        rhs: shape (n,) or (n, m).

    Raises:
        numpy.linalg.LinAlgError: the matrix is singular to the last digit.
    """
    _, _, x, info = dgesv(matrix, rhs)
    if info != 0:
        raise np.linalg.LinAlgError("singular matrix")
    return np.asarray(x, dtype=np.float64)
