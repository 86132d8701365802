import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numerics import check_derivative, relative_error
from scipy.interpolate import CubicSpline

from gaitopt.gait.spline import spline_basis

INSTANTS = np.linspace(0.0, 1.0, 23)
quick = settings(deadline=None, derandomize=True, max_examples=40)


@st.composite
def knots(draw, least=2):
    gaps = draw(st.lists(st.floats(0.2, 1.0), min_size=least - 1, max_size=8))
    s = np.concatenate([[0.0], np.cumsum(gaps)])
    return s / s[-1]


@quick
@given(knots(), st.integers(0, 1000), st.floats(0.1, 2.0))
def test_it_is_the_clamped_spline_of_scipy(s, seed, duration):
    coefficients = np.random.default_rng(seed).normal(size=(s.size + 2, 3))
    start, end = coefficients[-2:]
    spline = CubicSpline(s * duration, coefficients[:-2], bc_type=((1, start), (1, end)))
    motion = spline_basis(s, INSTANTS).at(duration) @ coefficients
    for order in range(3):
        expected = spline(INSTANTS * duration, order)
        assert relative_error(motion[:, order], expected) < 1e-10


@quick
@given(knots(), st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4), st.floats(0.1, 2.0))
def test_cubics_are_exact(s, powers, duration):
    cubic = np.polynomial.Polynomial([*powers[:3], 1.0 + abs(powers[3])])
    at_knots, rate = cubic(s * duration), cubic.deriv()
    coefficients = np.concatenate([at_knots, [rate(0.0), rate(duration)]])
    motion = spline_basis(s, INSTANTS).at(duration) @ coefficients
    for order in range(3):
        expected = cubic.deriv(order)(INSTANTS * duration)
        np.testing.assert_allclose(
            motion[:, order], expected, atol=1e-10 * np.abs(powers).max(initial=1.0) / duration**2
        )


@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_knots_and_end_rates_are_met(count, rng):
    s, duration = np.linspace(0.0, 1.0, count), 0.4
    coefficients = rng.normal(size=count + 2)
    motion = spline_basis(s, s).at(duration) @ coefficients
    assert relative_error(motion[:, 0], coefficients[:-2]) < 1e-13
    assert relative_error(motion[[0, -1], 1], coefficients[-2:]) < 1e-11


@pytest.mark.parametrize("order", [0, 1])
def test_derivatives_in_the_duration(order):
    basis = spline_basis(np.linspace(0.0, 1.0, 4), INSTANTS)
    for row in range(3):  # q, dq and ddq differ by powers of T: check each in its own size

        def value(T, row=row):
            return basis.at(float(T[0]), order)[:, row]

        derivative = basis.at(0.4, order + 1)[:, row]
        if np.abs(derivative).max() > 0.0:
            check_derivative(value, derivative, np.array([0.4]), np.ones(1), step=1e-4)
    assert np.abs(basis.at(0.4, order + 1)).max() > 1.0


def test_slower_motion_is_slower():
    basis = spline_basis(np.linspace(0.0, 1.0, 4), INSTANTS)
    knots = np.array([0.2, 0.7, -0.4, 0.3, 0.0, 0.0])
    fast, slow = basis.at(0.4) @ knots, basis.at(0.8) @ knots
    assert relative_error(slow[:, 0], fast[:, 0]) < 1e-14
    assert relative_error(slow[:, 1], fast[:, 1] / 2.0) < 1e-13
    assert relative_error(slow[:, 2], fast[:, 2] / 4.0) < 1e-13
