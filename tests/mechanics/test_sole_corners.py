import numpy as np
import pytest
from motions import bent_posture, kinematics
from numerics import check_derivative, check_jacobian, relative_error

from gaitopt.mechanics.forward_kinematics import (
    corner_hessian,
    corner_jacobian,
    corner_positions,
)
from gaitopt.model.sole import sole_edge_speeds, turning_arm


def placed(robot, q):
    """Joint axes (1, 12, 6) and corners (1, 4, 3) of the swing sole at q (12,)."""
    at = kinematics(robot, q)
    sole = at.frame(robot.swing_frame)
    corners = corner_positions(sole.rotation[None], sole.translation[None], robot.sole.corners)
    return at.axes[None], corners


def test_positions_are_those_of_a_rigid_body(robot, rng):
    sole = kinematics(robot, bent_posture(robot, rng)).frame(robot.swing_frame)
    corners = corner_positions(sole.rotation[None], sole.translation[None], robot.sole.corners)
    assert relative_error(corners[0], [sole.act(c) for c in robot.sole.corners]) < 1e-14


def test_slopes(robot, rng):
    q = bent_posture(robot, rng)
    check_jacobian(lambda x: placed(robot, x)[1], corner_jacobian(*placed(robot, q)), q, step=1e-3)


def test_curvature(robot, rng):
    q, weights = bent_posture(robot, rng), rng.normal(size=(1, 4, 3))
    axes, corners = placed(robot, q)
    H = corner_hessian(axes, corner_jacobian(axes, corners), weights)[0]

    def gradient(x):
        return np.einsum("nck,nckj->j", weights, corner_jacobian(*placed(robot, x)))

    check_jacobian(gradient, H, q, step=1e-3)
    np.testing.assert_allclose(H, H.T, atol=1e-14)


def test_edge_speeds_are_those_of_a_rigid_body(robot, rng):
    twist = rng.normal(size=6)
    corners = robot.sole.corners
    expected = (twist[:3] + np.cross(twist[3:], corners))[:, 2]
    assert relative_error(sole_edge_speeds(corners) @ twist, expected) < 1e-14


@pytest.mark.parametrize("seed", range(3))
def test_edge_speeds_are_the_rates_of_the_heights(robot, seed):
    """A sole that is flat now and moves with a twist lifts its corners at these speeds."""
    twist = np.random.default_rng(seed).normal(size=6)
    corners = robot.sole.corners

    def heights(t):
        import pinocchio as pin

        return [pin.exp6(pin.Motion(t[0] * twist)).act(c)[2] for c in corners]

    speeds = sole_edge_speeds(corners) @ twist
    check_derivative(heights, speeds, np.zeros(1), np.ones(1), step=1e-3)


def test_the_turning_arm_is_a_mean_distance():
    """Against Gauss's quadrature over a quarter of the rectangle, and a long thin one."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    share, weights = (nodes + 1.0) / 2.0, weights / 2.0
    apart = np.hypot(0.107 * share[:, None], 0.068 * share[None])
    assert turning_arm(0.214, 0.136) == pytest.approx(weights @ apart @ weights, rel=1e-5)
    assert turning_arm(0.214, 0.136) == turning_arm(0.136, 0.214)
    assert turning_arm(0.4, 1e-6) == pytest.approx(0.1, rel=1e-4)
