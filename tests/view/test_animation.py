from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from sample_gait import JOINT_NAMES, exchange, sample_gait
from scipy.integrate import trapezoid

from gaitopt.errors import InputError, RobotError
from gaitopt.model.robot import Robot
from gaitopt.view.animation import build_scene, frames, hip_height, pressure
from gaitopt.view.viewer import Node, RecordingWindow, umsgpack

COUNT = 31


@pytest.fixture(scope="module")
def model():
    """The robot as Pinocchio reads its file, not as the gait has it."""
    return pin.buildModelFromXML(sample_gait().urdf, pin.JointModelFreeFlyer())


@pytest.fixture(scope="module")
def samples():
    return frames(sample_gait(), 4)


def configuration(model, samples, k):
    q = pin.neutral(model)
    q[:7] = samples.configuration[k, :7]
    for name, angle in zip(sample_gait().trajectory.joint_names, samples.q[k], strict=True):
        q[model.joints[model.getJointId(name)].idx_q] = angle
    return q


def standing(samples, k):
    """Name and placement of the standing sole."""
    foot = int(samples.contact[k].argmax())
    return ("right_sole", "left_sole")[foot], pin.SE3(samples.sole[k, foot])


def columns(values):
    return values[:, sample_gait().trajectory.body.moving]


def sole(model, q, name):
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId(name)].copy()


def corners(placement):
    local = [[0, 0.068, 0], [0, -0.068, 0], [-0.214, 0.068, 0], [-0.214, -0.068, 0]]
    return np.array([placement.act(np.array(c, dtype=float)) for c in local])


def test_the_swing_foot_goes_where_the_reference_solution_says(model, samples):
    gait = sample_gait()
    for k in range(COUNT):
        reached = corners(sole(model, configuration(model, samples, k), "left_sole"))
        assert reached == pytest.approx(gait.swing_sole[k], abs=1e-12)


def test_the_mirror_of_the_sample_is_the_one_found_in_the_robot():
    robot = Robot.from_urdf(sample_gait().urdf)
    assert robot.joint_names == JOINT_NAMES
    assert np.array_equal(robot.mirror, exchange())


def test_feet_take_turns_and_the_robot_advances(samples):
    firsts = range(0, 4 * COUNT, COUNT)
    names = [standing(samples, k)[0] for k in firsts]
    assert names == ["right_sole", "left_sole", "right_sole", "left_sole"]
    places = np.array([standing(samples, k)[1].translation for k in firsts])
    assert places[:, 0] == pytest.approx([0.0, 0.4, 0.8, 1.2], abs=1e-12)
    spacing = sample_gait().swing_sole[0, :, 1].mean()
    assert places[:, 1] == pytest.approx([0.0, spacing, 0.0, spacing], abs=1e-12)
    assert samples.base_position[-1, 0] - samples.base_position[0, 0] == pytest.approx(
        4 * 0.4, rel=1e-12
    )


def test_the_standing_foot_stays_flat_where_it_landed(model, samples):
    for k in range(0, 4 * COUNT, 7):
        name, landed = standing(samples, COUNT * int(samples.step[k]))
        placed = sole(model, configuration(model, samples, k), name)
        assert placed.homogeneous == pytest.approx(landed.homogeneous, abs=1e-12)
        assert placed.rotation == pytest.approx(np.eye(3), abs=1e-12)


def test_an_odd_step_is_the_mirror_image_of_the_even_one(model, samples):
    reflect = np.diag([1.0, -1.0, 1.0])
    y = standing(samples, COUNT)[1].translation[1]
    for k in range(0, COUNT, 5):
        first = corners(sole(model, configuration(model, samples, k), "left_sole"))
        second = corners(sole(model, configuration(model, samples, COUNT + k), "right_sole"))
        mirrored = (first @ reflect)[[1, 0, 3, 2]] + [0.4, y, 0.0]
        assert second == pytest.approx(mirrored, abs=1e-12)


