"""Motions read back by the programs they are for, against what those compute themselves."""

import io
import json
from dataclasses import replace

import mujoco
import numpy as np
import pandas
import pinocchio as pin
import pytest
import yaml
from example_robots import needs_example_robots
from first_walks import first_walk
from mujoco_replay import compiled, joint_order, weigh_as_designed
from numerics import relative_error
from places import CASES
from sample_gait import sample_gait

import gaitopt
from gaitopt.errors import InputError
from gaitopt.mechanics.spatial import upright
from gaitopt.model.robot import Robot
from gaitopt.motions.export import FORMATS
from gaitopt.motions.motion import G1_JOINTS, motion


def exported(gait, folder, name, **asked):
    return gaitopt.export(gait, folder / f"m{FORMATS[name].suffix}", format=name, **asked)


def arrays(path):
    with np.load(path, allow_pickle=False) as content:
        return dict(content)


def on_slope(gait, angle, across=0.0):
    """The same motion on ground that rises ahead and to the left: forces are others."""
    size = np.linalg.norm(gait.trajectory.body.gravity)
    down = np.array([np.sin(angle), np.sin(across), 0.0])
    down[2] = np.sqrt(1.0 - down @ down)
    return replace(gait, multibody=replace(gait.trajectory.body, gravity=-size * down))


def follows(model, data, content):
    """Yield the instants of a MuJoCo motion, the model's state set to each."""
    for k in range(len(content["time"])):
        data.qpos[:], data.qvel[:] = content["qpos"][k], content["qvel"][k]
        data.qacc[:] = content["qacc"][k]
        mujoco.mj_inverse(model, data)
        yield k


def assert_poses_are_mujocos(gait, folder):
    model = compiled(gait)
    data = mujoco.MjData(model)
    motion_file = arrays(exported(gait, folder, "motion", rate=20.0, strides=2))
    content = arrays(exported(gait, folder, "mujoco", rate=20.0, strides=2))
    assert content["joint_names"].tolist() == joint_order(model)
    assert motion_file["joint_names"].tolist() == joint_order(model)
    bodies = [model.body(name).id for name in motion_file["body_names"].tolist()]
    assert len(bodies) == len(motion_file["joint_names"]) + 1
    assert bodies == sorted(bodies)
    for k in follows(model, data, content):
        assert motion_file["body_pos_w"][k] == pytest.approx(data.xpos[bodies], abs=1e-6)
        inner = np.sum(motion_file["body_quat_w"][k] * data.xquat[bodies], axis=1)
        assert np.abs(inner) == pytest.approx(1.0, abs=1e-6)
        turned = np.sign(inner)[:, None] * data.xquat[bodies]
        assert motion_file["body_quat_w"][k] == pytest.approx(turned, abs=1e-6)
        speed = np.zeros(6)
        for column, body in enumerate(bodies):
            kind = mujoco.mjtObj.mjOBJ_XBODY
            mujoco.mj_objectVelocity(model, data, kind, body, speed, 0)
            found = [motion_file[f"body_{n}_vel_w"][k, column] for n in ("ang", "lin")]
            assert np.concatenate(found) == pytest.approx(speed, abs=5e-6)


def assert_torques_are_mujocos(gait, folder):
    """Newton and Euler with MuJoCo: torques, and contacts that leave nothing at the base."""
    model = compiled(gait)
    sampled = motion(gait, 20.0, 2.0, "mujoco")
    weigh_as_designed(model, sampled)
    data = mujoco.MjData(model)
    content = arrays(exported(gait, folder, "mujoco", rate=20.0, strides=2))
    body = gait.trajectory.body
    for k in follows(model, data, content):
        force = data.qfrc_inverse.copy()
        for foot in range(2):
            row = model.body(sampled.body_names[1 + sampled.rows.index(body.sole_joint[foot])]).id
            J = np.zeros((6, model.nv))
            mujoco.mj_jac(model, data, J[:3], J[3:], sampled.samples.sole[k, foot, :3, 3], row)
            force -= J.T @ content["foot_wrench"][k, foot]
        size = np.abs(data.qfrc_inverse).max()
        assert np.abs(force[:6]).max() < 1e-6 * size
        assert np.abs(force[6:] - content["torque"][k]).max() < 1e-6 * size
    assert content["foot_contact"].any(axis=0).all()


