"""Exact derivatives of strides of two steps against differences."""

import numpy as np
import pytest
from numerics import central_difference, check_differences, relative_error, steps
from strides import WAYS, point_of
from synthetic_bipeds import synthetic

STEPS = steps(4e-4, 6)


def directions(problem, count=2):
    draw = np.random.default_rng(7).normal(size=(count, problem.layout.size))
    return draw * problem.variables.scale


def check_slope(function, slope, x, d):
    """Against differences at six steps: friction cones need small ones, impacts large ones."""
    check_differences(slope, [central_difference(function, x, h * d) / h for h in STEPS])


def check_slopes(problem, x):
    """Cost and every row, their slopes, and the Hessian of cost and of each family."""
    point, (d, _) = problem.point(x), directions(problem)
    check_slope(lambda at: problem.values(at).cost, point.gradient @ d, x, d)
    for block in problem.blocks:
        rows = problem.rows_of(block.name)
        check_slope(
            lambda at, rows=rows: problem.values(at).rows[rows], point.jacobian[rows] @ d, x, d
        )
    size = problem.rows.lower.size
    slopes = [
        (_slopes(problem, x + h * d) - _slopes(problem, x - h * d)) / (2.0 * h) for h in STEPS
    ]
    families = [(np.zeros(size), 1.0)]
    for block in problem.blocks:
        rows, y = problem.rows_of(block.name), np.zeros(size)
        y[rows] = np.random.default_rng(1).normal(size=rows.stop - rows.start)
        families.append((y, 0.0))
    for y, cost in families:
        H = problem.hessian(x, y, cost)
        if H.any():  # else the rows are linear
            assert relative_error(H, H.T) < 1e-12
            check_differences(H @ d, [np.r_[cost, y] @ slope for slope in slopes])


def _slopes(problem, x):
    point = problem.point(x)
    return np.vstack([point.gradient, point.jacobian])


@pytest.mark.parametrize("name", WAYS)
def test_slopes_and_hessians_are_those_of_the_walk(name):
    check_slopes(*point_of(name))


def test_slopes_of_a_robot_with_other_joints():
    robot = synthetic("seven, waist and arms")
    check_slopes(*point_of("every way, duration free, lifted", robot))
