"""The MuJoCo model of a gait's robot, and inverse dynamics with it, against Pinocchio's numbers."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, edits, new_root
from numerics import relative_error
from places import CASES
from sample_gait import sample_gait
from urdf_edits import edited_urdf

from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.importers.physics import PassiveJoint, Physics
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot
from gaitopt.simulate.mujoco_model import simulated_robot
from gaitopt.simulate.second_engine import second_engine


def passive():
    """The small biped whose joints have friction, two degrees of damping, and springs."""
    source = read_source(CASES / "base_mini.urdf")
    joint = PassiveJoint(damping=(1.5, 0.2), friction=0.7, stiffness=(4.0,))
    joints = {str(n): joint for n in source.model().names[2:]}
    source.__dict__["physics"] = Physics(joints, (0.0, 0.0, -9.7), {})
    return Robot.from_reading(source, import_robot(source, ImportOptions()))


def with_arms():
    """A biped whose four-joint arms hang still."""
    return Robot.from_urdf(edited_urdf(edits(new_root("0 0 1.2", waist="revolute"), add_arms(4))))


ROBOTS = {"friction, damping, springs": passive, "arms that hang still": with_arms}


def guessed(robot, slope=0.0):
    problem = WalkProblem(robot, preset_task("standard", speed=0.6, slope=slope))
    return gait_at(problem, first_guess(problem), {})


@pytest.mark.parametrize("name", ROBOTS)
def test_the_model_is_the_robot_of_the_gait(name, rng):
    """Mass matrix with rotors, mass, and places of the soles, in a random posture."""
    body = ROBOTS[name]().multibody
    body = replace(body, armature=rng.uniform(0.01, 0.1, len(body.joint_names)))
    robot = simulated_robot(body)
    own, moving = body.model, np.concatenate([np.arange(6), 6 + body.moving])
    q = np.concatenate([pin.neutral(own)[:7], body.posture])
    q[7 + body.moving] += rng.uniform(-0.5, 0.5, len(body.moving))
    data, at = own.createData(), mujoco.MjData(robot.model)
    mass = pin.crba(own, data, q)[np.ix_(moving, moving)]
    at.qpos[:] = robot.position(q)
    mujoco.mj_forward(robot.model, at)
    found = np.zeros((robot.model.nv, robot.model.nv))
    mujoco.mj_fullM(robot.model, at, found)
    order = np.concatenate([np.arange(6), robot.dof])
    assert relative_error(found[np.ix_(order, order)], mass) < 1e-12
    assert robot.mass == pytest.approx(body.mass.sum(), rel=1e-14)
    pin.framesForwardKinematics(own, data, q)
    for site, sole in zip(robot.site, body.sole_names, strict=True):
        place = data.oMf[own.getFrameId(sole)]
        assert at.site_xpos[site] == pytest.approx(place.translation, abs=1e-14)
        assert at.site_xmat[site] == pytest.approx(place.rotation.ravel(), abs=1e-14)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_second_engine_agrees(name):
    found = second_engine(guessed(ROBOTS[name](), slope=0.1), instants=61)
    assert found.agrees
    assert 0.0 < found.largest < 1e-11
    assert "agrees at 61 instants" in str(found)


def test_a_second_engine_sees_a_wrong_number():
    """A rate after the impact that is a millionth off."""
    gait = sample_gait()
    wrong = replace(gait, rate_after=gait.rate_after * (1.0 + 1e-6))
    assert second_engine(gait, instants=31).agrees
    assert second_engine(wrong, instants=31).rate_after == pytest.approx(1e-6, rel=1e-3)
    assert "DIFFERS" in str(second_engine(wrong, instants=31))


def test_motors_push_no_harder_than_they_can(robot):
    """A limit of 50 N·m on one motor, none on the others."""
    body = robot.multibody
    limit = np.full(len(body.moving), np.nan)
    limit[3] = 50.0
    model = simulated_robot(body, limit)
    at = mujoco.MjData(model.model)
    at.ctrl[:] = 80.0
    mujoco.mj_forward(model.model, at)
    assert at.qfrc_actuator[model.dof] == pytest.approx(
        [50.0 if n == 3 else 80.0 for n in range(12)]
    )


def test_a_robot_whose_weight_is_carried_is_refused(robot):
    carried = np.full(len(robot.multibody.mass), 0.5)
    body = replace(robot.multibody, carried_mass=carried)
    with pytest.raises(InputError, match="carried from outside"):
        simulated_robot(body)


@pytest.mark.parametrize("task", [{"stairs": 0.1}, {"toe_off": 0.7}])
def test_stairs_and_feet_that_turn_have_their_inverse_dynamics_checked(robot, task):
    problem = WalkProblem(robot, preset_task("standard", speed=0.6, **task))
    gait = gait_at(problem, first_guess(problem), {})
    found = second_engine(gait, instants=31)
    assert max(found.torque, found.force, found.moment) < 1e-11
