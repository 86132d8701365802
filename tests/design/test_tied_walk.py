"""Walks of robots whose joints follow others: certified, judged by both referees, stored, shown."""

import functools
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numpy.polynomial import Polynomial
from tied_bipeds import TIED, mimic, tied
from urdf_edits import edited_urdf

from gaitopt.design.audit import audit
from gaitopt.design.certificate import ask_referee
from gaitopt.design.design import design
from gaitopt.design.pipeline import Design
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import gait_members, load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.single_support import standing_robot
from gaitopt.model.robot import Robot
from gaitopt.motions.export import csv_text, joint_names, stride_record, stride_samples
from gaitopt.motions.motion import motion
from gaitopt.simulate.disturbance import SensorNoise, StartError, disturbed_start, measured
from gaitopt.simulate.mujoco_model import simulated_robot
from gaitopt.simulate.second_engine import second_engine
from gaitopt.simulate.walk import Ending, WalkOptions, simulate
from gaitopt.view.figures import make_figure


@functools.cache
def walked(name: str) -> Design:
    """The walk of one of the tied bipeds at the speed that suits its legs."""
    robot = tied(name)
    return design(robot, preset_task("humanoid", robot, speed=0.5))


@pytest.mark.parametrize("name", TIED)
def test_it_walks_and_both_referees_agree(name, tmp_path):
    found = walked(name)
    assert found.certificate.certified
    gait = found.gait
    assert gait.joint_names == tied(name).joint_names
    judged = second_engine(gait, instants=61)
    assert judged.agrees
    assert judged.largest < 1e-11
    save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(tmp_path / "gait.npz")
    assert audit(again).passed
    for part in ("tied", "tied_to", "tie", "tie_bend"):
        own = getattr(gait.multibody, part)
        np.testing.assert_array_equal(getattr(again.multibody, part), own)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"toe_off": 0.65, "toe_strip": 0.008},
        {"toe_off": 0.65, "heel_strike": 0.15, "heel_strip": 0.012},
    ],
)
@pytest.mark.parametrize("name", TIED)
def test_newton_euler_agrees_on_any_step(name, more):
    """Its impact keeps the ties by impulses of their own, with no coordinates eliminated."""
    robot = tied(name)
    problem = WalkProblem(
        robot, preset_task(boundary="lifted", speed=0.4, duration=0.5, slope=0.05, **more)
    )
    step = problem.step(perturbed(problem, first_guess(problem), 0.05, 1))
    found = ask_referee(problem.robot, step, problem.grid, problem.schedule)
    assert found.worst < 1e-11


@pytest.mark.parametrize("name", TIED)
def test_the_motors_do_all_the_work(name):
    """On level ground, over a step: their work is the kinetic energy that the impact takes."""
    found, robot = walked(name), tied(name)
    gait, model = found.gait, robot.model
    trajectory = gait.trajectory
    times = np.linspace(0.0, gait.duration, 2001)
    at = trajectory.at(times, before=times > 0.0)
    work = np.trapezoid((at.torque * at.dq).sum(axis=1), times)

    def energy(velocity):
        landed = gait.coefficients[-3]
        q = np.concatenate([pin.neutral(model)[:7], robot.coupling.angles(landed)])
        full = robot.coupling.at(landed).velocity(velocity)
        return float(full @ pin.crba(model, model.createData(), q) @ full) / 2.0

    step = WalkProblem(robot, preset_task("humanoid", robot, speed=0.5)).step(gait.parameters)
    before = energy(np.concatenate([np.zeros(6), gait.rate_before]))
    lost = before - energy(step.impact.velocity)
    assert lost > 0.0
    assert work == pytest.approx(lost, rel=1e-5)


@pytest.mark.parametrize("name", TIED)
def test_samples_and_motions_have_every_joint(name):
    """Those that follow are where the tie puts them, and have no torque of their own."""
    gait = walked(name).gait
    body = gait.multibody
    at = gait.trajectory.at(np.linspace(0.0, 2.0 * gait.duration, 9))  # both steps of a stride
    for row, master, (k, c), bend in zip(
        body.tied, body.tied_to, body.tie, body.tie_bend, strict=True
    ):
        tie = Polynomial([c, k, *bend])
        z, dz, ddz = (part[:, master] for part in (at.q, at.dq, at.ddq))
        np.testing.assert_allclose(at.q[:, row], tie(z), atol=1e-15)
        np.testing.assert_allclose(at.dq[:, row], tie.deriv()(z) * dz, atol=1e-14)
        bent = tie.deriv()(z) * ddz + tie.deriv(2)(z) * dz**2
        np.testing.assert_allclose(at.ddq[:, row], bent, atol=1e-12)
    assert not at.torque[:, body.tied].any()
    sampled = motion(gait, 50.0)
    assert set(tied(name).coupling.names) <= set(sampled.joint_names)
    with pytest.raises(InputError, match=f"the order lacks '{body.joint_names[body.tied[0]]}'"):
        motion(gait, 50.0, joints=gait.joint_names)


