"""The rows of gaps between bodies, whose Jacobian is formed as far as it is asked for."""

import functools
from dataclasses import dataclass

import numpy as np
import pytest
from humanoids import add_arms, edits
from numerics import check_jacobian
from urdf_edits import edited_urdf

from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.costs import PeakTorque
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import humanoid_task, preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.terrain import Profile, Terrain
from gaitopt.gait.walk_point import Product
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot
from gaitopt.nlp import Point
from gaitopt.solvers.adapters import Evaluator


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


def test_rows_are_the_same_before_and_after_all_are_formed(point, rng):
    anew = WalkProblem(walk().robot, walk().task)
    point, rows = anew.point(point.x), np.sort(rng.choice(point.rows.size, 200, replace=False))
    few, change = point.slopes[rows], point.slopes @ walk().variables.scale
    assert not point.slopes.asked
    assert point.finite
    assert len(point.slopes.parts) < len(anew.blocks)
    np.testing.assert_array_equal(point.slopes[rows[1:]], few[1:])
    np.testing.assert_array_equal(point.slopes[rows], few)
    np.testing.assert_allclose(point.slopes @ walk().variables.scale, change, atol=1e-10)
    again = anew.point(point.x + 1e-6).slopes  # for one who asks for all
    assert len(again._found) == len(point.slopes.parts)
    assert not again.asked


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
    rows = np.sort(np.random.default_rng(0).choice(said.size, 300, replace=False))
    closer = point.most_change(scale, rows)
    assert (closer >= told.most_change(scale, rows) * (1.0 - 1e-12) - 1e-15).all()
    assert (closer <= said[rows] * (1.0 + 1e-12)).all()
    assert (closer < 0.9 * said[rows]).any()


def test_large_tables_left_as_they_are_give_the_same_rows(point, rng, monkeypatch):
    monkeypatch.setattr("gaitopt.gait.walk_point._LARGE", 0)
    large = WalkProblem(walk().robot, walk().task).point(point.x)
    parts = len(large.slopes.parts)
    monkeypatch.undo()
    assert parts > len(point.slopes.parts)
    scale, step = walk().variables.scale, rng.normal(size=point.x.size)
    rows = np.sort(rng.choice(point.rows.size, 200, replace=False))
    np.testing.assert_array_equal(large.jacobian, point.jacobian)
    np.testing.assert_allclose(large.slopes[rows], point.slopes[rows], rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(large.slopes @ step, point.slopes @ step, rtol=1e-12, atol=1e-12)
    for some in (None, rows):
        told = point.most_change(scale, some)
        np.testing.assert_allclose(large.most_change(scale, some), told, rtol=1e-12, atol=1e-12)


def test_a_stride_keeps_the_products_of_both_steps(rng):
    task = humanoid_task(walk().robot, speed=0.6, samples=7, turn_rate=0.3)
    problem = WalkProblem(walk().robot, task)
    scale, rows = problem.variables.scale, problem.rows.lower.size
    point = problem.point(first_guess(problem) + 0.05 * scale * rng.normal(size=scale.size))
    kept = [part for part in point.slopes.parts if isinstance(part, Product)]
    assert len(kept) == 4  # gaps of legs and of arms, of two steps
    anew = WalkProblem(walk().robot, task).point(point.x)
    some = np.sort(rng.choice(rows, 300, replace=False))
    few, change = anew.slopes[some], anew.slopes @ scale
    assert anew.finite
    np.testing.assert_allclose(few, point.jacobian[some], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(change, point.jacobian @ scale, atol=1e-10)
    gaps = problem.rows_of("arm gap")
    np.testing.assert_allclose(
        anew.slopes[np.arange(gaps.start, gaps.stop)], point.jacobian[gaps], atol=1e-12
    )
    check_jacobian(
        lambda d: problem.values(point.x + d).rows[gaps],
        point.jacobian[gaps], np.zeros(scale.size), scale=scale,
    )  # fmt: skip


def test_numbers_that_are_none_are_seen(point):
    assert point.finite
    point.slopes.parts[-1].angles[0, 0, 0] = np.nan
    assert not point.finite


class Ground(Profile):
    """A level ground, whose slope is told as long as it is sound."""

    length = 0.1
    sound = True

    def height(self, x):
        return 0.0 * x, 0.0 * x if self.sound else np.full_like(x, np.nan), 0.0 * x


@dataclass(frozen=True)
class Field(Terrain):
    """A terrain of one's own."""

    name, shaped = "field", True
    ground: Ground

    def words(self, step):
        return "a field"

    @property
    def down(self):
        return 0.0, 0.0, -1.0

    def profile(self, sole, step, nosing):
        return self.ground


def test_slopes_of_a_ground_of_ones_own_that_are_none_are_seen(robot):
    ground = Ground()
    problem = WalkProblem(robot, preset_task(samples=7, terrain=Field(ground)))
    x = first_guess(problem)
    assert Evaluator(problem).point(x).finite
    ground.sound = False
    assert np.isfinite(problem.values(x + 1e-6).rows).all()
    with pytest.raises(EvaluationError, match="a derivative"):
        Evaluator(problem).point(x + 1e-6)


def test_the_cost_bends_as_squares_of_torques_that_were_linear(point, rng):
    problem, h = walk(), 1e-6
    step = rng.normal(size=point.x.size) * problem.variables.scale
    step[problem.layout.shape] = 0.0  # nor does the way
    torque = [problem.whole(point.x + at * step).read(quantities.TORQUE) for at in (-h, h)]
    rate = ((torque[1] - torque[0]) / (2.0 * h))[: problem.grid.weights.size]
    whole = problem.whole(point.x)
    squares = problem.grid.weights @ (rate**2).sum(axis=1) * whole.duration / whole.step_length
    H = problem.cost_curvature(point.x)
    assert step @ H @ step == pytest.approx(2.0 * problem.cost_scale * squares, rel=1e-6)
    assert np.linalg.eigvalsh(H).min() > -1e-12 * np.linalg.norm(H)


def test_legs_alone_and_linear_costs_have_no_such_curvature(robot):
    legs = WalkProblem(robot, humanoid_task(robot, speed=0.6, samples=7))
    assert legs.cost_curvature(first_guess(legs)) is None
    arms = walk()
    largest = WalkProblem(arms.robot, arms.task.with_changes(cost=PeakTorque()))
    assert largest.cost_curvature(first_guess(largest)) is None
