"""The arrays of a robot against the models they are made from."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, add_toes, edits, new_root
from urdf_edits import edited_urdf, scale_mass

from gaitopt.errors import RobotError
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.multibody import BASE, checked_multibody
from gaitopt.model.robot import Robot

WHOLE = edits(new_root("0 0 1.2", waist="revolute"), add_arms(4), add_toes())
LOOSE = {"asymmetry": 1.0}


def robot_with(*more, **choices):
    return Robot.from_urdf(edited_urdf(edits(WHOLE, *more)), choices=ImportOptions(**choices))


def reduced(robot):
    """Pinocchio's model of the arrays with the joints locked that do not move."""
    body = robot.multibody
    model = body.model
    q = pin.neutral(model)
    q[7:] = body.posture
    still = [model.getJointId(n) for n in body.joint_names if n not in body.moving_names]
    return pin.buildReducedModel(model, still, q)


def mass_matrix(model, sole, names, angles):
    """Of base and joints in the order of `names`, the sole at the origin."""
    data, q = model.createData(), pin.neutral(model)
    ids = [model.getJointId(name) for name in names]
    q[[model.joints[j].idx_q for j in ids]] = angles
    pin.framesForwardKinematics(model, data, q)
    q[:7] = pin.SE3ToXYZQUAT(data.oMf[model.getFrameId(sole)].inverse())
    M = pin.crba(model, data, q)
    order = [*range(6), *(model.joints[j].idx_v for j in ids)]
    return M[np.ix_(order, order)]


CASES = {
    "symmetric": (),
    "a heavy left hand": (scale_mass("left_arm_3", 1.4),),
    "a light right foot": (scale_mass("right_foot", 0.97),),
}


@pytest.mark.parametrize("case", CASES)
def test_welded_together_it_is_the_robot_of_the_walk(case):
    robot = robot_with(*CASES[case], **(LOOSE if CASES[case] else {}))
    model, body = reduced(robot), robot.multibody
    assert model.nv == 18
    assert body.mass.sum() == pytest.approx(robot.mass, rel=1e-12)
    rng, E = np.random.default_rng(3), robot.mirror
    for angles in rng.uniform(-0.8, 0.8, (4, 12)):
        data, q = model.createData(), pin.neutral(model)
        q[[model.joints[model.getJointId(n)].idx_q for n in robot.joint_names]] = angles
        pin.framesForwardKinematics(model, data, q)
        soles = [data.oMf[model.getFrameId(name)] for name in body.sole_names]
        rooted = robot.model.createData()
        pin.framesForwardKinematics(
            robot.model, rooted, np.concatenate([pin.neutral(robot.model)[:7], angles])
        )
        there = rooted.oMf[robot.swing_frame].homogeneous
        assert (soles[0].inverse() * soles[1]).homogeneous == pytest.approx(there, abs=1e-12)
        # the mass matrix of the chain at rest on its sole is a congruence of this one
        own = mass_matrix(model, body.sole_names[0], robot.joint_names, angles)
        J = _sole_jacobian(model, body.sole_names[0], robot.joint_names, angles)
        T = np.eye(18)
        T[:6] = np.hstack([np.linalg.inv(J[:, :6]), -np.linalg.solve(J[:, :6], J[:, 6:])])
        chain = pin.crba(
            robot.model, robot.model.createData(),
            np.concatenate([pin.neutral(robot.model)[:7], angles]),
        )  # fmt: skip
        assert T.T @ own @ T == pytest.approx(chain, abs=1e-10 * np.abs(chain).max())
        # and the mirrored posture weighs the same
        mirrored = mass_matrix(model, body.sole_names[1], robot.joint_names, E @ angles)
        assert np.trace(mirrored[:3, :3]) == pytest.approx(np.trace(own[:3, :3]), rel=1e-12)


def _sole_jacobian(model, sole, names, angles):
    data, q = model.createData(), pin.neutral(model)
    ids = [model.getJointId(name) for name in names]
    q[[model.joints[j].idx_q for j in ids]] = angles
    J = pin.computeFrameJacobian(model, data, q, model.getFrameId(sole), pin.LOCAL)
    return J[:, [*range(6), *(model.joints[j].idx_v for j in ids)]]


def test_a_symmetric_robot_keeps_the_bodies_of_its_file():
    robot = robot_with()
    body, file = robot.multibody, pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    assert len(body.joint_names) == 23
    for row, name in enumerate(body.joint_names):
        joint = file.getJointId(name)
        inertia = file.inertias[joint]
        assert body.mass[row + 1] == pytest.approx(inertia.mass, rel=1e-12)
        assert body.inertia[row + 1] == pytest.approx(inertia.inertia, abs=1e-12)
        assert body.placement[row] == pytest.approx(
            file.jointPlacements[joint].homogeneous, abs=1e-12
        )
        above = file.parents[joint]
        parent = BASE if above == 1 else body.joint_names.index(file.names[above])
        assert body.parent[row] == parent < row


def test_averaging_changes_the_heaviest_link_alone():
    even, heavy = robot_with().multibody, robot_with(
        scale_mass("left_arm_3", 1.4), **LOOSE
    ).multibody  # fmt: skip
    changed = {
        ("base", *heavy.joint_names)[row]
        for row in np.flatnonzero(np.abs(heavy.centre - even.centre).max(axis=1) > 1e-9)
    }
    assert changed == {"waist"}  # the torso, with it half of what the hand has more
    assert heavy.mass[1 + heavy.joint_names.index("left_arm_joint_3")] == pytest.approx(0.7)


def test_soles_are_mirror_images(robot):
    corners = robot.multibody.sole_corners
    assert corners[0] == pytest.approx(robot.sole.corners)
    assert corners[1][[1, 0, 3, 2]] == pytest.approx(robot.sole.corners * [1.0, -1.0, 1.0])
    assert "13" in repr(robot.multibody)


@pytest.mark.parametrize("name", ["placement", "axis", "mass", "inertia", "sole_rectangle"])
def test_numbers_whose_squares_have_no_value_are_refused(robot, name):
    values = np.array(getattr(robot.multibody, name))
    values.reshape(-1)[0] = 1e200
    with pytest.raises(RobotError, match=rf"its {name} holds a number beyond 1e\+50"):
        checked_multibody(replace(robot.multibody, **{name: values}))
