import numpy as np
import pytest
from numerics import relative_error
from scipy.integrate import simpson
from walks import WALKS, walk

from gaitopt.gait import quantities
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem


def at(name: str):
    problem, x = walk(name).problem, walk(name).x
    return problem, problem.step(x)


@pytest.mark.parametrize("name", ["guess", "optimum 43", "one posture"])
def test_it_is_the_integral_of_squared_torques_per_metre(name):
    problem, step = at(name)
    squares = (step.read(quantities.TORQUE) ** 2).sum(axis=1)
    expected = simpson(squares, dx=step.duration / 30.0) / step.step_length
    assert relative_error(problem.cost.value(step), expected) < 1e-13


def test_the_sum_of_the_paper():
    problem, step = at("everything free, penalty, Euler")
    squares = (step.read(quantities.TORQUE) ** 2).sum(axis=1)
    effort = squares[:-1].sum() * step.duration / 19.0 / step.step_length
    gap = problem.task.speed * step.duration - step.step_length
    assert relative_error(problem.cost.value(step), effort + 1e6 * gap**2) < 1e-13


def test_the_penalty_weighs_the_squared_gap_of_the_speed(robot):
    """Eq. (47): rho (V T - d)² on top of Eq. (46)."""
    problem, x = walk("guess").problem, walk("guess").x.copy()
    x[problem.layout.index("step_length")] = 0.38
    plain = problem.values(x).cost
    task = preset_task(speed_as="penalty", penalty_weight=2e4)
    penalised = WalkProblem(robot, task).values(x).cost
    assert penalised - plain == pytest.approx(2e4 * 0.02**2, rel=1e-9)


def test_added_instants_do_not_count():
    problem, step = at("added instants")
    plain = WalkProblem(problem.robot, problem.task)
    assert relative_error(problem.cost.value(step), plain.values(step.x).cost) < 1e-13


@pytest.mark.parametrize("name", WALKS)
def test_slope_is_that_of_the_formula(name):
    """Differences in the torques and in (d, T) themselves, not in the parameters."""
    problem, step = at(name)
    gradient = problem.cost.gradient(step)
    torque, (d, T) = step.read(quantities.TORQUE), step.read(quantities.TRAVEL)[0]
    weights, task = problem.grid.weights, problem.task
    penalty = task.penalty_weight if task.speed_as == "penalty" else 0.0

    def value(torques, d, T):
        gap, path = task.speed * T - d, abs(d) if task.speed else T
        return T / path * (weights @ (torques**2).sum(axis=1)) + penalty * gap**2

    assert relative_error(value(torque, d, T), problem.cost.value(step)) < 1e-13
    h = 1e-5
    by_d = (value(torque, d + h, T) - value(torque, d - h, T)) / (2.0 * h)
    by_T = (value(torque, d, T + h) - value(torque, d, T - h)) / (2.0 * h)
    of_travel = gradient.get(quantities.TRAVEL, np.zeros((1, 2)))  # in place there is none
    np.testing.assert_allclose(of_travel, [[by_d, by_T]], rtol=1e-6)
    move = np.random.default_rng(0).normal(size=torque.shape)
    along = (value(torque + h * move, d, T) - value(torque - h * move, d, T)) / (2.0 * h)
    assert np.sum(gradient[quantities.TORQUE] * move) == pytest.approx(along, rel=1e-6)


def test_more_samples_change_the_cost_little(robot):
    problem, x = walk("optimum 43").problem, walk("optimum 43").x
    fine = WalkProblem(robot, problem.task, uniform_grid(301)).values(x).cost
    assert relative_error(problem.values(x).cost, fine) < 2e-3