def test_bodies_are_where_mujoco_has_them(armed, tmp_path):
    assert_poses_are_mujocos(armed, tmp_path)


def test_mujocos_inverse_dynamics_gives_the_torques(armed, tmp_path):
    assert_torques_are_mujocos(armed, tmp_path)


@pytest.mark.parametrize(
    "name", ["base_mini", "mjcf_damping_stiffness", "mjcf_gravity", "mjcf_joint_ref", "mjcf_frame"]
)
def test_robots_of_mjcf_files_move_as_in_mujoco(tmp_path, name):
    text = (CASES / f"{name}.xml").read_text()
    gait = first_walk(Robot.from_urdf(text), speed=0.3)
    assert_poses_are_mujocos(gait, tmp_path)
    body = gait.trajectory.body  # Coulomb friction is a constraint of MuJoCo's, which are off
    smooth = replace(gait, multibody=replace(body, friction=np.zeros_like(body.friction)))
    assert_torques_are_mujocos(smooth, tmp_path)


@needs_example_robots
def test_g1_is_where_mujoco_has_it_with_its_torques(g1, tmp_path):
    assert_poses_are_mujocos(g1, tmp_path)
    assert_torques_are_mujocos(g1, tmp_path)


@pytest.mark.parametrize(("ahead", "across"), [(0.1, 0.0), (-0.2, 0.0), (0.07, -0.12)])
def test_on_a_slope_the_world_stands_upright(armed, tmp_path, ahead, across):
    sloped = on_slope(armed, ahead, across)
    assert_torques_are_mujocos(sloped, tmp_path)  # with gravity along its z
    level, there = motion(armed, 20.0, 2.0), motion(sloped, 20.0, 2.0)
    R = upright(sloped.trajectory.body.gravity)
    assert R @ sloped.trajectory.body.gravity == pytest.approx([0.0, 0.0, -9.81], abs=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-12)
    travel = there.samples.base_position[-1] - there.samples.base_position[0]
    assert travel == pytest.approx(
        R @ (level.samples.base_position[-1] - level.samples.base_position[0]), abs=1e-12
    )
    assert np.sign(travel[2]) == np.sign(ahead)  # uphill


@pytest.mark.parametrize(
    "asked",
    [
        {"slope": 0.1},
        {"slope": -0.15},
        {"toe_off": 0.7, "boundary": "lifted"},
        {"stairs": 0.1},
        {"stairs": -0.08},
    ],
)
def test_designed_slopes_stairs_and_toe_off_have_mujocos_torques(armed, tmp_path, asked):
    gait = first_walk(Robot.from_urdf(armed.urdf), speed=0.6, **asked)
    gait = gaitopt.load_gait(gaitopt.save_gait(gait, tmp_path / "gait.npz"))
    assert_torques_are_mujocos(gait, tmp_path)
    sampled = motion(gait, 50.0, 4.0)
    travel = sampled.samples.base_position[-1] - sampled.samples.base_position[0]
    rise = asked.get("stairs", gait.step_length * np.sin(asked.get("slope", 0.0)))
    steps = sampled.samples.time[-1] / gait.trajectory.step_duration
    assert travel[2] / steps == pytest.approx(rise, abs=0.02)
    assert sampled.foot_wrench[..., 2].min() > -1e-9


