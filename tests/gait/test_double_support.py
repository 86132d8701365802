import numpy as np
import pinocchio as pin
import pytest
from motions import kinematics
from numerics import check_jacobian, relative_error

from gaitopt.errors import EvaluationError, UnreachableError
from gaitopt.gait.double_support import (
    PELVIS_CHAIN,
    SWING_SOLE_CHAIN,
    InverseKinematicsSupport,
    place,
)
from gaitopt.gait.parameters import FOOT_SPACING, GEOMETRY, PELVIS_HEIGHT, STEP_LENGTH

# Height, lateral, forward, trunk pitch, spacing, step, yaw, roll, foot yaw, duration.
POINTS = (
    np.array([0.63, 0.08, -0.31, 0.05, 0.16, 0.4, 0.0, 0.0, 0.0, 0.4]),
    np.array([0.58, 0.06, -0.27, -0.08, 0.19, 0.3, 0.11, -0.07, 0.12, 0.5]),
    np.array([0.55, 0.1, -0.4, 0.2, 0.13, 0.45, -0.09, 0.05, -0.1, 0.3]),
)
SIZES = np.array([q.scale for q in GEOMETRY])
NONE = np.zeros(0)  # the angles are no parameters here
at_points = pytest.mark.parametrize("g", POINTS)


@pytest.fixture(scope="module")
def boundary(robot):
    return InverseKinematicsSupport(robot)


@at_points
def test_pelvis_and_sole_are_where_the_quantities_put_them(robot, boundary, g):
    at = kinematics(robot, boundary.posture(g, NONE).q_start)
    pelvis, sole = place(PELVIS_CHAIN, g)[0], place(SWING_SOLE_CHAIN, g)[0]
    np.testing.assert_allclose(
        at.frame(robot.pelvis_frame).homogeneous, pelvis.homogeneous, atol=1e-11
    )
    np.testing.assert_allclose(
        at.frame(robot.swing_frame).homogeneous, sole.homogeneous, atol=1e-11
    )


@at_points
def test_legs_run_from_ankle_to_hip(robot, boundary, g):
    posture = boundary.posture(g, NONE)
    at, legs = kinematics(robot, posture.q_start), robot.legs
    hips = [at.frame(robot.pelvis_frame).act(h) for h in legs.hips]
    ankles = [legs.ankles[0], at.frame(robot.swing_frame).act(legs.ankles[1])]
    assert relative_error(posture.legs, np.array(hips) - ankles) < 1e-10


@at_points
def test_slope_of_the_posture(boundary, g):
    slope = boundary.derivatives(boundary.posture(g, NONE))
    check_jacobian(
        lambda p: boundary.posture(p, NONE).q_start, slope.q_start, g, scale=SIZES, step=1e-4
    )


@at_points
def test_slope_of_the_legs(boundary, g):
    slope = boundary.derivatives(boundary.posture(g, NONE))
    check_jacobian(lambda p: boundary.posture(p, NONE).legs, slope.legs, g, scale=SIZES, step=1e-2)


@at_points
@pytest.mark.parametrize("part", ["posture", "legs", "both"])
def test_curvature(boundary, g, part, rng):
    q_weights = rng.normal(size=12) * (part != "legs")
    leg_weights = rng.normal(size=(2, 3)) * (part != "posture")
    posture = boundary.posture(g, NONE)
    H = boundary.hessian(
        posture, boundary.derivatives(posture), q_weights, leg_weights, np.zeros((0, 6))
    )

    def gradient(p):
        slope = boundary.derivatives(boundary.posture(p, NONE))
        return (q_weights @ slope.q_start + np.einsum("lk,lkg->g", leg_weights, slope.legs)) * SIZES

    check_jacobian(gradient, SIZES[:, None] * H, g, scale=SIZES, step=3e-4)
    np.testing.assert_allclose(H, H.T, atol=1e-9 * np.abs(H).max())


def test_no_quantity_but_the_duration_is_idle(boundary):
    slope = boundary.derivatives(boundary.posture(POINTS[1], NONE)).q_start
    moves = np.abs(slope).max(axis=0)
    assert (moves[:9] > 0.1).all()
    assert moves[9] == 0.0


def test_joint_axes_are_those_of_the_posture(robot, boundary):
    posture = boundary.posture(POINTS[2], NONE)
    axes = kinematics(robot, posture.q_start).axes
    assert relative_error(boundary.derivatives(posture).joint_axes, axes) < 1e-13


def test_a_mirrored_double_support_is_the_next_one(robot, boundary):
    """E q_start stands with the other foot behind, mirrored: Fig. 2."""
    g = POINTS[1]
    at = kinematics(robot, robot.mirror @ boundary.posture(g, NONE).q_start)
    start = place(SWING_SOLE_CHAIN, g)[0].inverse()
    mirror = np.diag([1.0, -1.0, 1.0])
    expected = pin.SE3(mirror @ start.rotation @ mirror, mirror @ start.translation)
    np.testing.assert_allclose(
        at.frame(robot.swing_frame).homogeneous, expected.homogeneous, atol=1e-11
    )


def test_out_of_reach_tells_the_quantities(boundary):
    g = POINTS[0].copy()
    g[PELVIS_HEIGHT] = 0.72
    with pytest.raises(
        UnreachableError,
        match=r"leg is too short: .*pelvis height 0\.7200 m, pelvis -0\.3100 m forward of the "
        r"stance toes, step length 0\.4000 m, foot spacing 0\.1600 m",
    ):
        boundary.posture(g, NONE)


@pytest.mark.parametrize("row", [PELVIS_HEIGHT, FOOT_SPACING, STEP_LENGTH])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_no_number_is_refused(boundary, row, value):
    g = POINTS[0].copy()
    g[row] = value
    with pytest.raises(EvaluationError, match="a geometric quantity is not finite"):
        boundary.posture(g, NONE)
