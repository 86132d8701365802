"""Walks of robots with damping, friction, springs, rotors and carried weight."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from places import CASES

from gaitopt.design.audit import audit
from gaitopt.design.certificate import ask_referee, on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.design.summary import summarise
from gaitopt.gait import quantities
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.importers.physics import PassiveJoint, Physics, PointMass
from gaitopt.importers.reader import read_source
from gaitopt.mechanics.single_support import FRICTION_RATE
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot
from gaitopt.solvers import solver_by_name
from gaitopt.tolerances import MOMENTUM, REFEREE

URDF = CASES / "urdf_damping_friction.urdf"
SPEED = 0.5
JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
CENTRED = PassiveJoint((2.0, 0.4, 0.1), 1.5, (10.0, 0.0, 4.0), 0.0)
BENT = PassiveJoint((1.0,), 0.8, (15.0, 5.0), 0.3)


def everything() -> Robot:
    """The small biped with all there is, the same left and right."""
    joints = {
        f"{side}_{joint}": CENTRED if joint.endswith(("yaw", "roll")) else BENT
        for side in ("left", "right")
        for joint in JOINTS
    }
    carried = {"base": PointMass(6.0, (0.02, 0.0, 0.2))}
    carried |= {f"{s}_knee_link": PointMass(2.0, (0.0, 0.0, -0.15)) for s in ("left", "right")}
    source = read_source(CASES / "base_mini.urdf")
    source.__dict__["physics"] = Physics(joints, (0.0, 0.0, -6.0), carried)
    choices = ImportOptions(limits=(LimitOverride("*", armature=0.02),))
    return Robot.from_reading(source, import_robot(source, choices))


@pytest.fixture(scope="module")
def stepped():
    """Robot, step and fine grid of an ordinary walk."""
    robot = everything()
    problem = WalkProblem(robot, humanoid_task(robot, speed=SPEED))
    problem = on_fine_grid(problem)
    return robot, problem.step(first_guess(problem)), problem.grid


def energy(robot: Robot, q: np.ndarray, dq: np.ndarray) -> float:
    """Kinetic (with the rotors) and potential energy, springs and carried weight included."""
    model, data = robot.model, robot.model.createData()
    full, rate = np.concatenate([pin.neutral(model)[:7], q]), np.concatenate([np.zeros(6), dq])
    # With the rotors, which pin.computeKineticEnergy leaves out.
    total = rate @ pin.crba(model, data, full) @ rate / 2.0
    total += pin.computePotentialEnergy(model, data, full)
    carried, passive = robot.physics.carried, robot.physics.passive
    pin.forwardKinematics(model, data, full)
    for body in range(13):
        place = data.oMi[body + 1]
        raised = place.rotation @ carried.moment[body] + carried.mass[body] * place.translation
        total += robot.physics.gravity @ raised  # less its potential energy, -g . m p
    x = q - passive.rest
    powers = np.arange(2, passive.stiffness.shape[1] + 2)
    return float(total + (passive.stiffness * x[:, None] ** powers / powers).sum())


def test_energy_is_balanced_along_a_walk(stepped):
    """The motors' work is what the energy gained and what damping and friction took."""
    robot, step, grid = stepped
    passive, (q, dq, _) = robot.physics.passive, step.motion
    work = step.duration * grid.weights @ (step.read(quantities.TORQUE) * dq).sum(axis=1)
    speed = np.abs(dq)[:, :, None] ** np.arange(2, passive.damping.shape[1] + 2)
    lost = (passive.damping * speed).sum(axis=(1, 2))
    lost += (passive.friction * np.tanh(dq / FRICTION_RATE) * dq).sum(axis=1)
    lost = step.duration * grid.weights @ lost
    gained = energy(robot, q[-1], dq[-1]) - energy(robot, q[0], dq[0])
    assert lost > 5.0
    assert relative_error(work, gained + lost) < 1e-5


