"""Closed-form second derivatives against differences of the exact first ones."""

import numpy as np
import pinocchio as pin
import pytest
from motions import bent_posture, kinematics, random_motion
from numerics import check_jacobian, relative_error

from gaitopt.mechanics.inverse_dynamics_hessian import (
    moved_axes,
    velocity_hessian,
    velocity_rate_hessian,
)
from gaitopt.mechanics.single_support import SingleSupport

COUNT = 2
CASES = ("torques", "wrench", "both")


@pytest.fixture
def motion(robot, rng):
    return random_motion(robot, rng, COUNT)


@pytest.fixture(params=CASES)
def weights(request, rng):
    w = rng.normal(size=(COUNT, 18))
    w[:, :6] *= request.param != "torques"
    w[:, 6:] *= request.param != "wrench"
    return w


@pytest.fixture
def gradient(robot, motion, weights):
    """Gradient of the weighted effort in (q, dq, ddq), as a function of one block's change."""
    support = SingleSupport(robot, COUNT)

    def at(block: int):
        def value(change):
            parts = list(motion)
            parts[block] = motion[block] + change
            slope = support.derivatives(*parts)[1].effort
            return (weights[:, None] @ slope)[:, 0]  # (COUNT, 36)

        return value

    return at


@pytest.fixture
def blocks(robot, motion, weights):
    return SingleSupport(robot, COUNT).derivatives(*motion)[1].hessian(weights)


def test_blocks_with_the_angles(gradient, blocks):
    H = np.concatenate([blocks.qq, blocks.qv.swapaxes(1, 2), blocks.qa.swapaxes(1, 2)], axis=1)
    check_jacobian(gradient(0), H, np.zeros(12), step=1e-4)


def test_blocks_with_the_rates(gradient, blocks):
    def of_angles_and_rates(change):
        return gradient(1)(change)[:, :24]

    H = np.concatenate([blocks.qv, blocks.vv], axis=1)
    check_jacobian(of_angles_and_rates, H, np.zeros(12), step=1e-3)


def test_block_with_the_accelerations(gradient, blocks):
    check_jacobian(lambda c: gradient(2)(c)[:, :12], blocks.qa, np.zeros(12), step=1e-2)


def test_no_other_block_with_the_accelerations(gradient):
    change = gradient(2)(np.ones(12)) - gradient(2)(np.zeros(12))
    assert np.abs(change[:, :12]).max() > 1e-3
    assert np.abs(change[:, 12:]).max() < 1e-12 * np.abs(gradient(2)(np.zeros(12))).max()


def test_base_block_is_the_slope_in_the_base_acceleration(robot, motion, weights, blocks):
    """The base's acceleration enters as the first six columns of the inertia matrix."""
    model, data = robot.model, robot.model.createData()

    def gradient(q):
        """d(weights . effort) / d a_0 at the first instant."""
        full = pin.neutral(model)
        full[7:] = q
        return pin.crba(model, data, full)[:, :6].T @ weights[0]

    check_jacobian(gradient, blocks.base[0].T, motion[0][0], step=1e-3)


def test_blocks_are_those_of_one_matrix(blocks, rng):
    motion, none = rng.normal(size=(COUNT, 36, 5)), np.zeros((12, 12))
    each = zip(blocks.qq, blocks.qv, blocks.vv, blocks.qa, strict=True)
    H = np.array([
        np.block([[qq, qv, qa], [qv.T, vv, none], [qa.T, none, none]]) for qq, qv, vv, qa in each
    ])  # fmt: skip
    expected = sum(M.T @ at @ M for M, at in zip(motion, H, strict=True))
    assert relative_error(blocks.through(motion), expected) < 1e-13
    along = blocks.along(motion[:, :, 0].reshape(COUNT, 3, 12)).reshape(COUNT, 36, 1)
    assert relative_error(along, H @ motion[:, :, :1]) < 1e-13


def own_frame_velocity(robot, q, velocity, force_in_body):
    at = kinematics(robot, q, velocity)
    twist = pin.getFrameVelocity(robot.model, at.data, robot.swing_frame, pin.LOCAL).vector
    return float(force_in_body @ twist)


@pytest.fixture
def swinging(robot, rng):
    """Posture, velocity with a moving base, force fixed in the swing sole, and both in the world"""
    q, velocity, force = bent_posture(robot, rng), rng.normal(size=18), rng.normal(size=6)
    at = kinematics(robot, q)
    world = at.frame(robot.swing_frame).act(pin.Force(force)).vector
    return q, velocity, force, at.axes, world


def gradient_in_posture(robot, q, velocity, force):
    model, data = robot.model, robot.model.createData()
    full = pin.neutral(model)
    full[7:] = q
    pin.computeForwardKinematicsDerivatives(model, data, full, velocity, np.zeros(18))
    dv_dq, _ = pin.getFrameVelocityDerivatives(model, data, robot.swing_frame, pin.LOCAL)
    return force @ dv_dq[:, 6:]


def test_velocity_curvature(robot, swinging):
    q, velocity, force, axes, world = swinging
    H = velocity_hessian(axes, moved_axes(axes, velocity[6:], velocity[:6]), world)
    check_jacobian(lambda x: gradient_in_posture(robot, x, velocity, force), H, q, step=1e-3)


def test_velocity_rate_slope(robot, swinging):
    q, velocity, force, axes, world = swinging
    rates, base = velocity_rate_hessian(axes, world)

    def gradient(v):
        return gradient_in_posture(robot, q, v, force)

    check_jacobian(gradient, np.hstack([base, rates]), velocity, step=1e-2)


def test_the_slope_that_is_differentiated_is_right(robot, swinging):
    q, velocity, force, _, _ = swinging
    gradient = gradient_in_posture(robot, q, velocity, force)
    check_jacobian(lambda x: own_frame_velocity(robot, x, velocity, force), gradient, q, step=1e-3)
