"""Spatial algebra on stacks of six-vectors (linear part first), as in Pinocchio.

A motion is the velocity [m/s, rad/s] of the body point at the origin and its rotation; a force is
[N, N.m] with the moment about the origin (Featherstone, 2008, chapter 2, with linear and angular
parts exchanged).
"""

from __future__ import annotations

import numpy as np

from gaitopt.nlp import Array


def skew(vector: Array) -> Array:
    """Return the cross-product matrices of vectors (..., 3), shape (..., 3, 3)."""
    matrix = np.zeros((*vector.shape, 3))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = z, -y, x
    return matrix


def cross(a: Array, b: Array) -> Array:
    """Return a x b for stacks of vectors (..., 3); on small stacks much faster than NumPy's."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(a[..., j] * b[..., k], a[..., k] * b[..., j], out=result[..., i])
    return result


def moved(motion: Array, other: Array) -> Array:
    """Return motion x other for stacks of motions (..., 6)."""
    result = np.empty(np.broadcast_shapes(motion.shape, other.shape))
    linear, angular = motion[..., :3], motion[..., 3:]
    result[..., :3] = cross(angular, other[..., :3]) + cross(linear, other[..., 3:])
    result[..., 3:] = cross(angular, other[..., 3:])
    return result


def pushed(motion: Array, force: Array) -> Array:
    """Return motion x* force for stacks of motions and forces (..., 6)."""
    result = np.empty(np.broadcast_shapes(motion.shape, force.shape))
    linear, angular = motion[..., :3], motion[..., 3:]
    result[..., :3] = cross(angular, force[..., :3])
    result[..., 3:] = cross(angular, force[..., 3:]) + cross(linear, force[..., :3])
    return result


def motion_cross(motion: Array) -> Array:
    """Return the matrices of y -> motion x y on motions, shape (..., 6, 6)."""
    matrix = np.zeros((*motion.shape, 6))
    matrix[..., :3, :3] = matrix[..., 3:, 3:] = skew(motion[..., 3:])
    matrix[..., :3, 3:] = skew(motion[..., :3])
    return matrix


def force_cross(motion: Array) -> Array:
    """Return the matrices of f -> motion x* f on forces, shape (..., 6, 6)."""
    return -np.swapaxes(motion_cross(motion), -1, -2)


def cross_force(force: Array) -> Array:
    """Return the matrices of y -> y x* force, shape (..., 6, 6)."""
    matrix = np.zeros((*force.shape, 6))
    linear = skew(force[..., :3])
    matrix[..., :3, 3:] = matrix[..., 3:, :3] = -linear
    matrix[..., 3:, 3:] = -skew(force[..., 3:])
    return matrix


def world_inertias(
    mass: Array, lever: Array, inertia: Array, rotation: Array, origin: Array
) -> Array:
    """Return spatial inertias about the world origin, shape (..., 6, 6).

    Args:
        mass: shape (b,) [kg].
        lever: centres of mass in the body frames, shape (b, 3) [m].
        inertia: about the centres of mass in the body frames, shape (b, 3, 3) [kg.m²].
        rotation: body axes in the world, shape (..., b, 3, 3).
        origin: body origins in the world, shape (..., b, 3) [m].
    """
    centre = origin + (rotation @ lever[:, :, None])[..., 0]
    c = skew(centre)
    mc = mass[:, None, None] * c
    spatial = np.empty((*centre.shape[:-1], 6, 6))
    spatial[..., :3, :3] = mass[:, None, None] * np.eye(3)
    spatial[..., :3, 3:] = -mc
    spatial[..., 3:, :3] = mc
    spatial[..., 3:, 3:] = rotation @ inertia @ np.swapaxes(rotation, -1, -2) - mc @ c
    return spatial
