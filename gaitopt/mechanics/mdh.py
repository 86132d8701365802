"""Geometry of a serial chain in the notation of Khalil and Kleinfinger (1986), Table 1.

Frame j follows frame j-1 by turning gamma about z and moving b along z, turning alpha about the
new x and moving d along it, then turning theta about z_j and moving r along it:

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

In Table 1 every x axis is the common normal of two joint axes and gamma = b = 0; those two let a
frame sit anywhere on its joint axis, so that every chain can be written.
"""

from __future__ import annotations

import math

import numpy as np

from gaitopt.nlp import Array

PARALLEL = 1e-8
"""Below this sine two axes count as parallel [rad]: the dropped tilt and the rounding of the
distant feet of their common normal are then both about 1e-8 of a length."""


def hat(vector: Array) -> Array:
    """Return the matrices H with H @ v = vector x v, shape (..., 3, 3), for vectors (..., 3)."""
    matrix = np.zeros((*vector.shape, 3))
    matrix[..., 2, 1], matrix[..., 1, 2] = vector[..., 0], -vector[..., 0]
    matrix[..., 0, 2], matrix[..., 2, 0] = vector[..., 1], -vector[..., 1]
    matrix[..., 1, 0], matrix[..., 0, 1] = vector[..., 2], -vector[..., 2]
    return matrix


def times(matrix: Array, vector: Array) -> Array:
    """Return the products of matrices (..., m, k) with vectors (..., k); shape (..., m)."""
    product: Array = (matrix @ vector[..., None])[..., 0]
    return product


def transforms(
    gamma: Array, b: Array, alpha: Array, d: Array, theta: Array, r: Array
) -> tuple[Array, Array]:
    """Return where each frame lies in the frame before it.

    Args:
        gamma: of each joint, shape (n,) [rad].
        b: of each joint, shape (n,) [m].
        alpha: of each joint, shape (n,) [rad].
        d: of each joint, shape (n,) [m].
        theta: of each joint, shape (..., n) [rad].
        r: of each joint, shape (..., n) [m].

    Returns:
        Rotations A = ^{j-1}A_j, shape (..., n, 3, 3), and origins P = ^{j-1}P_j, (..., n, 3) [m].
    """
    x, y, z = _turned_axes(gamma, alpha)
    cosine, sine = np.cos(theta)[..., None], np.sin(theta)[..., None]
    z_j = np.broadcast_to(z, (*theta.shape, 3))
    A = np.stack([cosine * x + sine * y, cosine * y - sine * x, z_j], axis=-1)
    P = np.outer(b, [0.0, 0.0, 1.0]) + d[:, None] * x + r[..., None] * z
    return A, P


def _turned_axes(gamma: Array, alpha: Array) -> tuple[Array, Array, Array]:
    """Columns of Rot(z, gamma) Rot(x, alpha), each of shape (n, 3)."""
    cg, sg, ca, sa = np.cos(gamma), np.sin(gamma), np.cos(alpha), np.sin(alpha)
    zero = np.zeros_like(cg)
    x = np.stack([cg, sg, zero], axis=-1)
    y = np.stack([-sg * ca, cg * ca, sa], axis=-1)
    z = np.stack([sg * sa, -cg * sa, ca], axis=-1)
    return x, y, z


def placements(A: Array, P: Array) -> tuple[Array, Array]:
    """Chain the transforms of `transforms`.

    Args:
        A: rotations, shape (..., n, 3, 3).
        P: origins, shape (..., n, 3) [m].

    Returns:
        Rotations ^0A_j, shape (..., n + 1, 3, 3), and origins ^0P_j, shape (..., n + 1, 3) [m], of
        the frames 0 to n in frame 0.
    """
    rotations = [np.broadcast_to(np.eye(3), (*A.shape[:-3], 3, 3))]
    origins = [np.zeros((*P.shape[:-2], 3))]
    for j in range(A.shape[-3]):
        origins.append(origins[-1] + times(rotations[-1], P[..., j, :]))
        rotations.append(rotations[-1] @ A[..., j, :, :])
    return np.stack(rotations, axis=-3), np.stack(origins, axis=-2)


def parameters(rotation: Array, origin: Array) -> tuple[float, float, float, float, float, float]:
    """Return (gamma, b, alpha, d, theta, r) that place a frame in the frame before it.

    Args:
        rotation: of the frame, shape (3, 3).
        origin: of the frame, shape (3,) [m].
    """
    zx, zy, zz = (float(value) for value in rotation[:, 2])
    px, py, pz = (float(value) for value in origin)
    sine = math.hypot(zx, zy)
    if sine > PARALLEL:
        gamma, alpha = math.atan2(zx, -zy), math.atan2(sine, zz)
        d = px * math.cos(gamma) + py * math.sin(gamma)
        r = (px * math.sin(gamma) - py * math.cos(gamma)) / sine
        b = pz - r * zz
    else:
        # Parallel axes have a common normal everywhere: take the one through the first origin.
        gamma, alpha = math.atan2(py, px), 0.0 if zz > 0.0 else math.pi
        d, b, r = math.hypot(px, py), 0.0, math.copysign(1.0, zz) * pz
    x, y, _ = _turned_axes(np.array([gamma]), np.array([alpha]))
    theta = math.atan2(float(y[0] @ rotation[:, 0]), float(x[0] @ rotation[:, 0]))
    return gamma, b, alpha, d, theta, r
