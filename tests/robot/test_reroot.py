"""The re-rooted model against the pelvis-rooted one that Pinocchio reads from the URDF."""

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from pelvis_rooted import PelvisRooted
from urdf_edits import add_arm, edited_urdf

from gaitopt.model.joint_tree import lock_upper_body, reroot
from gaitopt.model.robot import Robot
from gaitopt.model.symmetry import mirror_placement

TOLERANCE = 1e-10
SEEDS = range(5)


def pelvis_rooted(robot: Robot, seed: int) -> PelvisRooted:
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    reduced = lock_upper_body(whole, robot.stance_sole, robot.swing_sole)
    return PelvisRooted(reduced, robot.stance_sole, robot.joint_names, seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_torques_and_ground_wrench_agree(robot, seed):
    other = pelvis_rooted(robot, seed)
    effort = pin.rnea(robot.model, robot.model.createData(), *other.state(robot.model))
    expected = other.effort()
    assert relative_error(effort[:3], expected[:3]) < TOLERANCE
    assert relative_error(effort[3:6], expected[3:6]) < TOLERANCE
    assert relative_error(effort[6:], expected[6:]) < TOLERANCE


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrices_agree(robot, seed):
    other = pelvis_rooted(robot, seed)
    q = other.state(robot.model)[0]
    D = pin.crba(robot.model, robot.model.createData(), q)
    assert relative_error(D, other.mass_matrix()) < TOLERANCE


@pytest.mark.parametrize("seed", SEEDS)
def test_every_frame_is_where_it_was(robot, seed):
    other = pelvis_rooted(robot, seed)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, other.state(robot.model)[0])
    pin.framesForwardKinematics(other.model, other.data, other.q)
    names = [f.name for f in other.model.frames if f.type == pin.FrameType.BODY]
    assert len(names) >= 13
    for name in names:
        here = data.oMf[robot.model.getFrameId(name)]
        there = other.data.oMf[other.model.getFrameId(name)]
        assert relative_error(here.homogeneous, there.homogeneous) < TOLERANCE


def test_the_sole_stays_at_rest_in_the_oracle(robot):
    other = pelvis_rooted(robot, 0)
    assert np.abs(other.jacobian() @ other.v).max() < 1e-12
    assert np.abs(other.v[:6]).max() > 0.1


def test_a_locked_arm_hangs_where_it_was():
    robot = Robot.from_urdf(edited_urdf(add_arm))
    other = pelvis_rooted(robot, 3)
    effort = pin.rnea(robot.model, robot.model.createData(), *other.state(robot.model))
    assert relative_error(effort, other.effort()) < TOLERANCE


def test_armature_moves_with_its_joint(robot):
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    reduced = lock_upper_body(whole, robot.stance_sole, robot.swing_sole)
    armature = np.arange(18) / 100.0
    reduced.armature = armature
    model = reroot(reduced, robot.stance_sole, robot.swing_sole)
    for name in robot.joint_names:
        before = armature[reduced.joints[reduced.getJointId(name)].idx_v]
        assert model.armature[model.joints[model.getJointId(name)].idx_v] == before > 0.0


def test_gravity_is_kept(robot):
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    reduced = lock_upper_body(whole, robot.stance_sole, robot.swing_sole)
    reduced.gravity.linear = np.array([0.3, -0.2, -1.62])  # a slope on the moon
    model = reroot(reduced, robot.stance_sole, robot.swing_sole)
    np.testing.assert_array_equal(model.gravity.linear, [0.3, -0.2, -1.62])


def test_the_given_model_is_not_changed(robot):
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    before = whole.copy()
    lock_upper_body(whole, robot.stance_sole, robot.swing_sole)
    assert whole == before


def test_stance_on_either_foot_is_the_mirror_image(robot):
    left = Robot.from_urdf(robot.urdf, stance_sole="left_sole", swing_sole="right_sole")
    angles = np.random.default_rng(1).uniform(-0.5, 0.5, 12)
    mirrored = robot.mirror @ angles  # by joint names of the right-stance order
    by_name = dict(zip(robot.joint_names, mirrored, strict=True))
    here, there = pin.neutral(robot.model), pin.neutral(left.model)
    here[7:], there[7:] = angles, [by_name[n] for n in left.joint_names]
    data, other = robot.model.createData(), left.model.createData()
    pin.framesForwardKinematics(robot.model, data, here)
    pin.framesForwardKinematics(left.model, other, there)
    np.testing.assert_allclose(
        mirror_placement(data.oMf[robot.swing_frame]).homogeneous,
        other.oMf[left.swing_frame].homogeneous,
        atol=1e-12,
    )