def test_referee_and_momentum_agree(stepped):
    robot, step, grid = stepped
    verdict = ask_referee(robot, step, grid)
    assert 0.0 < verdict.worst < REFEREE
    assert 0.0 < verdict.momentum < MOMENTUM
    assert verdict.weight == pytest.approx((robot.mass - 10.0) * 6.0 * step.duration)


@pytest.mark.parametrize("what", ["damping", "friction", "stiffness", "rest"])
def test_a_changed_joint_is_found(stepped, what):
    robot, step, grid = stepped
    passive = robot.physics.passive
    other = replace(passive, **{what: 1.001 * getattr(passive, what)})
    wrong = replace(robot, physics=replace(robot.physics, passive=other))
    assert ask_referee(wrong, step, grid).torque > REFEREE > ask_referee(wrong, step, grid).wrench


def test_changed_carried_weight_is_found(stepped):
    robot, step, grid = stepped
    carried = robot.physics.carried
    other = replace(carried, mass=1.001 * carried.mass)
    wrong = replace(robot, physics=replace(robot.physics, carried=other))
    verdict = ask_referee(wrong, step, grid)
    assert min(verdict.torque, verdict.wrench) > REFEREE
    assert verdict.impulse < REFEREE  # the impact knows no weight


@pytest.fixture(scope="module")
def designs() -> tuple[Design, Design]:
    """The walk of a file with damping and friction, and without them."""
    rotors = (LimitOverride("*", armature=0.02),)
    counted = Robot.from_urdf(URDF, choices=ImportOptions(limits=rotors))
    left_out = ImportOptions(limits=rotors, without=("damping", "friction"))
    bare, options = Robot.from_urdf(URDF, choices=left_out), DesignOptions(solver_by_name("sqp"))
    return tuple(design(r, humanoid_task(r, speed=0.6), options) for r in (counted, bare))


def test_walks_are_certified_with_and_without(designs):
    assert [d.certificate.verdict for d in designs] == ["certified"] * 2
    counted, bare = (d.gait for d in designs)
    assert counted.cost > 2.0 * bare.cost


def test_the_walk_of_the_whole_robot_is_the_cheapest_for_it(designs):
    """The other walk's motion costs this robot more."""
    robot, task = designs[0].problem.robot, designs[0].problem.task
    problem = WalkProblem(robot, task)
    costs = [problem.values(d.gait.parameters).cost for d in designs]
    assert costs[0] < costs[1]


def test_gait_files_give_the_same_robot_again(designs, tmp_path):
    for found in designs:
        again = audit(load_gait(save_gait(found.gait, tmp_path / "walk.npz")))
        assert (again.altered, again.passed) == ((), True)


def test_summaries_say_what_counts(designs):
    counted, bare = (summarise(d.gait)["physics"] for d in designs)
    rotor = {"armature_kg_m2": 0.02, "armature_from": "chosen"}
    knee = {**rotor, "damping": [5.0], "friction_Nm": 3.0}
    assert counted["joints"]["left_knee"] == knee
    assert (bare["joints"]["left_knee"], bare["without"]) == (rotor, ["friction", "damping"])
    assert counted["gravity_m_per_s2"] == 9.81


def test_a_file_whose_physics_was_changed_is_found(designs):
    gait = designs[0].gait
    physics = {**gait.meta["physics"], "carried_weight_N": 1.0}
    assert "physics" in audit(replace(gait, meta={**gait.meta, "physics": physics})).altered


def test_gaits_of_version_0_1_counted_rotors_alone(designs):
    """Their record says nothing of physics, and their torques hold none of it."""
    gait = designs[1].gait
    choices = {k: v for k, v in gait.meta["choices"].items() if k != "without"}
    meta = {k: v for k, v in gait.meta.items() if k != "physics"} | {"choices": choices}
    old = audit(replace(gait, meta=meta))
    assert (old.altered, old.passed) == ((), True)