def test_pinocchios_inverse_dynamics_gives_the_torques(armed, tmp_path):
    model = pin.buildModelFromXML(armed.urdf, pin.JointModelFreeFlyer())
    data = model.createData()
    content = arrays(exported(armed, tmp_path, "pinocchio", rate=20.0, strides=2))
    assert content["joint_names"].tolist() == list(model.names[2:])
    assert content["q"].shape == (len(content["time"]), model.nq)
    frames = [model.getFrameId(name) for name in content["foot_names"].tolist()]
    for k, (q, v, a) in enumerate(zip(content["q"], content["v"], content["a"], strict=True)):
        tau = pin.rnea(model, data, q, v, a)
        size = np.abs(tau).max()
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        for frame, wrench in zip(frames, content["foot_wrench"][k], strict=True):
            tau = tau - pin.getFrameJacobian(model, data, frame, pin.LOCAL).T @ wrench
        assert np.abs(tau[:6]).max() < 1e-6 * size
        assert np.abs(tau[6:] - content["tau"][k]).max() < 1e-6 * size


def test_the_rate_changes_nothing_but_the_instants(armed, tmp_path):
    coarse = arrays(exported(armed, tmp_path, "mujoco", rate=50.0, strides=2))
    fine = arrays(exported(armed, tmp_path, "mujoco", rate=1000.0, strides=2))
    assert len(fine["time"]) == pytest.approx(20 * len(coarse["time"]), abs=20)
    for name in ("time", "qpos", "qvel", "qacc", "torque", "foot_wrench"):
        assert relative_error(coarse[name], fine[name][::20]) < 1e-9, name


def test_velocities_are_those_of_the_positions(armed, tmp_path):
    content = arrays(exported(armed, tmp_path, "mujoco", rate=1000.0))
    same = np.diff(content["foot_contact"][:, 0].astype(int)) == 0  # no impact between
    h = 1e-3
    linear = np.diff(content["qpos"][:, :3], axis=0) / h
    middle = (content["qvel"][1:] + content["qvel"][:-1]) / 2.0
    assert np.abs(linear - middle[:, :3])[same].max() < 1e-4
    change = np.diff(content["qvel"], axis=0) / h
    mean = (content["qacc"][1:] + content["qacc"][:-1]) / 2.0
    assert np.abs(change - mean)[same].max() < 1e-3 * np.abs(mean).max()


def test_a_tracker_reads_every_array_without_jumps(armed, tmp_path):
    content = arrays(exported(armed, tmp_path, "motion", strides=3))
    assert content["fps"].tolist() == [50]
    T, B = len(content["joint_pos"]), len(content["body_names"])
    assert content["body_names"][0] == armed.trajectory.body.base
    assert content["body_quat_w"].shape == (T, B, 4)
    assert {v.dtype for k, v in content.items() if v.dtype.kind == "f"} == {np.dtype("f4")}
    inner = np.sum(content["body_quat_w"][1:] * content["body_quat_w"][:-1], axis=-1)
    assert inner.min() > 0.9  # no sign flips at 50 Hz
    assert int(np.ceil(3 * armed.trajectory.period * 50.0 - 1e-6)) == T


def test_pandas_reads_the_table(armed, tmp_path):
    table = pandas.read_csv(exported(armed, tmp_path, "csv", strides=2.5))
    sampled = motion(armed, 100.0, 2.5)
    assert (np.diff(table["time [s]"]) > 0.0).all()
    assert table["left_knee q [rad]"].to_numpy() == pytest.approx(
        sampled.samples.q[:, sampled.joint_names.index("left_knee")], abs=1e-9
    )
    assert set(table["step"]) == {0, 1, 2, 3, 4}
    assert table["phase"].between(0.0, 1.0).all()
    base = table[["base_qx", "base_qy", "base_qz", "base_qw"]].to_numpy()
    assert np.linalg.norm(base, axis=1) == pytest.approx(1.0, abs=1e-9)
    weight = 9.81 * armed.trajectory.body.mass.sum()
    lift = sum(table[f"{foot} force_z [N]"] for foot in sampled.foot_names)
    assert 0.5 * weight < lift.mean() < 1.5 * weight


