"""The whole-body controller's wrench cone, and what its walk keeps to."""

import itertools

import numpy as np
import pytest

from gaitopt.simulate.whole_body import wrench_cone


def test_the_wrench_cone_is_that_of_four_corner_forces(rng):
    """What pyramids of friction at the corners make is inside, with extreme rays on the rim."""
    friction, X, Y = 0.6, 0.11, 0.05
    cone = wrench_cone(friction, X, Y)
    corners = [np.array([x, y, 0.0]) for x, y in itertools.product((-X, X), (-Y, Y))]
    rays = [
        np.concatenate([force, np.cross(corner, force)])
        for corner in corners
        for force in (np.array([a * friction, b * friction, 1.0]) for a in (-1, 1) for b in (-1, 1))
    ]
    for _ in range(200):
        wrench = rng.exponential(1.0, len(rays)) @ rays
        assert (cone @ wrench >= -1e-12).all()
    touching = np.abs(cone @ np.array(rays).T) < 1e-12
    assert (touching.sum(axis=1)[1:] >= 4).all()  # every row but f_z >= 0 holds up some corner


def test_a_foot_that_twists_too_hard_is_outside():
    cone = wrench_cone(0.6, 0.11, 0.05)
    bearable = np.array([0.0, 0.0, 100.0, 0.0, 0.0, 0.6 * 0.16 * 100.0])
    assert (cone @ bearable).min() == pytest.approx(0.0, abs=1e-12)
    assert (cone @ (bearable * [1, 1, 1, 1, 1, 1.01])).min() < 0.0
