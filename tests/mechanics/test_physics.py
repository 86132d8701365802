"""Damping, friction, springs, rotors, gravity and carried weight, against MuJoCo and each other."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from motions import random_motion
from numerics import check_jacobian, relative_error
from places import CASES

from gaitopt.contact import ToeLine
from gaitopt.mechanics.chain_build import chain_of_robot, loads_of_robot
from gaitopt.mechanics.newton_euler import motor_effort, sole_axes, turned
from gaitopt.mechanics.single_support import (
    FRICTION_RATE,
    SingleSupport,
    odd_polynomial,
    polynomial,
    standing_robot,
)
from gaitopt.model.chain_physics import CarriedWeight, ChainPhysics, PassiveJoints
from gaitopt.model.robot import Robot

COUNT = 4
FILES = ("mjcf_damping_stiffness.xml", "mjcf_gravity.xml", "mjcf_gravcomp.xml", "everything")


def case_text(name: str) -> str:
    """A case; or one with all of them, the terms of higher powers too, alike left and right."""
    if name != "everything":
        return (CASES / name).read_text()
    text = (CASES / "mjcf_gravcomp.xml").read_text()
    rests = {"hip_yaw": 0.0, "hip_roll": 0.0, "hip_pitch": -0.2, "knee": 0.4}
    for joint, rest in {**rests, "ankle_pitch": 0.1, "ankle_roll": 0.0}.items():
        for side, sign in (("left", 1.0), ("right", 1.0 if rest else -1.0)):
            named = f'name="{side}_{joint}"'
            own = (
                f'damping="2 0.3 0.05" stiffness="20 {8.0 * sign} 3" springref="{rest}" '
                'frictionloss="1.5" armature="0.02"'
            )
            text = text.replace(f"{named} axis", f"{named} {own} axis")
    assert text.count("springref") == 12
    text = text.replace('<body name="base"', '<body gravcomp="0.3" name="base"')
    return text.replace("<worldbody>", '<option gravity="0 0 -3.7"/><worldbody>')


def robot_and_mujoco(name: str) -> tuple[Robot, mujoco.MjModel]:
    text = case_text(name)
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    return Robot.from_urdf(text), model


def fast_motion(robot: Robot, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Rates at which smooth friction is Coulomb's to the last digit."""
    q, dq, ddq = random_motion(robot, rng, COUNT)
    return q, np.sign(dq) * (np.abs(dq) + 25.0 * FRICTION_RATE), ddq


def mujoco_effort(robot: Robot, model: mujoco.MjModel, motion: tuple[np.ndarray, ...]) -> tuple:
    """Ground wrench on the stance sole and motor torques by MuJoCo's inverse dynamics."""
    chain, data, at = robot.model, robot.model.createData(), mujoco.MjData(model)
    full = np.concatenate([pin.neutral(chain)[:7], motion[0]])
    rate, change = (np.concatenate([np.zeros(6), part]) for part in motion[1:])
    pin.forwardKinematics(chain, data, full, rate, change)
    pin.updateFramePlacements(chain, data)
    base = chain.getFrameId("base")
    place = data.oMf[base]
    at.qpos[:3] = place.translation
    at.qpos[3:7] = np.roll(pin.Quaternion(place.rotation).coeffs(), 1)
    spin = pin.getFrameVelocity(chain, data, base, pin.LOCAL).angular
    around = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    at.qvel[:3] = pin.getFrameVelocity(chain, data, base, around).linear
    at.qacc[:3] = pin.getFrameClassicalAcceleration(chain, data, base, around).linear
    at.qvel[3:6] = spin
    at.qacc[3:6] = pin.getFrameAcceleration(chain, data, base, pin.LOCAL).angular
    for k, name in enumerate(robot.joint_names):
        joint = model.joint(name)
        at.qpos[joint.qposadr] = motion[0][k]
        at.qvel[joint.dofadr], at.qacc[joint.dofadr] = motion[1][k], motion[2][k]
    mujoco.mj_inverse(model, at)
    force, turn = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    foot = model.body(f"{robot.choices.stance}_ankle_roll_link").id
    mujoco.mj_jac(model, at, force, turn, np.zeros(3), foot)
    jacobian = np.vstack([force, turn])
    wrench = np.linalg.solve(jacobian[:, :6].T, at.qfrc_inverse[:6])
    torque = at.qfrc_inverse - jacobian.T @ wrench
    rows = [int(model.joint(name).dofadr[0]) for name in robot.joint_names]
    return wrench, torque[rows]


