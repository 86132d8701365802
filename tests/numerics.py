"""Checks of derivatives and of closeness, shared by all tests."""

from collections.abc import Callable

import numpy as np

Function = Callable[[np.ndarray], object]
TOLERANCE = 1e-6  # of a derivative, relative to its largest entry
REFINEMENT = 4.0  # between the two steps of a difference
_EPS = np.finfo(float).eps


def relative_error(actual: object, expected: object) -> float:
    """Largest difference over the largest expected entry."""
    a, b = np.asarray(actual, dtype=float), np.asarray(expected, dtype=float)
    assert a.shape == b.shape
    size = np.abs(b).max()
    assert size > 0.0, "an expected value of zero alone checks nothing"
    return float(np.abs(a - b).max() / size)


def central_difference(function: Function, x: np.ndarray, move: np.ndarray) -> np.ndarray:
    """(f(x + move) - f(x - move)) / 2."""
    return (_value(function, x + move) - _value(function, x - move)) / 2.0


def check_derivative(
    function: Function,
    derivative: object,
    x: np.ndarray,
    direction: np.ndarray,
    *,
    step: float = 1e-5,
    tolerance: float = TOLERANCE,
) -> None:
    """Assert that `derivative`, shaped as f(x), is that of f at x along `direction`.

    Central differences at two steps: the error must be small, and while it is above rounding it
    must shrink as the square of the step.
    """
    differences = [
        central_difference(function, x, h * direction) / h for h in (step, step / REFINEMENT)
    ]
    largest = float(np.abs(_value(function, x)).max())
    check_differences(np.asarray(derivative, dtype=float), differences, largest, step, tolerance)


def check_jacobian(
    function: Function,
    jacobian: object,
    x: np.ndarray,
    *,
    scale: np.ndarray | float = 1.0,
    step: float = 1e-5,
    tolerance: float = TOLERANCE,
) -> None:
    """Assert that `jacobian`, shape (*f(x).shape, n), holds; column j is seen in units scale_j."""
    scales = np.broadcast_to(scale, x.shape)
    exact = np.asarray(jacobian, dtype=float) * scales
    differences = jacobian_differences(function, x, scales, step)
    largest = float(np.abs(_value(function, x)).max())
    check_differences(exact, differences, largest, step, tolerance)


def jacobian_differences(
    function: Function, x: np.ndarray, scales: np.ndarray, step: float
) -> list[np.ndarray]:
    """Differences along every scaled axis at the two steps, shape (*f(x).shape, n) each."""
    return [
        np.stack([central_difference(function, x, h * move) / h for move in np.diag(scales)], -1)
        for h in (step, step / REFINEMENT)
    ]


def check_differences(
    exact: np.ndarray,
    differences: list[np.ndarray],
    largest: float,
    step: float,
    tolerance: float = TOLERANCE,
) -> None:
    """Assert that differences at two steps agree with an exact derivative.

    Args:
        exact: the derivative.
        differences: its approximations at `step` and `step` / REFINEMENT.
        largest: size of the function's values, which sets the rounding.
        step: the larger step.
        tolerance: relative to the largest entry of the derivative.
    """
    size = float(np.abs(exact).max())
    assert size > 0.0, "a derivative of zero checks nothing"
    assert all(d.shape == exact.shape for d in differences)
    coarse, fine = (float(np.abs(d - exact).max()) / size for d in differences)
    assert min(coarse, fine) <= tolerance, f"relative errors {coarse:.2e} and {fine:.2e}"
    rounding = 1e3 * _EPS * (largest + size) / (step * size)
    if coarse > 10.0 * REFINEMENT * rounding:
        assert coarse / fine > 0.5 * REFINEMENT**2, f"not of order 2: {coarse:.2e}, {fine:.2e}"


def _value(function: Function, x: np.ndarray) -> np.ndarray:
    return np.array(function(x), dtype=float)
