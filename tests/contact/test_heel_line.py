"""The foot on its heel: the mode itself, and a walk that ends on it, as a step backwards would."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest
from numerics import check_differences, jacobian_difference, relative_error, steps

from gaitopt.contact import FlatFoot, HeelLine, Phase, PhaseEnd, Schedule
from gaitopt.design.audit import audit
from gaitopt.design.certificate import ask_referee, on_fine_grid
from gaitopt.errors import GaitFileError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.sole import Sole
from gaitopt.tolerances import MOMENTUM, REFEREE

SOLE = Sole(0.05, -0.17, 0.06, -0.07)
HEEL = HeelLine(0.012)


@dataclass(frozen=True)
class OnHeel(Task):
    """A walk whose stance foot turns about its heel from 70 % of the step."""

    @property
    def schedule(self):
        return Schedule((Phase(FlatFoot(), 0.7, PhaseEnd.SMOOTH), Phase(HEEL)))


@pytest.fixture(scope="module")
def walk(robot):
    problem = WalkProblem(robot, OnHeel(duration=0.5))
    return problem, perturbed(problem, first_guess(problem), 0.02, 3)


def test_a_positive_angle_lifts_the_toe_and_keeps_the_heel():
    place = pin.exp6(0.3 * HEEL.hinge(SOLE).twist)
    height = np.array([place.act(corner)[2] for corner in SOLE.corners])
    assert height[~HEEL.resting()] == pytest.approx(0.22 * np.sin(0.3))
    assert height[HEEL.resting()] == pytest.approx(0.0, abs=1e-15)


def test_the_ground_bears_a_strip_at_the_heel():
    assert HEEL.bearing(SOLE, 0.005).tolist() == pytest.approx([-0.158, -0.17, 0.055, -0.065])


def test_centre_of_pressure_is_asked_to_be_in_the_strip(walk, robot):
    problem, _ = walk
    (block,) = (b for b in problem.blocks if b.name == "cop")
    load, at = 300.0, robot.sole.heel + 0.005
    wrench = np.tile([0.0, 0.0, load, 0.0, -at * load, 0.0], (len(block.instants), 1))
    front, rear, *_ = block.function.value(wrench).T
    assert front[block.times > 0.7] == pytest.approx((0.012 - 0.005) * load)
    assert rear[block.times > 0.7] == pytest.approx(0.005 * load)
    assert front[block.times <= 0.7] == pytest.approx(
        (robot.sole.toe - problem.task.margins.cop_margin - at) * load
    )


def test_derivatives_are_exact(walk):
    problem, x = walk
    point, scale = problem.point(x), problem.variables.scale
    y = np.random.default_rng(2).normal(size=point.rows.size)

    def values(at):
        found = problem.values(at)
        return np.r_[found.cost, found.rows]

    def slope(at):
        found = problem.point(at)
        return found.gradient + found.jacobian.T @ y

    exact = np.vstack([point.gradient, point.jacobian]) * scale
    found = [jacobian_difference(values, x, scale, h) for h in steps(1e-5)]
    check_differences(exact, found)
    d = np.random.default_rng(3).normal(size=x.size) * scale
    H = problem.hessian(x, y, 1.0)
    moves = steps(4e-4, 4)
    found = [(slope(x + h * d) - slope(x - h * d)) * scale / (2.0 * h) for h in moves]
    check_differences(scale * (H @ d), found)


def test_the_referee_agrees(walk):
    problem, x = walk
    grid = on_fine_grid(problem).grid
    verdict = ask_referee(problem.robot, problem.with_grid(grid).step(x), grid, problem.schedule)
    assert 0.0 < verdict.worst < REFEREE
    assert 0.0 < verdict.momentum < MOMENTUM


def test_only_the_heel_has_to_leave_the_ground(walk):
    problem, _ = walk
    (block,) = (b for b in problem.blocks if b.name == "lift-off")
    assert [label for label in block.labels if "heel" in label] == list(block.labels)
    assert len(block.labels) == 2


def test_its_gait_is_kept_in_a_file(walk, tmp_path):
    gait = gait_at(*walk, {})
    again = load_gait(save_gait(gait, tmp_path / "gait.npz"))
    assert again.foot_contact == "heel line"
    assert again.step_length == pytest.approx(gait.step_length)
    times = np.linspace(0.0, 0.99, 20)
    assert (
        relative_error(again.trajectory.at(times).wrench, gait.trajectory.at(times).wrench) < 1e-9
    )
    with pytest.raises(
        GaitFileError, match="the contact 'ball line', which is not gaitopt's own; co"
    ):
        audit(replace(again, foot_contact="ball line"))
