"""Meshes made smaller look the same: where their surface is, how it faces, and its edges."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from gaitopt.view.robot_shapes import FEW, simplified


def ball(count: int, radius: float) -> np.ndarray:
    """Triangles (M, 3, 3) of a sphere."""
    up, around = np.linspace(0.0, np.pi, count), np.linspace(0.0, 2.0 * np.pi, 2 * count)
    theta, phi = np.meshgrid(up, around, indexing="ij")
    points = radius * np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(
        -1, 3, 3
    )


def block(count: int, size: float) -> np.ndarray:
    """Triangles of a cube whose sides are cut into many."""
    at = np.linspace(0.0, size, count)
    u, v = np.meshgrid(at, at, indexing="ij")
    sides = []
    for axis in range(3):
        for end, turn in ((0.0, 1), (size, -1)):
            points = np.roll(np.stack([np.full_like(u, end), u, v], axis=-1), axis, axis=-1)
            a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
            for corner in ((a, c, b), (a, d, c)):
                sides.append(np.stack(corner[::turn], axis=2).reshape(-1, 3, 3))
    return np.concatenate(sides)


@pytest.mark.parametrize("radius", [0.05, 80.0])
def test_a_ball_stays_round(radius):
    corners = ball(60, radius)
    found = simplified(corners)
    assert len(found.faces) < 0.25 * len(corners)
    assert np.linalg.norm(found.corners, axis=1) == pytest.approx(radius, rel=0.01)
    outward = found.corners / np.linalg.norm(found.corners, axis=1, keepdims=True)
    facing = np.einsum("ij,ij->i", found.normals, outward)
    assert (facing > 0.95).mean() > 0.99  # but for slivers too thin to be seen
    far, _ = cKDTree(found.corners[found.faces].mean(axis=1)).query(corners.mean(axis=1))
    assert far.max() < 0.25 * radius  # there are no holes


def test_a_cube_keeps_its_size_and_its_edges():
    corners = block(25, 0.2)
    found = simplified(corners)
    assert len(found.faces) < 0.5 * len(corners)
    a, b, c = found.corners[found.faces].transpose(1, 0, 2)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == pytest.approx(0.2**3, rel=0.02)
    across = np.cross(b - a, c - a)
    size = np.linalg.norm(across, axis=1, keepdims=True)
    kept = size[:, 0] > 1e-6 * size.max()
    facing = np.einsum("ij,ikj->ik", across[kept] / size[kept], found.normals[found.faces][kept])
    assert np.median(facing) > 0.999  # a normal shared across an edge would face between
    assert (facing > 0.9).mean() > 0.97


def test_many_small_parts_do_not_cost_a_large_one_its_shape():
    """A shell over washers, flat discs with an edge, which cannot be made of fewer triangles."""
    shell, angles = ball(60, 1.0), np.linspace(0.0, 2.0 * np.pi, 9)
    rim = 0.004 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(9)])
    disc = np.stack([rim[:-1], rim[1:], np.zeros((8, 3))], axis=1)
    at = np.random.default_rng(0).normal(size=(4000, 3))
    at *= 0.5 / np.linalg.norm(at, axis=1, keepdims=True)
    found = simplified(np.concatenate([shell, *(disc + place for place in at)]))
    outer = found.corners[np.linalg.norm(found.corners, axis=1) > 0.75]
    assert np.linalg.norm(outer, axis=1) == pytest.approx(1.0, rel=0.02)
    assert len(outer) > 200
    far, _ = cKDTree(outer).query(shell.mean(axis=1))
    assert far.max() < 0.3  # it is whole


def test_small_and_broken_meshes_are_left():
    assert simplified(ball(8, 1.0)[:FEW]) is None
    assert simplified(np.zeros((2 * FEW, 3, 3))) is None


def test_the_same_mesh_gives_the_same():
    corners = ball(40, 1.0)
    first, second = simplified(corners), simplified(corners.copy())
    np.testing.assert_array_equal(first.corners, second.corners)
    np.testing.assert_array_equal(first.faces, second.faces)
