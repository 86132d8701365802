"""Chains built from Table 1, from any joint lines, and from robots rooted at a foot."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from paper_chain import chain_of_spec
from random_chains import (
    EXACT,
    pin_model,
    posture,
    random_cloud_chain,
    random_spec,
    relative,
    seeded,
    turned_about,
)

from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import InputError, RobotError
from gaitopt.mechanics.chain_build import LinkMasses, chain_from_axes, chain_of_robot
from gaitopt.mechanics.newton_euler import (
    SOLE_AXES,
    JointTable,
    hat,
    inverse_dynamics,
    link_placements,
    sole_axes,
    sole_placement,
)
from gaitopt.model.robot import Robot

X, Y, Z = np.eye(3)


@seeded
def test_table_1_at_the_zero_posture_is_a_biped_with_straight_legs(rng):
    spec = random_spec(rng)
    g = spec.geometry
    rotations, origins = link_placements(chain_of_spec(spec), np.zeros(12))
    ankle = np.array([g.l1, 0.0, g.d1])
    knee = ankle + g.d3 * Z
    hip = knee + np.array([0.0, g.l4, g.d4])
    other_hip = hip + g.d7 * Y
    other_knee = other_hip + np.array([0.0, g.l4, -g.d4])
    other_ankle = other_knee - g.d3 * Z
    expected = [
        np.zeros(3), ankle, ankle, knee, hip, hip, hip,
        other_hip, other_hip, other_hip, other_knee, other_ankle, other_ankle,
    ]  # fmt: skip
    assert relative(origins @ SOLE_AXES, np.array(expected)) < EXACT
    axes = SOLE_AXES @ rotations[..., 2][..., None]
    directions = [X, X, Y, Y, Y, X, Z, Z, X, Y, Y, Y, X]
    assert relative(axes[..., 0], np.array(directions)) < EXACT
    rotation, origin = sole_placement(chain_of_spec(spec), np.zeros(12))
    assert relative(rotation, np.eye(3)) < EXACT
    assert relative(origin, np.array([0.0, g.d7 + 2.0 * g.l4, 0.0])) < EXACT


@seeded
def test_spec_urdf_and_robot_put_the_swing_sole_at_the_same_place(rng):
    spec = random_spec(rng)
    robot = Robot.from_urdf(urdf_text(spec))
    q = rng.uniform(-0.8, 0.8, 12)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, posture(q))
    expected = data.oMf[robot.swing_frame]
    for chain in (chain_of_spec(spec), chain_of_robot(robot)):
        rotation, origin = sole_placement(chain, q)
        assert relative(rotation, expected.rotation) < EXACT
        assert relative(origin, expected.translation) < EXACT


def lines(rng, kind, n=6):
    """Joint lines of one kind, at the zero posture in the stance sole frame."""
    origins = rng.uniform(-0.5, 0.5, (n, 3))
    axes = rng.normal(size=(n, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    if kind == "parallel":
        axes[1:] = axes[0] * rng.choice([-1.0, 1.0], n - 1)[:, None]
    if kind in (typed := {"nearly parallel": 4e-6, "parallel to seven digits": 3e-8}):
        axes[1:] = axes[0] + rng.normal(0.0, typed[kind], (n - 1, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
    if kind == "meeting":
        origins[1:] = origins[0]
    if kind == "coinciding":
        axes[:] = axes[0]
        origins = origins[0] + rng.uniform(-1.0, 1.0, n)[:, None] * axes
    return origins, axes


def bodies(rng, n=6):
    points = rng.normal(0.0, 0.2, (n + 1, 5, 3))
    inertias = [-np.sum(hat(cloud) @ hat(cloud), axis=0) for cloud in points]
    masses, coms = rng.uniform(0.5, 3.0, n + 1), rng.uniform(-1, 1, (n + 1, 3))
    return LinkMasses(masses, coms, np.array(inertias))


def pin_from_lines(origins, axes, links, tool, sigma):
    """Pinocchio's model with every joint frame parallel to the world at the zero posture."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "foot")
    before = np.zeros(3)
    places = [np.zeros(3), *origins]
    for j, point in enumerate(places):
        if j:
            kind = (pin.JointModelRevoluteUnaligned, pin.JointModelPrismaticUnaligned)
            joint = model.addJoint(
                joint, kind[int(sigma[j - 1])](axes[j - 1]),
                pin.SE3(np.eye(3), point - before), f"joint{j}",
            )  # fmt: skip
        inertia = pin.Inertia(links.masses[j], links.coms[j] - point, links.inertias[j])
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        before = point
    place = pin.SE3(tool[0], tool[1] - before)
    model.addFrame(pin.Frame("swing", joint, place, pin.FrameType.OP_FRAME), False)
    return model


