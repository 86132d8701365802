"""How well the unknowns are determined, on a dependence whose answers are known."""

import numpy as np
import pytest

from reproduction.identification import UNKNOWNS, Sensitivity, identified_values, misfit

RANGES = np.array([u.upper - u.lower for u in UNKNOWNS])


@pytest.fixture
def diagonal():
    jacobian = np.zeros((8, 5))
    np.fill_diagonal(jacobian, [4.0, 2.0, 1e-3, 0.5, 1.0])
    return Sensitivity(identified_values(), np.full(8, 0.03), jacobian)


def test_singular_values_and_reach(diagonal):
    values, directions = diagonal.singular
    np.testing.assert_allclose(values, [4.0, 2.0, 1.0, 0.5, 1e-3])
    np.testing.assert_allclose(directions[2], np.eye(5)[4], atol=1e-12)
    np.testing.assert_allclose(diagonal.reach * values, 0.03 * np.sqrt(8.0))


def test_play_is_that_of_the_ellipsoid_or_of_the_range(diagonal):
    low, high = diagonal.play.T
    half = 0.03 * np.sqrt(8.0) / 4.0 * RANGES[0]
    np.testing.assert_allclose([low[0], high[0]], diagonal.values[0] + np.array([-half, half]))
    np.testing.assert_allclose([low[2], high[2]], [UNKNOWNS[2].lower, UNKNOWNS[2].upper])


def test_misfit_lies_between_mean_and_largest_and_a_missing_walk_is_a_whole_unit():
    errors = np.array([0.01, -0.04, 0.02, 0.0, 0.01, 0.03, -0.02, 0.01])
    assert np.abs(errors).mean() < misfit(errors) < 0.04
    assert misfit(np.where(errors > 0.025, np.nan, errors)) > 0.5
