"""Oracles of walks that hold whatever their phases, shared by the tests of each kind."""

import numpy as np
import pinocchio as pin
from numerics import relative_error

from gaitopt.design.certificate import RefereeVerdict, ask_referee
from gaitopt.gait import quantities
from gaitopt.gait.grid import Grid, proof_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.step import Step
from gaitopt.tolerances import MOMENTUM, REFEREE

FORCE_MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""Signs of force and moment in a sole's frame as the plane between the legs mirrors them."""


def everywhere(problem: WalkProblem, x: np.ndarray, count: int = 5001) -> Step:
    """The step at equidistant instants, between the samples of the search too."""
    instants = np.linspace(0.0, 1.0, count)
    return problem.with_grid(Grid(instants, np.full(count, 1.0 / count), count)).step(x)


def check_base_moves_as_its_twist_says(trajectory, times: np.ndarray, h: float = 1e-5) -> None:
    """Differences of the base and the joints are the velocities, and of these the accelerations.

    Args:
        trajectory: of a gait.
        times: none of them at a knot [s].
        h: step of the differences [s].
    """
    model = trajectory.body.model
    before, at, after = (trajectory.at(times + move) for move in (-h, 0.0, h))
    for k in range(len(times)):
        v = pin.difference(model, before.configuration[k], after.configuration[k]) / (2.0 * h)
        a = (after.velocity[k] - before.velocity[k]) / (2.0 * h)
        assert relative_error(v, at.velocity[k]) < 1e-6
        assert relative_error(a, at.acceleration[k]) < 1e-5


def check_ground_holds(problem: WalkProblem, wrench: np.ndarray) -> None:
    """Unilateral, and in the friction cone."""
    load = wrench[:, 2]
    assert load.min() > 0.99
    used = (np.hypot(wrench[:, 0], wrench[:, 1]) / load).max()
    assert used < problem.task.margins.friction * (1.0 + 1e-5)


def check_pressure_is_inside(problem: WalkProblem, wrench: np.ndarray) -> None:
    """The centre of pressure keeps its margin to every edge of the sole."""
    sole, load = problem.robot.sole, wrench[:, 2]
    x, y = -wrench[:, 4] / load, wrench[:, 3] / load
    room = np.minimum.reduce([sole.toe - x, x - sole.heel, sole.left - y, y - sole.right])
    assert room.min() > problem.task.margins.cop_margin - 1e-4


def check_both_feet_hold(problem: WalkProblem, x: np.ndarray) -> Step:
    """Both feet keep their contacts and stand still at 5001 instants of a double support."""
    step = everywhere(problem, x)
    late = np.linspace(0.0, 1.0, 5001) > problem.schedule.changes[-1]
    for what, rows in ((quantities.WRENCH, slice(None)), (quantities.FRONT_WRENCH, late)):
        wrench = step.read(what)[rows]
        check_ground_holds(problem, wrench)
        check_pressure_is_inside(problem, wrench)
    assert np.ptp(step.support.corners[late], axis=0).max() < 1e-12
    return step


def refereed(problem: WalkProblem, step: Step) -> RefereeVerdict:
    """What the referee says of a step."""
    return ask_referee(problem.robot, step, problem.grid, problem.schedule)


def check_referee_agrees(problem: WalkProblem, x: np.ndarray) -> tuple[WalkProblem, Step]:
    """The referee agrees on a fine grid; returns the program there and the step, to be changed."""
    fine = problem.with_grid(proof_grid(problem.breaks))
    step = fine.step(x)
    verdict = refereed(fine, step)
    assert 0.0 < verdict.worst < REFEREE
    assert 0.0 < verdict.momentum < MOMENTUM
    return fine, step