def test_postures_are_continuous_over_the_impact_and_rates_jump_by_it(samples):
    gait = sample_gait()
    jump = gait.rate_after - gait.rate_before
    assert np.abs(jump).max() > 1.0
    for step in (1, 2, 3):
        before, after = step * COUNT - 1, step * COUNT
        assert samples.time[before] == samples.time[after]
        assert samples.configuration[after] == pytest.approx(
            samples.configuration[before], abs=1e-12
        )
        expected = jump if step % 2 else gait.mirror @ jump
        assert columns(samples.dq)[after] - columns(samples.dq)[before] == pytest.approx(
            expected, abs=1e-8
        )


def test_within_a_step_joints_move_as_their_rates_say(samples):
    for rows in (slice(0, COUNT), slice(COUNT, 2 * COUNT)):
        moved = np.diff(columns(samples.q)[rows], axis=0)
        mean = (columns(samples.dq)[rows][1:] + columns(samples.dq)[rows][:-1]) / 2.0
        # trapezoid rule: its error is the third derivative times h^3 / 12
        assert moved == pytest.approx(mean * 0.4 / 30, abs=2e-3)


def test_pressure_stays_under_the_standing_foot_and_forces_are_mirrored(samples):
    gait, pressed, force = sample_gait(), pressure(samples), samples.force.sum(axis=1)
    for k in range(4 * COUNT):
        x, y, z = standing(samples, k)[1].actInv(pressed[k])
        assert -0.214 <= x <= 0.0
        assert abs(y) <= 0.068
        assert abs(z) < 1e-9
    assert force[:COUNT] == pytest.approx(gait.ground_wrench[:, :3], abs=1e-9)
    turned = gait.ground_wrench[:, :3] * [1.0, -1.0, 1.0]
    assert force[COUNT : 2 * COUNT] == pytest.approx(turned, abs=1e-9)


def test_the_mean_force_and_the_impulse_carry_the_weight():
    gait = sample_gait()
    force = trapezoid(gait.ground_wrench[:, 2], gait.time) + gait.impulse[2]
    assert force == pytest.approx(gait.number("mass") * 9.81 * 0.4, rel=5e-3)


@pytest.mark.parametrize(("rise", "ahead"), [(0.17, -1.0), (-0.17, 1.0)])
def test_the_camera_sees_the_feet_on_stairs(rise, ahead):
    """From where stairs lead to, their edges hide what stands behind them."""
    outline = [[-0.2, 0.0], [0.1, 0.0], [0.1, rise]]
    ground = {"words": "stairs", "rise": rise, "outline": outline}
    gait, window = sample_gait(), RecordingWindow()
    build_scene(Node(window), replace(gait, meta={**gait.meta, "ground": ground}), 1)
    sent = [umsgpack.unpackb(command) for command in window.commands]
    ((x, _, _),) = [c["value"] for c in sent if c.get("property") == "position"]
    assert np.sign(x) == ahead


def test_knees_that_bend_make_no_small_robot(samples):
    """The camera would stand so near that it distorts what it sees."""
    body = sample_gait().trajectory.body
    tall = hip_height(body, samples)
    assert tall > 0.6
    low = samples.configuration[:1].copy()
    low[:, 2] -= 0.4
    assert hip_height(body, SimpleNamespace(configuration=low)) == pytest.approx(0.6)


def test_what_cannot_walk_is_refused():
    gait = sample_gait()
    with pytest.raises(InputError, match="0 steps cannot be shown"):
        frames(gait, 0)
    with pytest.raises(RobotError, match="cannot be read"):
        frames(replace(gait, urdf="<robot"))
    with pytest.raises(RobotError, match="no joint 'wrist'"):
        frames(replace(gait, joint_names=("wrist", *gait.joint_names[1:])))
    with pytest.raises(RobotError, match="'hoof'"):
        frames(replace(gait, stance_sole="hoof"))
