"""The trajectory against the step's own evaluation, Pinocchio's model of the file, and itself."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, add_toes, edits, new_root
from numerics import relative_error
from places import CASES
from reference_cases import biped
from sample_gait import bare_gait, sample_gait
from synthetic_bipeds import synthetic
from urdf_edits import edited_urdf
from walk_checks import FORCE_MIRROR
from walks import walk

from gaitopt.errors import InputError, RobotError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.trajectory import Trajectory, TrajectoryPhase, fitted_coefficients
from gaitopt.model.robot import Robot

WALKS = (
    "optimum 43",
    "one posture",
    "everything free",
    "added instants",
    "lifted, everything free",
)


def trajectory_of(problem, x):
    return gait_at(problem, x, {}).trajectory


@pytest.fixture(scope="module")
def trajectory():
    found = walk("optimum 43")
    return trajectory_of(found.problem, found.x)


@pytest.fixture(scope="module")
def whole_body():
    """A biped with arms, toes, a waist below the root and a root that looks elsewhere."""
    robot = Robot.from_urdf(
        edited_urdf(edits(new_root("0 0 1.2", waist="revolute"), add_arms(4), add_toes()))
    )
    problem = WalkProblem(robot, preset_task("standard", speed=0.8))
    return robot, trajectory_of(problem, first_guess(problem))


@pytest.mark.parametrize("name", WALKS)
def test_samples_are_those_of_the_step(name):
    found = walk(name)
    step, body = found.problem.step(found.x), found.problem.robot.multibody
    times = found.problem.grid.instants * step.duration
    at = trajectory_of(found.problem, found.x).at(times, before=times > 0.9 * step.duration)
    motion = np.stack([at.q, at.dq, at.ddq])[:, :, body.moving]
    assert relative_error(motion, step.motion) < 1e-12
    assert relative_error(at.torque[:, body.moving], step.read(quantities.TORQUE)) < 1e-12
    assert relative_error(at.wrench[:, 0], step.read(quantities.WRENCH)) < 1e-12
    relative = np.linalg.inv(at.sole[:, 0]) @ at.sole[:, 1]
    corners = body.sole_corners[1] @ relative[:, :3, :3].swapaxes(1, 2) + relative[:, None, :3, 3]
    assert relative_error(corners, step.support.corners) < 1e-12
    assert at.contact.tolist() == [[True, False]] * len(times)
    assert not at.wrench[:, 1].any()


@pytest.mark.parametrize("name", ["five and arms", "seven, torso first"])
def test_robots_of_other_joints_move_as_their_step_says(name):
    robot = synthetic(name)
    problem = WalkProblem(robot, preset_task(boundary="lifted", speed=0.5, duration=0.5))
    x = first_guess(problem)
    x = x + np.random.default_rng(1).normal(0.0, 0.05, x.size)
    step, body = problem.step(x), robot.multibody
    times = problem.grid.instants * step.duration
    at = trajectory_of(problem, x).at(times, before=times > 0.9 * step.duration)
    assert body.moving_names == robot.joint_names
    assert relative_error(np.stack([at.q, at.dq, at.ddq])[:, :, body.moving], step.motion) < 1e-12
    assert relative_error(at.torque[:, body.moving], step.read(quantities.TORQUE)) < 1e-12
    assert relative_error(at.wrench[:, 0], step.read(quantities.WRENCH)) < 1e-12
    legs = [[body.joint_names[row] for row in body.leg(foot)] for foot in (0, 1)]
    count = robot.tree.stance
    assert tuple(legs[0]) == robot.joint_names[:count]
    assert tuple(reversed(legs[1])) == robot.joint_names[count : 2 * count]


@pytest.mark.parametrize("name", ["optimum 43", "one posture", "everything free"])
def test_the_next_step_is_the_mirror_image(name):
    found = walk(name)
    trajectory, robot = trajectory_of(found.problem, found.x), found.problem.robot
    T, moving = trajectory.step_duration, robot.multibody.moving
    times = T * np.array([0.0, 0.13, 0.5, 0.97])
    first, second = trajectory.at(times), trajectory.at(times + T)
    for one in ("q", "dq", "ddq", "torque"):
        here, there = (getattr(at, one)[:, moving] for at in (first, second))
        assert relative_error(there, here @ robot.mirror.T) < 1e-8, one
    assert relative_error(second.wrench[:, 1], first.wrench[:, 0] * FORCE_MIRROR) < 1e-8
    assert second.contact.tolist() == [[False, True]] * 4
    assert second.step.tolist() == [1] * 4
    # in the world, with x along the walk, heights and ways forward are alike
    moved = second.base_position - first.base_position
    assert moved[:, 0] == pytest.approx(trajectory.advance(2).translation[0] / 2.0, abs=1e-9)
    assert moved[:, 2] == pytest.approx(0.0, abs=1e-9)
    assert second.pressure[:, 1, 0] == pytest.approx(first.pressure[:, 0, 0], abs=1e-8)
    assert np.isnan(second.pressure[:, 0]).all()


@pytest.mark.parametrize("name", ["optimum 43", "everything free"])
def test_it_repeats_itself_and_walks_along_x(name):
    found = walk(name)
    trajectory, step = trajectory_of(found.problem, found.x), found.problem.step(found.x)
    times = trajectory.period * np.array([0.05, 0.4, 0.8])
    here = trajectory.at(times)
    for strides in (-3, 1, 50):
        there = trajectory.at(times + strides * trajectory.period)
        for one in ("q", "dq", "ddq", "torque", "wrench", "base_twist", "base_acceleration"):
            assert relative_error(getattr(there, one), getattr(here, one)) < 1e-9, one
        moved = there.base_position - here.base_position
        ahead = np.array([2.0 * strides * step.step_length, 0.0, 0.0])
        assert moved == pytest.approx(np.broadcast_to(ahead, (3, 3)), abs=1e-8)
        assert there.base_quaternion == pytest.approx(here.base_quaternion, abs=1e-9)


def test_only_rates_and_forces_jump_at_the_impact(trajectory):
    found = walk("optimum 43")
    step, robot = found.problem.step(found.x), found.problem.robot
    T, moving = trajectory.step_duration, robot.multibody.moving
    for landing in (1, 2, 3, 41):
        before, after = trajectory.at([landing * T] * 2, before=[True, False]), None
        before, after = (
            {name: getattr(before, name)[k] for name in before.__dataclass_fields__} for k in (0, 1)
        )
        assert (before["step"], after["step"]) == (landing - 1, landing)
        for one in ("q", "base_position", "base_quaternion", "sole"):
            assert after[one] == pytest.approx(before[one], abs=1e-12), one
        jump = step.impact.rate_after - step.rate_before
        expected = jump if landing % 2 else robot.mirror @ jump
        assert (after["dq"] - before["dq"])[moving] == pytest.approx(expected, abs=1e-8)
        assert before["contact"].tolist() == after["contact"].tolist()[::-1]
    assert np.abs(jump).max() > 1.0


def test_between_impacts_the_base_moves_as_its_twist_says(whole_body):
    trajectory = whole_body[1]
    T = trajectory.step_duration
    times = T * np.array([0.1, 0.45, 0.9, 1.2, 1.7])

    def differences(h):
        ahead, behind, here = (trajectory.at(times + s) for s in (h, -h, 0.0))
        twist = [
            pin.log6(pin.XYZQUATToSE3(b[:7]).actInv(pin.XYZQUATToSE3(a[:7]))).vector / (2.0 * h)
            for a, b in zip(ahead.configuration, behind.configuration, strict=True)
        ]
        change = (ahead.base_twist - behind.base_twist) / (2.0 * h)
        rate = (ahead.q - behind.q) / (2.0 * h)
        return [
            np.abs(found - exact).max()
            for found, exact in (
                (np.array(twist), here.base_twist),
                (change, here.base_acceleration),
                (rate, here.dq),
            )
        ]

    coarse, fine = differences(2e-3), differences(1e-3)
    for large, small in zip(coarse, fine, strict=True):
        assert 3.0 < large / small < 5.0  # central differences: of second order
        assert small < 0.05


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.99, 1.0, 1.6])
def test_inverse_dynamics_of_the_file_asks_for_the_contact_alone(whole_body, phase):
    robot, trajectory = whole_body
    model = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    at = trajectory.at(phase * trajectory.step_duration)
    ids = [model.getJointId(name) for name in trajectory.joint_names]
    assert len(ids) == model.njoints - 2 == 23
    q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    q[:7], v[:6], a[:6] = at.configuration[0, :7], at.base_twist[0], at.base_acceleration[0]
    columns = [model.joints[j].idx_v for j in ids]
    q[[model.joints[j].idx_q for j in ids]] = at.q[0]
    v[columns], a[columns] = at.dq[0], at.ddq[0]
    data = model.createData()
    tau = pin.rnea(model, data, q, v, a)
    size = np.abs(tau).max()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    for foot, name in enumerate(robot.multibody.sole_names):
        frame = model.getFrameId(name)
        tau -= pin.getFrameJacobian(model, data, frame, pin.LOCAL).T @ at.wrench[0, foot]
        placed = data.oMf[frame].homogeneous
        assert at.sole[0, foot] == pytest.approx(placed, abs=1e-9)
    assert np.abs(tau[:6]).max() < 1e-9 * size  # nothing holds the base
    assert relative_error(at.torque[0], tau[columns]) < 1e-9
    standing = model.getFrameId(robot.multibody.sole_names[at.contact[0].argmax()])
    assert np.abs(pin.getFrameVelocity(model, data, standing).vector).max() < 1e-9


def test_joints_that_do_not_move_stand_where_they_were_locked(whole_body):
    robot, trajectory = whole_body
    at = trajectory.at(trajectory.times(rate=20.0))
    still = np.setdiff1d(np.arange(23), robot.multibody.moving)
    assert len(still) == 11
    assert np.ptp(at.q[:, still], axis=0).max() == np.abs(at.dq[:, still]).max() == 0.0
    assert np.abs(at.torque[:, still]).max() > 0.1  # what holds an arm that swings with the trunk


@pytest.mark.parametrize(
    "name", ["mjcf_damping_stiffness.xml", "mjcf_gravity.xml", "mjcf_gravcomp.xml"]
)
def test_passive_joints_gravity_and_carried_weight_count(name):
    robot = Robot.from_urdf((CASES / name).read_text())
    problem = WalkProblem(robot, preset_task("standard"))
    x = first_guess(problem)
    step, trajectory = problem.step(x), trajectory_of(problem, x)
    times = problem.grid.instants * step.duration
    at = trajectory.at(times, before=times > 0.9 * step.duration)
    moving = robot.multibody.moving
    assert relative_error(at.torque[:, moving], step.read(quantities.TORQUE)) < 1e-12
    assert relative_error(at.wrench[:, 0], step.read(quantities.WRENCH)) < 1e-12
    own = mujoco.MjModel.from_xml_string((CASES / name).read_text())
    assert robot.multibody.mass.sum() == pytest.approx(own.body_mass.sum(), rel=1e-12)


def test_several_phases_are_one_motion(trajectory):
    """A spline cut in two, as two phases in which the same foot stands, is the same walk."""
    whole = trajectory.phases[0]
    cut = 0.4 * whole.duration
    parts = []
    for start, end in ((0.0, cut), (cut, whole.duration)):
        inside = whole.knots[(whole.knots > start + 1e-9) & (whole.knots < end - 1e-9)]
        knots = np.concatenate([[start], inside, [end]])
        q, dq, _ = whole.motion(knots)
        parts.append(TrajectoryPhase(0, knots - start, np.vstack([q, dq[[0, -1]]])))
    both = replace(trajectory, phases=tuple(parts))
    times = np.linspace(0.0, 3.0 * trajectory.step_duration, 50)[1:-1]
    one, two = trajectory.at(times), both.at(times)
    assert set(two.phase.tolist()) == {0, 1}
    assert both.step_duration == pytest.approx(trajectory.step_duration, rel=1e-15)
    for name in ("q", "dq", "ddq", "torque", "wrench", "base_position", "base_twist"):
        assert relative_error(getattr(two, name), getattr(one, name)) < 1e-10, name


def test_a_step_that_is_followed_by_itself_moves_without_exchange(trajectory):
    """Both steps of a stride as phases of one that closes by itself: no exchange is needed."""
    exchange, phase = trajectory.exchange, trajectory.phases[0]
    other = TrajectoryPhase(1, phase.knots, phase.coefficients @ exchange.T)
    full = Trajectory(trajectory.body, (phase, other), None)
    assert full.period == pytest.approx(trajectory.period)
    times = np.linspace(0.0, 5.0 * trajectory.step_duration, 77)[1:-1]
    one, two = trajectory.at(times), full.at(times)
    for name in ("q", "dq", "torque", "wrench", "base_position", "base_quaternion", "contact"):
        here, there = (np.asarray(getattr(at, name), dtype=float) for at in (one, two))
        assert there == pytest.approx(here, abs=1e-9 * max(1.0, np.abs(here).max())), name


def test_the_end_of_a_step_is_found_however_it_was_computed(trajectory):
    T = trajectory.step_duration
    for count in range(1, 400):
        for time in (count * T, sum([T] * count), count / (1.0 / T)):
            assert trajectory.at(time).step[0] == count
            assert trajectory.at(time, before=True).step[0] == count - 1


def test_coefficients_come_back_from_samples():
    rng = np.random.default_rng(4)
    knots = np.array([0.0, 0.1, 0.25, 0.6])
    coefficients = rng.normal(0.0, 1.0, (6, 3))
    times = 0.6 * uniform_grid(31).instants
    motion = TrajectoryPhase(0, knots, coefficients).motion(times)
    assert relative_error(fitted_coefficients(knots, times, motion), coefficients) < 1e-12


def test_a_gait_without_coefficients_and_robot_finds_them():
    gait, bare = sample_gait(), bare_gait()
    at = gait.trajectory.at(gait.time, before=gait.time > 0.2)
    moving = gait.trajectory.body.moving
    assert relative_error(at.q[:, moving], gait.q) < 1e-12
    assert relative_error(at.torque[:, moving], gait.torque) < 1e-9
    assert relative_error(at.wrench[:, 0], gait.ground_wrench) < 1e-9
    assert relative_error(at.pressure[:, 0], gait.cop) < 1e-9
    assert relative_error(bare.trajectory.at(0.1).torque, gait.trajectory.at(0.1).torque) < 1e-9


def test_times_are_those_of_a_clock(trajectory):
    times = trajectory.times(rate=50.0, strides=2.0)
    assert times == pytest.approx(np.arange(80) / 50.0)
    assert trajectory.at(0.1).time.shape == (1,)
    assert trajectory.at([]).torque.shape == (0, 12)


def test_what_makes_no_sense_is_refused(trajectory):
    for times in ([0.0, np.nan], np.zeros((2, 2)), "0.1", [0.1, None], 1j, 1e300, 10**400):
        with pytest.raises(InputError, match=r"numbers up to 1e\+09 s, shape \(N,\)"):
            trajectory.at(times)
    with pytest.raises(InputError, match=r"`before` has shape \(3,\); give one, or one for each"):
        trajectory.at([0.1, 0.2], before=[True] * 3)
    for rate in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="both must be finite numbers above 0"):
            trajectory.times(rate=rate)
    with pytest.raises(InputError, match="rate is '50'; give a number"):
        trajectory.times(rate="50")
    with pytest.raises(InputError, match="instants"):
        trajectory.times(rate=1e9)
    gait = sample_gait()
    with pytest.raises(RobotError, match="no joint 'wrist'"):
        _ = replace(gait, joint_names=("wrist", *gait.joint_names[1:])).trajectory
    with pytest.raises(RobotError, match="hoof"):
        _ = replace(gait, stance_sole="hoof").trajectory
    with pytest.raises(RobotError, match="the gait's URDF cannot be read"):
        _ = replace(gait, urdf="<robot").trajectory
    moved = replace(gait, multibody=biped().multibody, joint_names=gait.joint_names[::-1])
    with pytest.raises(InputError, match="the robot that it was designed for"):
        _ = moved.trajectory
