"""Checks of derivatives and of closeness, shared by all tests."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

Function = Callable[[np.ndarray], object]
TOLERANCE = 1e-6  # of a derivative, relative to its largest entry
REFINEMENT = 4.0  # between the two steps of a difference
ROUNDING = 1e-7  # errors below this need not shrink with the step any more


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


def steps(step: float, count: int = 2) -> list[float]:
    """Steps of differences, the largest first."""
    return [step / REFINEMENT**k for k in range(count)]


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

    Central differences at two steps: the error must be small, and must shrink as the square of
    the step (or grow with its inverse, which is rounding): one that stays is a wrong derivative.
    """
    found = [central_difference(function, x, h * direction) / h for h in steps(step)]
    check_differences(np.asarray(derivative, dtype=float), found, tolerance)


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
    found = [jacobian_difference(function, x, scales, h) for h in steps(step)]
    check_differences(np.asarray(jacobian, dtype=float) * scales, found, tolerance)


def jacobian_difference(
    function: Function, x: np.ndarray, scales: np.ndarray, step: float
) -> np.ndarray:
    """Central differences along every scaled axis, shape (*f(x).shape, n)."""
    moves = step * np.diag(scales)
    return np.stack([central_difference(function, x, move) / step for move in moves], axis=-1)


def check_differences(
    exact: np.ndarray, differences: list[np.ndarray], tolerance: float = TOLERANCE
) -> None:
    """Assert that differences at several steps agree with an exact derivative.

    Args:
        exact: the derivative.
        differences: its approximations at `steps(...)`, the largest step first.
        tolerance: relative to the largest entry of the derivative.
    """
    size = float(np.abs(exact).max())
    assert size > 0.0, "a derivative of zero checks nothing"
    assert all(d.shape == exact.shape for d in differences)
    errors = [float(np.abs(d - exact).max()) / size for d in differences]
    told = "relative errors " + ", ".join(f"{e:.2e}" for e in errors)
    assert min(errors) <= tolerance, told
    ratios = [a / b for a, b in pairwise(errors)]
    shrinks, grows = max(ratios) > 0.5 * REFINEMENT**2, min(ratios) < 0.5
    assert min(errors) <= ROUNDING or shrinks or grows, f"not of order 2: {told}"


def _value(function: Function, x: np.ndarray) -> np.ndarray:
    return np.array(function(x), dtype=float)
