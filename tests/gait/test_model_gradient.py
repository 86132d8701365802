"""Derivatives in the robot itself, against differences of walks of changed robots."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from changed_robots import changed
from numerics import check_derivative
from walks import walk

from gaitopt.gait.model_gradient import ModelGradient, model_gradient
from gaitopt.gait.parameters import set_geometry
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import Robot

WALKS = (
    "optimum 43",
    "everything free, penalty, Euler",
    "upright, uphill",
    "upright, downstairs",
    "lifted, everything free",
    "upright, toe off, everything free",
    "upright, lifted, toe off, seven joints, waist, arms",
    "upright, heel strike, toe off, everything free",
    "upright, lifted, heel strike, five joints, soft",
    "upright, lifted, five joints",
    "upright, heel strike, toe off, everything free",
    "upright, lifted, heel strike, five joints, soft",
    "upright, lifted, joints that follow others",
    "upright, lifted, heel strike, toe off, NAO's hips",
    "upright, lifted, heel strike, toe off, joints that follow by bends",
)
LENGTHS = ("joints", "swing_sole", "pelvis", "hips", "ankles")
MASSES = ("mass", "first", "second")
OTHERS = ("armature", "gravity")


@dataclass
class Case:
    """A weighted sum of rows and cost, as a function of the robot."""

    problem: WalkProblem
    x: np.ndarray
    multipliers: np.ndarray
    gradient: ModelGradient

    def value(self, robot: Robot) -> float:
        """0.3 cost + multipliers . rows of the same parameters with another robot."""
        step = WalkProblem(robot, self.problem.task, self.problem.grid).step(self.x)
        total = 0.3 * self.problem.cost.value(step)
        for block in self.problem.blocks:  # with the limits of the robot as it was
            y = self.multipliers[self.problem.rows_of(block.name)].reshape(block.lower.shape)
            total += float(np.sum(y / block.scale * block.function.value(block.take(step.values))))
        return total


@pytest.fixture(scope="module", params=WALKS)
def case(request):
    at = walk(request.param)
    problem, x = at.problem, at.x
    y = np.random.default_rng(1).normal(size=problem.rows.lower.size)
    for block in problem.blocks:
        if block.name in ("leg gap", "arm gap"):  # capsules do not follow lengths
            y[problem.rows_of(block.name)] = 0.0
    step, derivatives = problem.derivatives(x)
    first = problem.weights(x, y, 0.3)
    return Case(problem, x, y, model_gradient(problem.model, step, derivatives, first))


def direction(gradient: ModelGradient, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """A random change of some parts of the robot."""
    random = np.random.default_rng(2)
    sizes = {"mass": 0.05, "first": 0.01, "second": 1e-3, "gravity": 1.0}
    moved = {}
    for name in names:
        values = random.normal(size=np.shape(getattr(gradient, name))) * sizes.get(name, 0.01)
        moved[name] = values + values.swapaxes(1, 2) if name == "second" else values
    return moved


@pytest.mark.parametrize("names", [LENGTHS, MASSES, OTHERS], ids=["lengths", "masses", "others"])
def test_derivatives_are_those_of_changed_robots(case, names):
    moved = direction(case.gradient, names)
    exact = sum(float(np.vdot(getattr(case.gradient, name), moved[name])) for name in names)
    robot = case.problem.robot
    check_derivative(
        lambda amount: case.value(changed(robot, moved, float(amount[0]))),
        exact, np.zeros(1), np.ones(1), step=1e-3, tolerance=1e-5,
    )  # fmt: skip


def test_each_joint_and_body_by_itself(case):
    """No two errors that cancel: one joint and one body of either leg, alone."""
    # One body changes the value little: smaller steps of its inertia drown in rounding.
    for part, apart in (("joints", 3e-3), ("second", 4e-2)):
        for row in (1, case.problem.robot.tree.stance + 1):
            moved = direction(case.gradient, LENGTHS if part == "joints" else MASSES)
            for name, values in moved.items():
                kept = values[row].copy() if name == part else 0.0
                values[...] = 0.0
                if name == part:
                    values[row] = kept
            exact = float(np.vdot(getattr(case.gradient, part), moved[part]))
            robot = case.problem.robot

            def value(amount, moved=moved, robot=robot):
                return case.value(changed(robot, moved, float(amount[0])))

            check_derivative(
                value, exact, np.zeros(1), np.ones(1), step=apart, tolerance=1e-5
            )  # fmt: skip


def test_the_duration(case):
    problem, x = case.problem, case.x
    if problem.layout.index("duration") is None:
        if problem.task.stairs:
            return  # treads are as long as steps: the duration stays
        table = set_geometry(problem.task.geometry, {"duration": {"free": True}})
        problem = WalkProblem(problem.robot, replace(problem.task, geometry=table), problem.grid)
        x = np.insert(x, problem.layout.index("duration"), problem.task.duration)
    point = problem.point(x)
    exact = 0.3 * point.gradient + point.jacobian.T @ case.multipliers
    column = problem.layout.index("duration")
    assert case.gradient.duration == pytest.approx(exact[column], rel=1e-9)