@needs_example_robots
def test_g1s_table_has_36_columns_in_unitrees_order(g1, tmp_path):
    table = np.loadtxt(exported(g1, tmp_path, "g1-csv"), delimiter=",")
    sampled = motion(g1, 30.0, 1.0)
    assert table.shape == (len(sampled.samples.time), 36)
    assert table[:, :3] == pytest.approx(sampled.samples.base_position, abs=1e-8)
    assert table[:, 3:7] == pytest.approx(sampled.samples.base_quaternion, abs=1e-8)
    knee = sampled.joint_names.index("right_knee_joint")
    assert table[:, 7 + G1_JOINTS.index("right_knee_joint")] == pytest.approx(
        sampled.samples.q[:, knee], abs=1e-8
    )
    assert np.ptp(table[:, 7 + 3]) > 0.1


def bezier(points, share):
    """De Casteljau's algorithm."""
    points = np.array(points)
    while len(points) > 1:
        points = (1.0 - share) * points[:-1] + share * points[1:]
    return points[0]


def test_bezier_curves_are_the_walk(armed, tmp_path):
    content = yaml.safe_load(exported(armed, tmp_path, "bezier").read_text())
    trajectory, n = armed.trajectory, len(content["joint_names"])
    assert content["vd_x"] == pytest.approx(armed.speed, rel=1e-9)
    assert content["vd_y"] == pytest.approx(0.0, abs=1e-9)
    T = trajectory.step_duration
    assert content["largest_error"] < 0.03
    for step, side in enumerate(("RightSS", "LeftSS")):
        assert armed.stance_sole == "right_sole"
        joints = np.reshape(content[side]["coeff_jt"], (8, n))
        base = np.reshape(content[side]["coeff_b"], (8, 6))
        assert content[side]["step_dur"] == pytest.approx(T, rel=1e-12)
        for share, slack in ((0.0, 1e-9), (0.4, 0.03), (0.8, 0.03), (1.0, 1e-9)):
            at = trajectory.at((step + share) * T, before=share == 1.0)
            assert bezier(joints, share) == pytest.approx(at.q[0], abs=slack)
            place = bezier(base, share)
            stance = at.sole[0, step, :3, 3]
            assert place[:3] == pytest.approx(at.base_position[0] - stance, abs=slack)
            turn = pin.rpy.rpyToMatrix(place[3:])
            quaternion = pin.Quaternion(*at.base_quaternion[0][[3, 0, 1, 2]])
            assert turn == pytest.approx(quaternion.toRotationMatrix(), abs=slack)
        start = trajectory.at(step * T)
        assert 7.0 * (joints[1] - joints[0]) / T == pytest.approx(start.dq[0], abs=1e-9)
        h = 1e-6
        ahead = trajectory.at(step * T + h).base_position[0] - start.base_position[0]
        assert 7.0 * (base[1] - base[0])[:3] / T == pytest.approx(ahead / h, abs=1e-4)
        h = 1e-4
        rpy = [bezier(base, share)[3:] for share in (0.0, h)]
        turns = [pin.rpy.rpyToMatrix(one) for one in rpy]
        own = pin.log3(turns[0].T @ turns[1]) / (h * T)
        assert own == pytest.approx(start.base_twist[0, 3:], abs=1e-2)
        assert content[side]["step_len"][0] == pytest.approx(armed.step_length, abs=1e-9)
        assert np.sign(content[side]["step_len"][1]) == (1 if side == "RightSS" else -1)


