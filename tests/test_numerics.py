"""The checker of derivatives must refuse wrong ones."""

import numpy as np
import pytest
from numerics import check_derivative, check_jacobian, relative_error

X = np.array([0.3, -0.8, 1.7])


def curve(x):
    return np.stack([np.sin(x), x**3 * x[::-1]])


def jacobian(x):
    j = np.zeros((2, 3, 3))
    j[0] = np.diag(np.cos(x))
    j[1] = np.diag(3.0 * x**2 * x[::-1]) + np.fliplr(np.diag(x**3))
    return j


def test_right_derivatives_pass():
    check_jacobian(curve, jacobian(X), X, step=1e-3)
    check_jacobian(curve, jacobian(X), X, scale=np.array([1.0, 0.1, 5.0]), step=1e-4)
    direction = np.array([1.0, 2.0, -1.0])
    check_derivative(curve, jacobian(X) @ direction, X, direction, step=1e-3)


@pytest.mark.parametrize("error", [1.0 + 1e-5, 0.5, -1.0])
def test_wrong_derivatives_do_not(error):
    with pytest.raises(AssertionError, match="relative errors"):
        check_jacobian(curve, error * jacobian(X), X, step=1e-4)
    with pytest.raises(AssertionError, match="relative errors"):
        check_derivative(curve, error * jacobian(X)[..., 0], X, np.eye(3)[0], step=1e-4)


def test_a_small_error_that_stays_is_a_wrong_derivative():
    with pytest.raises(AssertionError, match="not of order 2"):
        check_jacobian(curve, (1.0 + 5e-7) * jacobian(X), X, step=1e-4)


def test_a_transposed_jacobian_is_seen():
    with pytest.raises(AssertionError, match="relative errors"):
        check_jacobian(lambda x: curve(x)[1], jacobian(X)[1].T, X, step=1e-4)


def test_zero_checks_nothing():
    with pytest.raises(AssertionError, match="checks nothing"):
        check_derivative(lambda x: 0.0 * x, np.zeros(3), X, np.ones(3))
    with pytest.raises(AssertionError, match="checks nothing"):
        relative_error(np.zeros(2), np.zeros(2))


def test_relative_error_is_relative_to_the_largest():
    assert relative_error([1.0, 200.0], [3.0, 200.0]) == pytest.approx(0.01)
