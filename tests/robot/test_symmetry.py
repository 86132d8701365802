import numpy as np
import pinocchio as pin
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_cases import URDF_SIGNS, biped

from gaitopt.model.symmetry import (
    exchange_error,
    joint_lines,
    leg_exchange,
    mirror_placement,
)

angles = st.lists(st.floats(-1.2, 1.2), min_size=12, max_size=12).map(np.array)
quick = settings(deadline=None, derandomize=True, max_examples=25)
OUTWARD = np.repeat([-1.0, 1.0], 6)


def placements(q: np.ndarray) -> tuple[pin.SE3, pin.SE3]:
    robot = biped()
    model, data = robot.model, robot.model.createData()
    full = pin.neutral(model)
    full[7:] = q
    pin.framesForwardKinematics(model, data, full)
    return data.oMf[robot.pelvis_frame].copy(), data.oMf[robot.swing_frame].copy()


def test_exchanging_twice_changes_nothing(robot):
    np.testing.assert_array_equal(robot.mirror @ robot.mirror, np.eye(12))


def test_it_is_the_exchange_of_the_paper(robot):
    # In the chain's signs: joint j takes joint 13 - j, + for roll and yaw, - for pitch.
    pitch = ["pitch" in n or "knee" in n for n in robot.joint_names]
    chain = np.fliplr(np.diag(np.where(pitch, -1.0, 1.0)))
    np.testing.assert_array_equal(robot.mirror, URDF_SIGNS[:, None] * chain * URDF_SIGNS)


@quick
@given(angles)
def test_the_pelvis_seen_from_the_feet_is_mirrored(q):
    robot = biped()
    pelvis, sole = placements(q)
    other_pelvis, other_sole = placements(robot.mirror @ q)
    # What the swing sole sees at q is the mirror image of what the stance sole sees at E q.
    np.testing.assert_allclose(
        mirror_placement(sole.actInv(pelvis)).homogeneous, other_pelvis.homogeneous, atol=1e-12
    )
    np.testing.assert_allclose(
        mirror_placement(sole.inverse()).homogeneous, other_sole.homogeneous, atol=1e-12
    )


def test_mirroring_a_placement_flips_left_and_right():
    placement = pin.SE3(pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), np.array([1.0, 2.0, 3.0]))
    expected = pin.SE3(pin.rpy.rpyToMatrix(-0.1, 0.2, -0.3), np.array([1.0, -2.0, 3.0]))
    np.testing.assert_allclose(
        mirror_placement(placement).homogeneous, expected.homogeneous, atol=1e-14
    )


def test_error_of_a_wrong_exchange_is_seen(robot):
    soles = robot.stance_sole, robot.swing_sole
    assert exchange_error(robot.model, robot.mirror, *soles) < 1e-12
    wrong = robot.mirror.copy()
    wrong[2] *= -1.0
    wrong[:, 2] *= -1.0
    assert exchange_error(robot.model, wrong, *soles) > 0.01


def lines(robot) -> tuple[np.ndarray, np.ndarray]:
    return joint_lines(robot.model, placements(np.zeros(12))[0])


def test_joint_lines_are_those_of_the_legs(robot):
    points, axes = lines(robot)
    knee = robot.joint_names.index("left_knee")
    np.testing.assert_allclose(points[knee], [0.0, 0.06, -0.3], atol=1e-12)
    np.testing.assert_allclose(np.abs(axes[knee]), [0.0, 1.0, 0.0], atol=1e-12)
    yaw = robot.joint_names.index("right_hip_yaw")
    np.testing.assert_allclose(points[yaw][:2], [0.0, -0.06], atol=1e-12)
    np.testing.assert_allclose(np.abs(axes[yaw]), [0.0, 0.0, 1.0], atol=1e-12)


def test_a_joint_that_turns_the_other_way_changes_two_signs(robot):
    axes = lines(robot)[1]
    flipped = axes.copy()
    knee = robot.joint_names.index("left_knee")
    flipped[knee] *= -1.0
    E = leg_exchange(flipped, OUTWARD)
    partner = robot.joint_names.index("right_knee")
    assert E[knee, partner] == E[partner, knee] == -robot.mirror[knee, partner]
    E[knee, partner] = E[partner, knee] = robot.mirror[knee, partner]
    np.testing.assert_array_equal(E, robot.mirror)
