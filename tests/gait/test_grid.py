import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt.errors import InputError
from gaitopt.gait.grid import uniform_grid


@given(st.integers(1, 20), st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4))
@settings(deadline=None, derandomize=True)
def test_simpson_is_exact_on_cubics(half, powers):
    grid = uniform_grid(2 * half + 1)
    cubic = np.polynomial.Polynomial([1.0 + abs(powers[0]), *powers[1:]])
    exact = cubic.integ()(1.0) - cubic.integ()(0.0)
    assert grid.weights @ cubic(grid.instants) == pytest.approx(exact, abs=1e-12)


def test_simpson_has_order_four_on_quartics():
    errors = [abs(g.weights @ g.instants**4 - 0.2) for g in (uniform_grid(11), uniform_grid(21))]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.01)


def test_euler_is_the_sum_of_left_end_points():
    grid = uniform_grid(6, "euler")
    np.testing.assert_allclose(grid.weights, [0.2, 0.2, 0.2, 0.2, 0.2, 0.0], atol=1e-16)
    assert grid.weights @ grid.instants == pytest.approx(0.4)


@pytest.mark.parametrize("quadrature", ["simpson", "euler"])
def test_instants_are_equidistant_and_weights_fill_the_step(quadrature):
    grid = uniform_grid(31, quadrature)
    np.testing.assert_allclose(np.diff(grid.instants), 1.0 / 30.0, atol=1e-15)
    assert (grid.instants[0], grid.instants[-1]) == (0.0, 1.0)
    assert grid.weights.sum() == pytest.approx(1.0, abs=1e-14)
    assert grid.count == grid.nodes == 31


def test_added_instants_come_last_in_order_and_weigh_nothing():
    grid = uniform_grid(11)
    more = grid.with_instants(np.array([0.77, 0.13]))
    np.testing.assert_array_equal(more.instants[:11], grid.instants)
    np.testing.assert_array_equal(more.instants[11:], [0.13, 0.77])
    np.testing.assert_array_equal(more.weights[:11], grid.weights)
    assert (more.nodes, more.count, more.weights[11:].tolist()) == (11, 13, [0.0, 0.0])


def test_instants_added_later_stay_behind_those_added_before():
    grid = uniform_grid(11).with_instants(np.array([0.77])).with_instants(np.array([0.13, 0.9]))
    np.testing.assert_array_equal(grid.instants[11:], [0.77, 0.13])


def test_instants_that_are_there_are_not_added_twice():
    grid = uniform_grid(11)
    again = grid.with_instants(np.array([0.3, 0.3 + 1e-14, 0.31, 0.31]))
    np.testing.assert_allclose(again.instants[11:], [0.31], atol=1e-12)


def test_the_given_grid_is_kept():
    grid = uniform_grid(11)
    grid.with_instants(np.array([0.13]))
    assert grid.count == 11


@pytest.mark.parametrize(
    ("samples", "quadrature", "message"),
    [
        (30, "simpson", r"needs an odd number of samples, not 30; give 31, or quadrature 'euler'"),
        (2, "euler", "2 samples are too few for a step; give at least 3"),
        (1, "simpson", "1 samples are too few"),
        (31, "gauss", "quadrature 'gauss' is unknown; choose simpson or euler"),
    ],
)
def test_what_cannot_be_a_grid_is_refused(samples, quadrature, message):
    with pytest.raises(InputError, match=message):
        uniform_grid(samples, quadrature)
