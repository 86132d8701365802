"""Spatial algebra against Pinocchio's own."""

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error

from gaitopt.mechanics.spatial import (
    cross_force_matrix,
    force_cross_matrix,
    motion_cross_matrix,
    pseudo_inertia,
    quaternions,
    skew,
    world_inertias,
)

STACK = (2, 3)


@pytest.fixture
def motions(rng):
    return rng.normal(size=(*STACK, 6)), rng.normal(size=(*STACK, 6))


def each(function, *stacks):
    """Apply a function to every pair of six-vectors of a stack."""
    pairs = zip(*(s.reshape(-1, 6) for s in stacks), strict=True)
    return np.array([function(*pair).vector for pair in pairs]).reshape(*STACK, 6)


def test_skew_is_the_cross_product(rng):
    a, b = rng.normal(size=(2, *STACK, 3))
    product = (skew(a) @ b[..., None])[..., 0]
    assert relative_error(product, np.cross(a, b)) < 1e-15


def test_motion_cross_motion(motions):
    m, n = motions
    expected = each(lambda a, b: pin.Motion(a).cross(pin.Motion(b)), m, n)
    assert relative_error((motion_cross_matrix(m) @ n[..., None])[..., 0], expected) < 1e-15


def test_motion_cross_force(motions):
    m, f = motions
    expected = each(lambda a, b: pin.Motion(a).cross(pin.Force(b)), m, f)
    assert relative_error((force_cross_matrix(m) @ f[..., None])[..., 0], expected) < 1e-15
    assert relative_error((cross_force_matrix(f) @ m[..., None])[..., 0], expected) < 1e-15


def test_force_cross_is_dual_to_motion_cross(motions, rng):
    m, n = motions
    f = rng.normal(size=(*STACK, 6))
    # f . (m x n) = -(m x* f) . n: the power of a force does not depend on who looks at it.
    power = (f * (motion_cross_matrix(m) @ n[..., None])[..., 0]).sum(axis=-1)
    dual = -((force_cross_matrix(m) @ f[..., None])[..., 0] * n).sum(axis=-1)
    assert relative_error(power, dual) < 1e-13


def test_inertias_in_the_world(rng):
    bodies = [pin.Inertia.Random() for _ in range(4)]
    placements = [[pin.SE3.Random() for _ in bodies] for _ in range(3)]
    inertias = world_inertias(
        np.array([pseudo_inertia(b.mass, b.lever, b.inertia) for b in bodies]),
        np.array([[p.homogeneous for p in column] for column in zip(*placements, strict=True)]),
    )
    expected = [[p.act(b).matrix() for p, b in zip(row, bodies, strict=True)] for row in placements]
    assert relative_error(inertias, expected) < 1e-14


def test_quaternions_are_those_of_the_rotations():
    """Also of half turns, where three of the four entries of Shepperd's rows vanish."""
    rng = np.random.default_rng(4)
    q = rng.normal(size=(200, 4))
    q[:20, 3] = 0.0
    q[20:30] = np.tile(np.eye(4), (3, 1))[:10]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    x, y, z, w = q.T
    rotations = np.array([pin.Quaternion(*one).matrix() for one in zip(w, x, y, z, strict=True)])
    found = quaternions(rotations)
    assert np.abs(np.sum(found * q, axis=1)) == pytest.approx(1.0, abs=1e-14)
    again = np.array([pin.Quaternion(*one).matrix() for one in found[:, [3, 0, 1, 2]]])
    assert again == pytest.approx(rotations, abs=1e-14)
    assert quaternions(np.zeros((0, 3, 3))).shape == (0, 4)
