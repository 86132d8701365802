"""Stacks of square matrices put together from triangles.

Closed forms of a chain's curvature hold for one order of the two joints, the other triangle follows
by symmetry. `numpy.triu` makes its mask anew at every call, which costs more than these matrices.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitopt.nlp import Array


def joined(upper: Array, lower: Array) -> Array:
    """Return `upper` on and above the diagonal, `lower` below it, shape (..., n, n)."""
    return np.where(_on_or_above(upper.shape[-1]), upper, lower)


def symmetric(upper: Array) -> Array:
    """Return the symmetric matrices with this upper triangle, shape (..., n, n)."""
    return joined(upper, np.swapaxes(upper, -1, -2))


@lru_cache(maxsize=32)
def _on_or_above(size: int) -> NDArray[np.bool_]:
    return np.triu(np.ones((size, size), dtype=np.bool_))