@pytest.mark.parametrize("name", FILES)
def test_effort_is_that_of_mujoco(name, rng):
    robot, model = robot_and_mujoco(name)
    if name == "mjcf_damping_stiffness.xml":  # its springs are not mirror images
        for row, joint in enumerate(robot.joint_names):
            model.qpos_spring[model.joint(joint).qposadr] = robot.physics.passive.rest[row]
    motion = fast_motion(robot, rng)
    effort = SingleSupport(robot, COUNT).state(*motion).effort
    for k in range(COUNT):
        wrench, torque = mujoco_effort(robot, model, tuple(part[k] for part in motion))
        assert relative_error(effort[k, :6], wrench) < 1e-10
        assert relative_error(effort[k, 6:], torque) < 1e-10


@pytest.mark.parametrize("name", FILES)
def test_referee_agrees(name, rng):
    robot, _ = robot_and_mujoco(name)
    motion = random_motion(robot, rng, COUNT)
    motion[1][0] *= 1e-2  # where friction turns round
    effort = SingleSupport(robot, COUNT).state(*motion).effort
    chain = chain_of_robot(robot)
    gravity = turned(np.array(robot.model.gravity.linear))
    R0, torque = motor_effort(chain, loads_of_robot(robot, chain), *motion, gravity=gravity)
    assert relative_error(effort[:, :6], sole_axes(R0)) < 1e-11
    assert relative_error(effort[:, 6:], torque) < 1e-11


@pytest.fixture
def loaded(robot, rng):
    """The paper's biped with all there is, nothing of it alike."""
    passive = PassiveJoints(
        damping=rng.uniform(0.1, 3.0, (12, 3)),
        friction=rng.uniform(0.5, 4.0, 12),
        stiffness=rng.uniform(1.0, 20.0, (12, 3)),
        rest=rng.uniform(-0.5, 0.5, 12),
    )
    carried = CarriedWeight(rng.uniform(-1.0, 3.0, 13), rng.uniform(-0.3, 0.3, (13, 3)))
    model = robot.model.copy()
    gravity = np.array([0.4, -0.3, -8.0])
    model.gravity.linear = gravity
    return replace(robot, model=model, physics=ChainPhysics(passive, carried, gravity, True, {}))


@pytest.fixture
def slow_motion(loaded, rng):
    """Rates at which friction is neither 0 nor Coulomb's."""
    q, dq, ddq = random_motion(loaded, rng, COUNT)
    return q, 0.1 * dq, ddq


@pytest.mark.parametrize("block", range(3), ids=("q", "dq", "ddq"))
def test_first_derivatives(loaded, slow_motion, block):
    support = SingleSupport(loaded, COUNT)
    slope = support.derivatives(*slow_motion)[1].effort[:, :, 12 * block : 12 * block + 12]

    def effort(change):
        parts = list(slow_motion)
        parts[block] = parts[block] + change
        return support.state(*parts).effort

    check_jacobian(effort, slope, np.zeros(12), step=1e-4)


