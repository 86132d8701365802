"""The rows of gaps between bodies, whose Jacobian is formed as far as it is asked for."""

import functools

import numpy as np
import pytest
from humanoids import add_arms, edits
from numerics import check_jacobian
from urdf_edits import edited_urdf

from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot
from gaitopt.nlp import Point


@functools.cache
def walk():
    robot = Robot.from_urdf(
        edited_urdf(edits(add_arms(4, step=-0.22))), choices=ImportOptions(moving=("*arm_joint*",))
    )
    return WalkProblem(robot, humanoid_task(robot, speed=0.6, samples=7))


@pytest.fixture
def point(rng):
    problem = walk()
    x = first_guess(problem)
    return problem.point(x + 0.05 * problem.variables.scale * rng.normal(size=x.size))


def test_rows_are_those_of_the_whole(point, rng):
    rows = np.sort(rng.choice(point.rows.size, 200, replace=False))
    for some in (rows, rows[:1], rows[:0], np.arange(point.rows.size)):
        np.testing.assert_allclose(point.slopes[some], point.jacobian[some], atol=1e-12)


def test_gaps_change_as_their_slopes_tell(point):
    problem = walk()
    gaps = problem.rows_of("arm gap")
    check_jacobian(
        lambda d: problem.values(point.x + d).rows[gaps],
        point.slopes[np.arange(gaps.start, gaps.stop)],
        np.zeros(point.x.size),
        scale=problem.variables.scale,
    )


def test_a_step_changes_rows_as_the_whole_does(point, rng):
    step = rng.normal(size=point.x.size)
    np.testing.assert_allclose(point.slopes @ step, point.jacobian @ step, atol=1e-10)


def test_no_row_changes_by_more_than_is_said(point):
    scale = walk().variables.scale
    said = point.most_change(scale)
    told = Point(point.x, point.cost, point.rows, point.gradient, point.jacobian)
    assert (said >= told.most_change(scale) * (1.0 - 1e-12)).all()
    gaps = walk().rows_of("arm gap")
    others = np.delete(np.arange(said.size), np.r_[gaps, walk().rows_of("leg gap")])
    np.testing.assert_allclose(said[others], told.most_change(scale)[others])


def test_numbers_that_are_none_are_seen(point):
    assert point.finite
    point.slopes._parts[-1].local[0, 0, 0] = np.nan
    assert not point.finite
