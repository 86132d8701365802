import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numerics import relative_error
from urdf_edits import edited_urdf, joint

from gaitopt.model.leg_geometry import common_point
from gaitopt.model.robot import Robot

quick = settings(deadline=None, derandomize=True, max_examples=25)
vectors = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(np.array)


@quick
@given(vectors, st.integers(0, 1000))
def test_lines_through_a_point_meet_there(point, seed):
    axes = np.random.default_rng(seed).normal(size=(3, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    points = point + np.array([0.3, -0.7, 1.1])[:, None] * axes
    np.testing.assert_allclose(common_point(points, axes), point, atol=1e-7)


def test_skew_lines_meet_halfway():
    points, axes = np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 0.5]]), np.eye(3)[:2]
    np.testing.assert_allclose(common_point(points, axes), [0.0, 0.0, 0.35], atol=1e-12)


def test_parallel_lines_keep_the_mean_along_them():
    along, across = np.array([1.0, 2.0, 2.0]) / 3.0, np.array([2.0, -2.0, 1.0]) / 3.0
    points = np.array([0.4 * along + 0.1 * across, 1.0 * along + 0.3 * across])
    expected = 0.7 * along + 0.2 * across
    np.testing.assert_allclose(common_point(points, np.array([along, along])), expected, atol=1e-12)


def test_the_biped_is_measured_right(robot):
    legs = robot.legs
    np.testing.assert_allclose(legs.hips, [[0, -0.06, 0], [0, 0.06, 0]], atol=1e-12)
    np.testing.assert_allclose(legs.ankles, np.tile([-0.137, 0, 0.105], (2, 1)), atol=1e-12)
    assert [robot.joint_names[k] for k in legs.knees] == ["right_knee", "left_knee"]
    assert legs.reach == pytest.approx(0.6, abs=1e-12)
    np.testing.assert_array_equal(legs.flexion, [1.0, 1.0])


def lengths(robot: Robot, bend: float) -> np.ndarray:
    """Hip-ankle distances with both knees bent by an angle from straight."""
    model, data, legs = robot.model, robot.model.createData(), robot.legs
    q = pin.neutral(model)
    q[[7 + k for k in legs.knees]] = legs.straight + legs.flexion * bend
    pin.framesForwardKinematics(model, data, q)
    hips = [data.oMf[robot.pelvis_frame].act(h) for h in legs.hips]
    soles = data.oMf[model.getFrameId(robot.stance_sole)], data.oMf[robot.swing_frame]
    ankles = [s.act(a) for s, a in zip(soles, legs.ankles, strict=True)]
    return np.linalg.norm(np.array(hips) - ankles, axis=1)


@pytest.mark.parametrize("bend", [0.0, 0.5, 1.3])
def test_a_bent_knee_obeys_the_law_of_cosines(robot, bend):
    expected = 2.0 * 0.3 * np.cos(bend / 2.0)
    assert relative_error(lengths(robot, bend), np.full(2, expected)) < 1e-12


def test_a_knee_that_bends_with_negative_angles_from_a_bent_zero():
    """Turn the knees' axes over and start them bent: straightness and flexion follow."""
    bent = 0.2

    def edit(root):
        for side in ("left", "right"):
            knee = joint(root, f"{side}_knee")
            knee.find("axis").set("xyz", "0 -1 0")
            knee.find("origin").set("rpy", f"0 {bent} 0")
            knee.find("limit").attrib.update(lower="-2.4", upper="0.2")

    robot = Robot.from_urdf(edited_urdf(edit))
    np.testing.assert_array_equal(robot.legs.flexion, [-1.0, -1.0])
    np.testing.assert_allclose(robot.legs.straight, [bent, bent], atol=1e-12)
    assert robot.legs.reach == pytest.approx(0.6, abs=1e-12)
    assert relative_error(lengths(robot, 0.7), np.full(2, 0.6 * np.cos(0.35))) < 1e-12