def test_json_has_what_the_other_forms_have(armed, tmp_path):
    content = json.loads(exported(armed, tmp_path, "json", rate=40.0, strides=2).read_text())
    sampled = motion(armed, 40.0, 2.0)
    for name in ("q", "dq", "ddq", "torque"):
        assert relative_error(content[name], getattr(sampled.samples, name)) < 1e-10, name
    assert relative_error(content["foot_wrench"], sampled.foot_wrench) < 1e-10
    assert content["foot_contact"] == sampled.samples.contact.tolist()
    assert content["joint_names"] == list(armed.trajectory.joint_names)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"format": "bvh"}, "no format of motions is named 'bvh'; choose motion, mujoco"),
        ({"rate": 50.0}, "rate: only motions of a named format"),
        ({"format": "motion", "rate": 0.0}, "a motion has 0 Hz; give a number above 0, to 100000"),
        ({"format": "motion", "rate": float("nan")}, "a motion has nan Hz"),
        ({"format": "motion", "rate": 1e6}, "a motion has 1e.06 Hz"),
        ({"format": "motion", "strides": -1.0}, "a motion has -1 strides"),
        (
            {"format": "motion", "rate": 1.0, "strides": 0.5},
            "a motion of 0.4 s at 1 Hz has one instant; give 5 Hz or more, or more strides",
        ),
        ({"format": "motion", "strides": 1e5}, "strides; give a number above 0, to 10000"),
        ({"format": "mujoco", "rate": 1e5, "strides": 10.0}, "instants of a motion are too many"),
        (
            {"format": "mujoco", "joints": "drake"},
            "no order of joints is named 'drake'; choose gait",
        ),
        ({"format": "mujoco", "joints": "left_knee,tail"}, "the order has 'tail', which"),
        ({"format": "mujoco", "joints": "left_knee,left_knee"}, "has 'left_knee' twice"),
        ({"format": "mujoco", "joints": "left_knee"}, "the order lacks .* which the gait moves"),
        ({"format": "mujoco", "joints": "g1"}, "the order 'g1' has 'left_hip_pitch_joint'"),
        ({"format": "mujoco", "both_legs": True}, "both legs are in every motion"),
        ({"format": "csv"}, "files of format 'csv' end in .csv"),
    ],
)
def test_what_cannot_be_exported_is_refused(tmp_path, asked, message):
    with pytest.raises(InputError, match=message):
        gaitopt.export(sample_gait(), tmp_path / "m.npz", **asked)
    assert not list(tmp_path.iterdir())


def test_curves_have_no_rate(tmp_path):
    with pytest.raises(InputError, match="has curves, not samples"):
        gaitopt.export(sample_gait(), tmp_path / "m.yaml", format="bezier", rate=10.0)


def test_still_joints_may_be_left_out(armed, tmp_path):
    names = list(armed.joint_names)[::-1]
    content = arrays(exported(armed, tmp_path, "motion", joints=names))
    assert content["joint_names"].tolist() == names
    assert len(content["body_names"]) == 1 + len(names)
    whole = arrays(exported(armed, tmp_path, "motion"))
    column = whole["joint_names"].tolist().index("left_knee")
    assert np.array_equal(
        content["joint_pos"][:, names.index("left_knee")], whole["joint_pos"][:, column]
    )
    body = whole["body_names"].tolist().index(content["body_names"][3])
    assert np.array_equal(content["body_pos_w"][:, 3], whole["body_pos_w"][:, body])


def test_a_whole_file_is_read_from_memory(armed, tmp_path):
    path = exported(armed, tmp_path, "motion")
    assert set(np.load(io.BytesIO(path.read_bytes()))) == set(arrays(path))


def test_odd_names_stay_what_they_are(tmp_path):
    gait = sample_gait()
    names = {"left_knee": 'left, "knee"', "right_knee": "right\u0085knee: é"}
    body = replace(
        gait.trajectory.body,
        joint_names=tuple(names.get(n, n) for n in gait.trajectory.joint_names),
    )
    odd = replace(
        gait, multibody=body, joint_names=tuple(names.get(n, n) for n in gait.joint_names)
    )
    table = pandas.read_csv(exported(odd, tmp_path, "csv"))
    for name in names.values():
        assert f"{name} q [rad]" in table.columns
    curves = yaml.safe_load(exported(odd, tmp_path, "bezier").read_text())
    assert curves["joint_names"] == list(body.joint_names)
    assert json.loads(exported(odd, tmp_path, "json").read_text())["joint_names"] == (
        list(body.joint_names)
    )
