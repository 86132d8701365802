"""The re-rooted model against the pelvis-rooted one that Pinocchio reads from the URDF."""

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from urdf_edits import add_arm, edited_urdf

from gaitopt.robot.model import Robot
from gaitopt.robot.reroot import lock_upper_body, reroot
from gaitopt.robot.symmetry import mirror_placement

TOLERANCE = 1e-10
SEEDS = range(5)


class PelvisRooted:
    """The robot as the URDF has it, in the state of the re-rooted one."""

    def __init__(self, robot: Robot, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.angles = rng.uniform(-0.8, 0.8, 12)
        self.rates, self.accelerations = rng.normal(0.0, 3.0, 12), rng.normal(0.0, 30.0, 12)
        whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
        self.model = lock_upper_body(whole, robot.stance_sole, robot.swing_sole)
        self.data = self.model.createData()
        self.columns = [
            self.model.joints[self.model.getJointId(n)].idx_v for n in robot.joint_names
        ]
        self.sole = self.model.getFrameId(robot.stance_sole)
        self.q = pin.neutral(self.model)
        self.q[[c + 1 for c in self.columns]] = self.angles
        self._stand_on_the_sole()
        self.v, self.a = np.zeros(18), np.zeros(18)
        self.v[self.columns], self.a[self.columns] = self.rates, self.accelerations
        self._hold_the_sole()

    def _stand_on_the_sole(self) -> None:
        pin.framesForwardKinematics(self.model, self.data, self.q)
        self.q[:7] = pin.SE3ToXYZQUAT(self.data.oMf[self.sole].inverse())

    def jacobian(self) -> np.ndarray:
        pin.computeJointJacobians(self.model, self.data, self.q)
        pin.updateFramePlacements(self.model, self.data)
        return pin.getFrameJacobian(self.model, self.data, self.sole, pin.LOCAL).copy()

    def _hold_the_sole(self) -> None:
        """Base twist and acceleration that keep the stance sole at rest."""
        J = self.jacobian()
        self.v[:6] = -np.linalg.solve(J[:, :6], J[:, 6:] @ self.v[6:])
        pin.forwardKinematics(self.model, self.data, self.q, self.v, self.a)
        drift = pin.getFrameAcceleration(self.model, self.data, self.sole, pin.LOCAL).vector
        self.a[:6] = -np.linalg.solve(J[:, :6], drift)

    def effort(self) -> np.ndarray:
        """Ground wrench in the sole frame, then torques: the base carries nothing itself."""
        tau = pin.rnea(self.model, self.data, self.q, self.v, self.a)
        J = self.jacobian()
        wrench = np.linalg.solve(J[:, :6].T, tau[:6])
        return np.concatenate([wrench, (tau - J.T @ wrench)[self.columns]])


def rerooted_state(robot: Robot, other: PelvisRooted) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q = pin.neutral(robot.model)
    q[7:] = other.angles
    zero = np.zeros(6)
    return q, np.r_[zero, other.rates], np.r_[zero, other.accelerations]


@pytest.mark.parametrize("seed", SEEDS)
def test_torques_and_ground_wrench_agree(robot, seed):
    other = PelvisRooted(robot, seed)
    effort = pin.rnea(robot.model, robot.model.createData(), *rerooted_state(robot, other))
    expected = other.effort()
    assert relative_error(effort[:3], expected[:3]) < TOLERANCE
    assert relative_error(effort[3:6], expected[3:6]) < TOLERANCE
    assert relative_error(effort[6:], expected[6:]) < TOLERANCE


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrices_agree(robot, seed):
    other = PelvisRooted(robot, seed)
    M = pin.crba(other.model, other.data, other.q).copy()
    J = other.jacobian()
    # Pelvis-rooted velocity from (sole twist, joint rates): the sole twist is J v.
    order = np.array(other.columns)
    to_base = np.linalg.inv(J[:, :6])
    V = np.zeros((18, 18))
    V[:6, :6], V[:6, 6:] = to_base, -to_base @ J[:, order]
    V[order, range(6, 18)] = 1.0
    q = rerooted_state(robot, other)[0]
    D = pin.crba(robot.model, robot.model.createData(), q)
    assert relative_error(D, V.T @ M @ V) < TOLERANCE


@pytest.mark.parametrize("seed", SEEDS)
def test_every_frame_is_where_it_was(robot, seed):
    other = PelvisRooted(robot, seed)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, rerooted_state(robot, other)[0])
    pin.framesForwardKinematics(other.model, other.data, other.q)
    names = [f.name for f in other.model.frames if f.type == pin.FrameType.BODY]
    assert len(names) >= 13
    for name in names:
        here = data.oMf[robot.model.getFrameId(name)]
        there = other.data.oMf[other.model.getFrameId(name)]
        assert relative_error(here.homogeneous, there.homogeneous) < TOLERANCE


def test_the_sole_stays_at_rest_in_the_oracle(robot):
    other = PelvisRooted(robot, 0)
    assert np.abs(other.jacobian() @ other.v).max() < 1e-12
    assert np.abs(other.v[:6]).max() > 0.1


def test_a_locked_arm_hangs_where_it_was():
    robot = Robot.from_urdf(edited_urdf(add_arm))
    other = PelvisRooted(robot, 3)
    effort = pin.rnea(robot.model, robot.model.createData(), *rerooted_state(robot, other))
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
