"""Spatial algebra on stacks of six-vectors (linear part first), as in Pinocchio.

A motion is the velocity [m/s, rad/s] of the body point at the origin and its rotation; a force is
[N, N.m] with the moment about the origin (Featherstone, 2008, chapter 2, with linear and angular
parts exchanged).

The cross products are linear in their first factor, so their matrices for a whole stack are one
product with a constant matrix: on the small stacks met here many times faster than slicing. For the
same reason there are symmetric matrices without `numpy.triu`, which makes its mask anew at every
call.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from eigenpy import PartialPivLU
from numpy.typing import NDArray

from gaitopt.nlp import Array


def _levi_civita() -> Array:
    """Return e with (a x b)_k = sum_ij a_i e[i, k, j] b_j, shape (3, 3, 3)."""
    e = np.zeros((3, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        e[i, k, j], e[j, k, i] = 1.0, -1.0
    return e


def _motion_constants() -> Array:
    """Return the matrices of e_i x, stacked over the six unit motions, shape (6, 6, 6)."""
    e = _levi_civita()
    constants = np.zeros((6, 6, 6))
    constants[:3, :3, 3:] = e  # linear x angular -> linear
    constants[3:, :3, :3] = constants[3:, 3:, 3:] = e
    return constants


_SKEW = _levi_civita().reshape(3, 9)
_MOTION = _motion_constants().reshape(6, -1)
_FORCE = -_motion_constants().swapaxes(1, 2).reshape(6, -1)
_ON_FORCE = -_motion_constants().swapaxes(1, 2).transpose(2, 1, 0).reshape(6, -1)


def skew(vector: Array) -> Array:
    """Return the cross-product matrices of vectors (..., 3), shape (..., 3, 3)."""
    return _matrices(vector, _SKEW)


def motion_cross_matrix(motion: Array) -> Array:
    """Return the matrices of y -> motion x y on motions, shape (..., 6, 6)."""
    return _matrices(motion, _MOTION)


def force_cross_matrix(motion: Array) -> Array:
    """Return the matrices of f -> motion x* f on forces, shape (..., 6, 6)."""
    return _matrices(motion, _FORCE)


def cross_force_matrix(force: Array) -> Array:
    """Return the matrices of y -> y x* force [N, N·m], shape (..., 6, 6)."""
    return _matrices(force, _ON_FORCE)


def apply(matrices: Array, vectors: Array) -> Array:
    """Return the product of each matrix (..., m, n) with its vector (..., n), shape (..., m)."""
    return np.asarray(np.einsum("...ij,...j->...i", matrices, vectors))


def turned(rotations: Array, pairs: Array) -> Array:
    """Return motions or forces (..., 6) with both parts turned by rotations (..., 3, 3)."""
    parts = pairs.reshape(*pairs.shape[:-1], 2, 3)
    return np.asarray(np.einsum("...ij,...kj->...ki", rotations, parts).reshape(pairs.shape))


def cross(a: Array, b: Array) -> Array:
    """Return a x b for stacks of vectors (..., 3)."""
    return apply(skew(a), b)


def cross_motion(motion: Array, other: Array) -> Array:
    """Return motion x other for stacks of motions (..., 6)."""
    return apply(motion_cross_matrix(motion), other)


def cross_force(motion: Array, force: Array) -> Array:
    """Return motion x* force for stacks of motions and forces (..., 6) [N, N·m]."""
    return apply(force_cross_matrix(motion), force)


def _matrices(vectors: Array, constants: Array) -> Array:
    size = vectors.shape[-1]
    product = vectors.reshape(-1, size) @ constants
    return np.asarray(product.reshape(*vectors.shape, size))


def pseudo_inertia(mass: float, lever: Array, inertia: Array) -> Array:
    """Return the integral of r r' dm over a body, r = (place in its frame, 1), shape (4, 4).

    Args:
        mass: [kg].
        lever: centre of mass in the body frame, shape (3,) [m].
        inertia: about the centre of mass in the body frame, shape (3, 3) [kg.m²].
    """
    r = np.append(lever, 1.0)
    pseudo = mass * np.outer(r, r)
    pseudo[:3, :3] += 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return np.asarray(pseudo)


def _inertia_of_pseudo() -> Array:
    """Return the matrix from a pseudo-inertia to the spatial inertia, shape (16, 36)."""
    constants = np.zeros((4, 4, 6, 6))
    constants[3, 3, :3, :3] = np.eye(3)
    for i, across in enumerate(_levi_civita()):
        constants[i, 3, :3, 3:], constants[i, 3, 3:, :3] = -across, across
        constants[i, i, 3:, 3:] += np.eye(3)
        constants[i, range(3), 3 + i, range(3, 6)] -= 1.0
    return constants.reshape(16, 36)


_OF_PSEUDO = _inertia_of_pseudo()


def world_inertias(pseudo: Array, frames: Array) -> Array:
    """Return spatial inertias about the world origin, shape (N, b, 6, 6), in memory (6, 6, N, b).

    Args:
        pseudo: `pseudo_inertia` of the b bodies, shape (b, 4, 4).
        frames: of the bodies in the world at N postures, homogeneous, shape (b, N, 4, 4).
    """
    turned = np.matmul(frames.reshape(len(frames), -1, 4), pseudo).reshape(frames.shape)
    in_world = turned @ frames.swapaxes(2, 3)
    bodies, count = frames.shape[:2]
    found: Array = _OF_PSEUDO.T @ in_world.transpose(2, 3, 1, 0).reshape(16, -1)
    return found.reshape(6, 6, count, bodies).transpose(2, 3, 0, 1)


def joined(upper: Array, lower: Array) -> Array:
    """Return `upper` on and above the diagonal, `lower` below it, shape (..., n, n)."""
    return np.where(_on_or_above(lower.shape[-1]), upper, lower)


def upright(gravity: Array) -> Array:
    """Return the rotation from the axes of the ground to axes whose z is against gravity.

    Args:
        gravity: in the axes of the ground [m/s²], or its direction, shape (3,).

    Returns:
        R, shape (3, 3): its rows are the new axes. x stays in the plane of the old x and the new z.
        Without gravity, or where gravity is along x, it is the identity.
    """
    size = float(np.linalg.norm(gravity))
    if size == 0.0 or (gravity[0] == 0.0 and gravity[1] == 0.0 and gravity[2] < 0.0):
        return np.eye(3)
    up = -gravity / size
    ahead = np.eye(3)[0] - up[0] * up
    length = float(np.linalg.norm(ahead))
    if length == 0.0:
        return np.eye(3)
    return np.stack([ahead / length, np.cross(up, ahead / length), up])


def symmetric(upper: Array) -> Array:
    """Return the symmetric matrices with this upper triangle, shape (..., n, n)."""
    return joined(upper, np.swapaxes(upper, -1, -2))


@lru_cache(maxsize=32)
def _on_or_above(size: int) -> NDArray[np.bool_]:
    return np.triu(np.ones((size, size), dtype=np.bool_))


def solve(matrix: Array | PartialPivLU, rhs: Array) -> Array:
    """Return the solution of matrix @ x = rhs, not finite where the matrix is singular.

    By Eigen, as it comes with Pinocchio: at these sizes NumPy's takes two to three times as long.

    Args:
        matrix: square, shape (n, n), or its `PartialPivLU` where several are to be solved with it.
        rhs: shape (n,) or (n, m).
    """
    factors = matrix if isinstance(matrix, PartialPivLU) else PartialPivLU(matrix)
    found: Array = factors.solve(rhs)
    return found.reshape(rhs.shape)


def quaternions(rotations: Array) -> Array:
    """Return the unit quaternions x, y, z, w of rotations (N, 3, 3), shape (N, 4).

    4 q qᵀ has entries that are sums of those of the matrix; its row with the largest diagonal entry
    is q without cancellation (Shepperd, 1978, Quaternion from rotation matrix, J. Guidance and
    Control 1(3)). `pin.Quaternion` of a matrix leaks 80 bytes each time (Pinocchio 4.1.0).
    """
    R = rotations
    outer = np.empty((len(R), 4, 4))
    trace = np.trace(R, axis1=1, axis2=2)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        outer[:, i, i] = 1.0 + 2.0 * R[:, i, i] - trace
        outer[:, i, j] = outer[:, j, i] = R[:, i, j] + R[:, j, i]
        outer[:, i, 3] = outer[:, 3, i] = R[:, k, j] - R[:, j, k]
    outer[:, 3, 3] = 1.0 + trace
    largest = np.argmax(np.diagonal(outer, axis1=1, axis2=2), axis=1)
    q = outer[np.arange(len(R)), largest]
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))