def test_second_derivatives(loaded, slow_motion, rng):
    support, weights = SingleSupport(loaded, COUNT), rng.normal(size=(COUNT, 18))
    found = support.derivatives(*slow_motion)[1].hessian(weights)
    blocks = (
        np.concatenate([found.qq, found.qv.swapaxes(1, 2)], axis=1),
        np.concatenate([found.qv, found.vv], axis=1),
    )
    for block, exact in enumerate(blocks):

        def gradient(change, block=block):
            parts = list(slow_motion)
            parts[block] = parts[block] + change
            return (weights[:, None] @ support.derivatives(*parts)[1].effort)[:, 0, :24]

        check_jacobian(gradient, exact, np.zeros(12), step=3e-5)


def test_state_and_slope_tell_the_same(loaded, slow_motion):
    support = SingleSupport(loaded, COUNT)
    effort = support.state(*slow_motion).effort
    assert relative_error(support.derivatives(*slow_motion)[0].effort, effort) < 1e-13


def test_referee_agrees_under_any_gravity(loaded, slow_motion):
    effort = SingleSupport(loaded, COUNT).state(*slow_motion).effort
    chain = chain_of_robot(loaded)
    gravity = turned(np.array(loaded.model.gravity.linear))
    R0, torque = motor_effort(chain, loads_of_robot(loaded, chain), *slow_motion, gravity=gravity)
    assert relative_error(effort[:, :6], sole_axes(R0)) < 1e-11
    assert relative_error(effort[:, 6:], torque) < 1e-11


def test_polynomials():
    """2 x + 3 |x| x + 5 x³ at -2: 2 (-2) - 3 (4) - 5 (8); the plain one has + 3 (4)."""
    coefficients, x = np.array([[2.0, 3.0, 5.0]]), np.array([[-2.0]])
    odd, plain = odd_polynomial(coefficients, x), polynomial(coefficients, x)
    assert [part.item() for part in odd] == [-56.0, 74.0, -66.0]
    assert [part.item() for part in plain] == [-32.0, 50.0, -54.0]


def test_a_robot_without_physics_takes_the_short_road(robot):
    support = SingleSupport(robot, COUNT)
    assert robot.physics.passive is None
    assert robot.physics.carried is None
    slope = support.derivatives(*(np.zeros((COUNT, 12)),) * 3)[1]
    assert (slope.passive, slope.carried) == (None, None)


def test_a_foot_tilted_on_its_hinge_feels_another_gravity(loaded, slow_motion):
    """Passive joints and carried weight of the foot included: the hinge held at an angle."""
    contact, angle = ToeLine(0.01), 0.3
    still = np.zeros((COUNT, 1))
    tilted = [np.hstack([still + angle * (k == 0), part]) for k, part in enumerate(slow_motion)]
    effort = SingleSupport(standing_robot(loaded, contact), COUNT).state(*tilted).effort
    place = pin.exp6(angle * contact.hinge(loaded.sole).twist)
    model = loaded.model.copy()
    model.gravity.linear = place.rotation.T @ loaded.model.gravity.linear
    flat = SingleSupport(replace(loaded, model=model), COUNT).state(*slow_motion).effort
    assert relative_error(effort[:, 7:], flat[:, 6:]) < 1e-12
    wrench = np.array([place.act(pin.Force(one)).vector for one in flat[:, :6]])
    assert relative_error(effort[:, :6], wrench) < 1e-12


def test_the_referee_knows_the_load_of_a_hinged_foot(loaded, slow_motion, rng):
    hinged = standing_robot(loaded, ToeLine(0.01))
    turn = rng.normal(0.0, [[[0.3]], [[1.0]], [[10.0]]], (3, COUNT, 1))
    motion = [np.hstack(parts) for parts in zip(turn, slow_motion, strict=True)]
    effort = SingleSupport(hinged, COUNT).state(*motion).effort
    chain = chain_of_robot(hinged)
    loads, gravity = loads_of_robot(hinged, chain), np.array(loaded.model.gravity.linear)
    R0, torque = motor_effort(chain, loads, *motion, gravity=turned(gravity))
    assert relative_error(effort[:, 6:], torque) < 1e-10
    assert relative_error(effort[:, :6], sole_axes(R0)) < 1e-10