@pytest.mark.parametrize(
    ("kind", "tolerance"),
    [
        ("skew", EXACT),
        ("parallel", EXACT),
        ("meeting", EXACT),
        ("coinciding", EXACT),
        ("nearly parallel", EXACT),
        ("parallel to seven digits", EXACT),
    ],
)
@seeded
def test_any_joint_lines_make_the_same_machine(kind, tolerance, rng):
    origins, axes = lines(rng, kind)
    links = bodies(rng)
    tool = (turned_about(rng.normal(size=3), 1.0), rng.uniform(-1.0, 1.0, 3))
    sigma = (rng.random(6) < 0.3).astype(float)
    armature = rng.uniform(0.1, 1.0, 6)
    chain = chain_from_axes(origins, axes, links, tool, sigma=sigma, armature=armature)
    model = pin_from_lines(origins, axes, links, tool, sigma)
    model.armature = np.concatenate([np.zeros(6), armature])
    data = model.createData()

    q, dq, ddq = rng.uniform(-1.5, 1.5, (3, 6))
    still = np.zeros(6)
    expected = pin.rnea(
        model, data, posture(q), np.concatenate([still, dq]), np.concatenate([still, ddq])
    )
    R0, torque = inverse_dynamics(chain, q, dq, ddq)
    assert relative(np.concatenate([sole_axes(R0), torque]), expected) < tolerance
    pin.framesForwardKinematics(model, data, posture(q))
    sole = data.oMf[model.getFrameId("swing")]
    rotation, origin = sole_placement(chain, q)
    assert relative(rotation, sole.rotation) < tolerance
    assert relative(origin, sole.translation) < tolerance


class Foreign(SimpleNamespace):
    """What is read of a robot; one is another, as robots are."""

    __hash__ = object.__hash__


def foreign(model):
    return Foreign(model=model, stance_sole="stance", swing_sole="swing")


@seeded
def test_a_foreign_robot_with_tilted_axes_and_a_displaced_sole(rng):
    chain, _ = random_cloud_chain(rng)
    model = pin_model(chain, 9.81)
    place = pin.SE3(turned_about(rng.normal(size=3), 0.5), rng.uniform(-0.2, 0.2, 3))
    model.frames[model.getFrameId("stance")].placement = place
    model.gravity = pin.Motion(-9.81 * place.rotation @ Z, np.zeros(3))  # up in the sole frame
    model.armature = np.concatenate([np.zeros(6), rng.uniform(0.1, 1.0, chain.dof)])

    q, dq, ddq = rng.uniform(-1.5, 1.5, (3, chain.dof))
    still = np.zeros(6)
    expected = pin.rnea(
        model, model.createData(), posture(q),
        np.concatenate([still, dq]), np.concatenate([still, ddq]),
    )  # fmt: skip
    R0, torque = inverse_dynamics(chain_of_robot(foreign(model)), q, dq, ddq)
    assert relative(torque, expected[6:]) < EXACT
    ground = place.actInv(pin.Force(expected[:6])).vector
    assert relative(sole_axes(R0), ground) < EXACT


def test_a_model_that_does_not_start_at_the_foot_is_refused():
    model = pin_model(random_cloud_chain(np.random.default_rng(1))[0], 9.81)
    robot = Foreign(model=model, stance_sole="swing", swing_sole="stance")
    with pytest.raises(RobotError, match="root the model at the stance sole first"):
        chain_of_robot(robot)


def test_joints_without_a_link_before_them_are_refused():
    zero = np.zeros(2)
    with pytest.raises(InputError, match=r"antecedent = \(0, 2\) is not allowed"):
        JointTable(zero, zero, zero, zero, zero, zero, zero, (0, 2))


def test_a_ball_joint_is_refused():
    model = pin.Model()
    foot = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "foot")
    ball = model.addJoint(foot, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    for name, joint in (("stance", foot), ("swing", ball)):
        model.addFrame(pin.Frame(name, joint, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    with pytest.raises(RobotError, match="'ball' must be revolute or prismatic"):
        chain_of_robot(foreign(model))


def test_a_joint_axis_without_direction_is_refused():
    links = bodies(np.random.default_rng(0), 1)
    tool = (np.eye(3), np.zeros(3))
    with pytest.raises(InputError, match="direction of non-zero length"):
        chain_from_axes(np.zeros((1, 3)), np.zeros((1, 3)), links, tool)
