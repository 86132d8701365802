import numpy as np
import pinocchio as pin
import pytest
from motions import bent_posture, kinematics
from numerics import check_jacobian, relative_error
from reference_cases import biped

from gaitopt.mechanics.forward_kinematics import ForwardKinematics, Trunk

COUNT = 3


@pytest.fixture
def postures(robot, rng):
    return np.array([bent_posture(robot, rng) for _ in range(COUNT)])


def angles(robot, q):
    return Trunk(robot).value(ForwardKinematics(robot.model).placed(q))


def derivatives(robot, q):
    axes = np.stack([kinematics(robot, angles).axes for angles in q])
    return Trunk(robot).derivatives(ForwardKinematics(robot.model).placed(q), axes)


def test_yaw_pitch_and_roll_one_after_the_other_turn_the_pelvis(robot, postures):
    for q, (roll, pitch, yaw) in zip(postures, angles(robot, postures), strict=True):
        turned = [
            pin.utils.rotate(axis, a) for axis, a in zip("zyx", (yaw, pitch, roll), strict=True)
        ]
        expected = kinematics(robot, q).frame(robot.pelvis_frame).rotation
        assert relative_error(turned[0] @ turned[1] @ turned[2], expected) < 1e-14


def test_slope(robot, postures):
    """Every instant moves by the same twelve amounts: instants do not see each other."""
    exact = derivatives(robot, postures).jacobian
    assert np.abs(exact[:, :, 6:]).max() == 0.0  # the swing leg does not turn the trunk
    check_jacobian(lambda d: angles(robot, postures + d), exact, np.zeros(12), step=1e-3)


def test_curvature(robot, postures, rng):
    weights = rng.normal(size=(COUNT, 3))
    H = derivatives(robot, postures).hessian(weights)

    def gradient(d):
        return np.einsum("na,naj->nj", weights, derivatives(robot, postures + d).jacobian)

    check_jacobian(gradient, H, np.zeros(12), step=1e-3)
    np.testing.assert_allclose(H, H.swapaxes(1, 2), atol=1e-15)


def test_in_the_mirror_roll_and_yaw_change_sign(robot, postures):
    left = biped("left")
    order = [robot.joint_names.index(n) for n in left.joint_names]
    mirrored = postures @ robot.mirror[order].T
    expected = angles(robot, postures) * (-1.0, 1.0, -1.0)
    assert relative_error(angles(left, mirrored), expected) < 1e-12


def test_a_trunk_that_lies_down_has_a_slope(robot):
    """Where roll and yaw are one and the same, nothing is divided by zero."""
    q = np.zeros((1, 12))
    q[0, robot.joint_names.index("right_hip_pitch")] = -np.pi / 2.0
    assert np.isfinite(derivatives(robot, q).jacobian).all()
    assert abs(angles(robot, q)[0, 1]) == pytest.approx(np.pi / 2.0)
