"""Khalil and Kleinfinger's parameters: every frame can be placed, however the axes lie."""

import numpy as np
import pytest
from random_chains import (
    EXACT,
    link_matrices,
    random_cloud_chain,
    relative,
    seeded,
    turned_about,
)

from gaitopt.mechanics.newton_euler import PARALLEL, link_placements, parameters, transforms

X, _, Z = np.eye(3)


@seeded
def test_link_frames_are_products_of_elementary_matrices(rng):
    chain, _ = random_cloud_chain(rng)
    q = rng.uniform(-3.0, 3.0, chain.dof)
    rotations, origins = link_placements(chain, q)
    expected = np.array(link_matrices(chain, q))
    assert relative(rotations, expected[:, :3, :3]) < EXACT
    assert relative(origins, expected[:, :3, 3]) < EXACT


@pytest.mark.parametrize(
    "tilt",
    [
        0.7,
        3.0,
        np.pi,
        0.0,
        1e-3,
        1e-6,
        3e-8,
        2.0 * PARALLEL,
        0.5 * PARALLEL,
        np.pi - 1e-6,
        np.pi - 3e-8,
    ],
)
@seeded
def test_parameters_place_any_frame(tilt, rng):
    about = rng.normal(size=2)
    tilted = turned_about([*about / np.linalg.norm(about), 0.0], tilt)
    turns = (turned_about(Z, angle) for angle in rng.uniform(-3.0, 3.0, 2))
    rotation = next(turns) @ tilted @ next(turns)
    origin = rng.uniform(-1.0, 1.0, 3)
    values = [np.array([value]) for value in parameters(rotation, origin)]
    A, P = transforms(*values)
    assert relative(A[0], rotation) < 1e-12
    assert relative(P[0], origin) < 1e-12  # wherever the common normal of the axes is


def test_parameters_of_axes_that_meet_or_coincide():
    quarter = turned_about(X, np.pi / 2.0)
    assert parameters(quarter, np.zeros(3)) == pytest.approx((0, 0, np.pi / 2, 0, 0, 0, 0))
    moved_along = parameters(turned_about(Z, 0.3), 0.2 * Z)
    assert moved_along == pytest.approx((0, 0, 0, 0, 0.3, 0.2, 0))
    parallel = parameters(np.eye(3), np.array([0.3, 0.4, -0.1]))
    turn = np.arctan2(4.0, 3.0)
    assert parallel == pytest.approx((turn, 0, 0, 0.5, -turn, -0.1, 0))