def test_mujoco_holds_the_ties():
    """Its model has them as equalities: driven by the motors alone, the hips stay together."""
    body = tied("NAO's hips").multibody
    robot = simulated_robot(body)
    data = mujoco.MjData(robot.model)
    data.qpos[:3] = 0.0, 0.0, 2.0  # in the air
    data.qpos[3] = 1.0
    data.ctrl[robot.motors[5]] = 1.0
    moved = 0.0
    for _ in range(100):
        mujoco.mj_step(robot.model, data)
        apart = data.qpos[robot.tied[0, 0]] - data.qpos[robot.qpos[5]]
        moved = max(moved, abs(data.qpos[robot.qpos[5]]))
        assert abs(apart) < 1e-3
    assert moved > 0.1


def test_a_panel_is_drawn_for_each_pair_and_for_the_shared_motor():
    gait = walked("NAO's hips").gait
    drawn = [axes for axes in make_figure(gait, "torques").axes if axes.get_visible()]
    assert len(drawn) == 6


def test_a_file_with_wrong_ties_is_refused(tmp_path):
    gait = walked("NAO's hips").gait
    body = gait.multibody
    members = gait_members(gait)
    assert {"robot_tied", "robot_tied_to", "robot_tie"} <= set(members)
    wrong = {
        "moves twice": {"tied": body.moving[:1]},
        "follows one that does not move": {"tied_to": body.tied},
        "is not a usual part": {"tie": np.array([[0.0, 0.0]])},
    }
    for message, change in wrong.items():
        save_gait(replace(gait, multibody=replace(body, **change)), tmp_path / "wrong.npz")
        with pytest.raises(GaitFileError, match=message):
            load_gait(tmp_path / "wrong.npz")


def test_files_without_ties_are_as_before(robot):
    problem = WalkProblem(robot, preset_task())
    assert not {n for n in gait_members(gait_at(problem, first_guess(problem), {})) if "tie" in n}


def test_the_closed_form_needs_a_motor_for_each_joint():
    def edit(root):
        for side in ("left", "right"):
            mimic(root, f"{side}_ankle_roll", f"{side}_hip_roll", multiplier=-1.0)

    robot = Robot.from_urdf(edited_urdf(edit))
    with pytest.raises(InputError, match="in this robot 2 follow others: take boundary 'lifted'"):
        WalkProblem(robot, preset_task())
    assert WalkProblem(robot, preset_task(boundary="lifted")).layout.joints == 10


def test_a_hinge_goes_before_the_ties():
    robot = tied("NAO's hips")
    problem = WalkProblem(robot, preset_task(boundary="lifted", toe_off=0.65, toe_strip=0.008))
    standing = standing_robot(robot, problem.schedule.last.contact)
    assert standing.coupling.names[1:] == robot.coupling.names
    assert standing.coupling.free_names == standing.joint_names


@pytest.mark.parametrize("name", TIED)
def test_it_walks_in_mujoco_with_errors_at_the_start(name):
    """Start errors of the joints keep the ties, and so does what sensors see."""
    gait = walked(name).gait
    robot = simulated_robot(gait.multibody)
    rng = np.random.default_rng(3)
    q, v = disturbed_start(robot, gait.trajectory, StartError(angle=0.02, rate=0.1), rng)
    data = mujoco.MjData(robot.model)
    data.qpos[:], data.qvel[:] = q, v
    for state in ((q, v), measured(robot, data, SensorNoise(angle=0.01, rate=0.1), rng)):
        own = tuple(part.copy() for part in state)
        robot.follow(*own)
        np.testing.assert_allclose(state[0], own[0], atol=1e-15)
        np.testing.assert_allclose(state[1], own[1], atol=1e-15)
    mujoco.mj_forward(robot.model, data)
    assert np.abs(robot.sole_jacobian(data, 0) @ v).max() < 1e-12  # the sole is at rest
    walk = simulate(gait, WalkOptions(steps=4))
    assert walk.ending is Ending.WALKED


@pytest.mark.parametrize("name", TIED)
def test_tables_and_records_of_a_stride_have_every_joint(name):
    """The same as the trajectory at its samples, in both steps; splines evaluate to it."""
    gait = walked(name).gait
    found = stride_samples(gait, both_legs=True)
    names, body = joint_names(gait), gait.multibody
    assert names == body.driven_names
    count = len(gait.time)
    inner = np.r_[1 : count - 1, count + 1 : 2 * count - 1]  # off the impacts
    at = gait.trajectory.at(found["time"][inner])
    for what in ("q", "dq", "ddq", "torque"):
        expected = getattr(at, what)[:, body.driven]
        assert found[what][inner] == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    told = stride_record(gait, found)
    follower = body.joint_names[body.tied[0]]
    pieces = told["splines"]["coefficients"][follower]
    starts = gait.trajectory.at(gait.knots[:-1]).q[:, body.tied[0]]
    assert [piece[0] for piece in pieces[0]] == pytest.approx(starts, abs=1e-12)
    assert set(told["impact"]["rates"]["after"]) == set(names)
    assert f"{follower} q [rad]" in csv_text(gait, found).splitlines()[0]
