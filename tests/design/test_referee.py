"""The referee agrees with Pinocchio, and disagrees when something is wrong."""

import warnings
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from walks import WALKS, walk

from gaitopt.design.certificate import ask_referee, on_fine_grid
from gaitopt.gait.grid import proof_grid
from gaitopt.model.robot import Robot
from gaitopt.tolerances import MOMENTUM, REFEREE

GRID = proof_grid(np.linspace(0.0, 1.0, 4))


def fine_step(name: str):
    """Robot, step and the proof's grid."""
    problem, x = walk(name).problem, walk(name).x
    grid = on_fine_grid(problem).grid
    return problem.robot, problem.with_grid(grid).step(x), grid, problem.schedule


@pytest.fixture(scope="module")
def judged():
    return fine_step("optimum 43")[:2]


@pytest.mark.parametrize("name", WALKS)
def test_it_agrees_with_every_step(name):
    assert 0.0 < ask_referee(*fine_step(name)).worst < REFEREE


@pytest.mark.parametrize("name", WALKS)
def test_momentum_is_balanced(name):
    assert 0.0 < ask_referee(*fine_step(name)).momentum < MOMENTUM


def test_the_ground_carries_the_weight(judged):
    robot, step = judged
    verdict = ask_referee(robot, step, GRID)
    assert verdict.weight == pytest.approx(56.87 * 9.81 * step.duration)
    assert verdict.vertical == pytest.approx(verdict.weight, rel=1e-9)


def heavier(robot: Robot, joint: int) -> Robot:
    """The robot with two percent more mass beyond one of its joints."""
    model = robot.model.copy()
    body = model.inertias[joint]
    model.inertias[joint] = pin.Inertia(1.02 * body.mass, body.lever, body.inertia)
    return replace(robot, model=model)


@pytest.mark.parametrize("joint", [2, 7, 13])
def test_a_changed_mass_is_found(judged, joint):
    """A body that is 2 % heavier than the one the step was evaluated with."""
    robot, step = judged
    verdict = ask_referee(heavier(robot, joint), step, GRID)
    assert verdict.wrench > 1e-5
    assert verdict.impulse > 1e-6
    assert verdict.worst > REFEREE


def test_changed_gravity_is_found(judged):
    robot, step = judged
    model = robot.model.copy()
    model.gravity.linear = np.array([0.0, 0.0, -9.80665])
    verdict = ask_referee(replace(robot, model=model), step, GRID)
    assert verdict.torque > REFEREE
    assert verdict.impulse < REFEREE  # the impact knows no weight


def test_changed_loads_are_found(judged):
    robot, step = judged
    effort = step.support.effort.copy()
    effort[20, 9] += 1e-3
    wrong = replace(step, support=replace(step.support, effort=effort))
    verdict = ask_referee(robot, wrong, GRID)
    assert verdict.torque > REFEREE > verdict.wrench


def test_a_changed_impact_is_found(judged):
    robot, step = judged
    wrong = replace(step, impact=replace(step.impact, impulse=1.001 * step.impact.impulse))
    verdict = ask_referee(robot, wrong, GRID)
    assert verdict.impulse == pytest.approx(1e-3, rel=1e-3)
    velocity = step.impact.velocity + 1e-5
    verdict = ask_referee(
        robot, replace(step, impact=replace(step.impact, velocity=velocity)), GRID
    )
    assert min(verdict.rate_after, verdict.sole_twist) > REFEREE


def test_a_step_that_is_not_periodic_is_found(judged):
    robot, step = judged
    motion = step.motion.copy()
    motion[0, 0, 4] += 1e-4
    verdict = ask_referee(robot, replace(step, motion=motion), GRID)
    assert verdict.posture == pytest.approx(1e-4, rel=1e-6)
    motion = step.motion.copy()
    motion[1, 0, 4] += 1e-3
    assert ask_referee(robot, replace(step, motion=motion), GRID).rate > 1e-5


def test_momentum_that_comes_from_nowhere_is_found(judged):
    robot, step = judged
    motion = step.motion.copy()
    motion[2] *= 1.01  # accelerations that do not belong to the rates
    assert ask_referee(robot, replace(step, motion=motion), GRID).momentum > MOMENTUM


def test_worst_is_the_largest_but_for_the_momentum(judged):
    verdict = replace(ask_referee(*judged, GRID), momentum=1.0, sole_twist=0.02)
    assert verdict.worst == 0.02


def test_a_zero_impulse_is_no_disagreement(judged):
    """A foot that is set down at rest: no rates, no impulse, nothing to divide by."""
    robot, step = judged
    model = walk("optimum 43").problem.model
    rest = np.zeros(12)
    still = replace(step, rate_before=rest, impact=model.impact.state(step.q_end, rest))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        verdict = ask_referee(robot, still, GRID)
    assert verdict.impulse < REFEREE
    assert verdict.rate_after < REFEREE
    wrong = replace(still, impact=replace(still.impact, impulse=np.full(6, 1e-3)))
    assert ask_referee(robot, wrong, GRID).impulse > REFEREE
