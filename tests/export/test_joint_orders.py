"""Orders of joints and bodies, and frames of bodies, against engines' own."""

import mujoco
import numpy as np
import pytest
from example_robots import needs_example_robots
from first_walks import first_walk
from places import CASES

from gaitopt.errors import InputError
from gaitopt.model.robot import Robot
from gaitopt.motions.motion import G1_JOINTS, RobotOrder, motion

ISAAC = (
    "left_hip_pitch", "right_hip_pitch", "waist_yaw", "left_hip_roll", "right_hip_roll",
    "waist_roll", "left_hip_yaw", "right_hip_yaw", "waist_pitch", "left_knee", "right_knee",
    "left_shoulder_pitch", "right_shoulder_pitch", "left_ankle_pitch", "right_ankle_pitch",
    "left_shoulder_roll", "right_shoulder_roll", "left_ankle_roll", "right_ankle_roll",
    "left_shoulder_yaw", "right_shoulder_yaw", "left_elbow", "right_elbow", "left_wrist_roll",
    "right_wrist_roll", "left_wrist_pitch", "right_wrist_pitch", "left_wrist_yaw",
    "right_wrist_yaw",
)  # fmt: skip
"""Joints of the G1 as Isaac Lab lists them, in its public tasks for the robot."""


@needs_example_robots
def test_orders_of_g1_are_those_of_the_engines(g1):
    order = RobotOrder(g1.trajectory.body, g1.urdf)
    names = g1.trajectory.joint_names
    found = {name: [names[row] for row in order.rows(name)] for name in ("isaac", "mujoco", "g1")}
    assert found["isaac"] == [f"{name}_joint" for name in ISAAC]
    assert found["mujoco"] == found["g1"] == list(G1_JOINTS)
    assert len(G1_JOINTS) == 29


@needs_example_robots
def test_bodies_of_isaac_go_with_its_joints(g1):
    sampled = motion(g1, 10.0, 1.0, "isaac")
    assert sampled.body_names[:4] == (
        "pelvis", "left_hip_pitch_link", "right_hip_pitch_link", "waist_yaw_link",
    )  # fmt: skip
    assert sampled.body_names[12] == "left_shoulder_pitch_link"
    plain = motion(g1, 10.0, 1.0, "mujoco")
    there = [plain.body_names.index(name) for name in sampled.body_names]
    assert np.array_equal(sampled.body_motion.position, plain.body_motion.position[:, there])


def test_brothers_stand_in_the_order_of_the_file():
    """Pinocchio and Isaac sort a URDF's by name, MuJoCo does not, nor Isaac those of MJCF."""
    text = (
        '<robot name="r">'
        '<joint name="b" type="revolute"><parent link="p"/><child link="c"/></joint>'
        '<joint name="f" type="fixed"><parent link="p"/><child link="m"/></joint>'
        '<joint name="c" type="revolute"><parent link="c"/><child link="d"/></joint>'
        '<joint name="a" type="revolute"><parent link="m"/><child link="e"/></joint></robot>'
    )

    class Body:
        name, base = "r", "p"
        joint_names, driven_names = ("a", "b", "c"), ("a", "b", "c")
        parent = (-1, -1, 1)

    order = RobotOrder(Body(), text)
    assert order.rows("gait") == (0, 1, 2)
    assert order.rows("mujoco") == (1, 2, 0)
    assert order.rows("isaac") == (0, 1, 2)
    assert order.link_names(order.bodies((1, 2, 0))) == ("p", "c", "d", "e")
    nested = (
        '<mujoco><worldbody><body name="p"><freejoint/><body name="c"><joint name="b"/>'
        '<body name="d"><joint name="c"/></body></body><frame><body name="e"><joint name="a"/>'
        "</body></frame></body></worldbody></mujoco>"
    )
    order = RobotOrder(Body(), nested)
    assert order.rows("mujoco") == (1, 2, 0)
    assert order.rows("isaac") == (1, 0, 2)
    for lost in (text.replace('name="a"', 'name="z"'), "no XML"):
        with pytest.raises(InputError, match="does not tell where 'a'"):
            RobotOrder(Body(), lost).rows("mujoco")


def test_frames_of_mjcf_bodies_are_mujocos_though_joints_sit_elsewhere():
    text = (CASES / "base_mini.xml").read_text()
    for side in ("left", "right"):
        text = text.replace(
            f'<joint name="{side}_knee" ', f'<joint name="{side}_knee" pos="0.01 0 0.02" '
        )
    gait = first_walk(Robot.from_urdf(text), speed=0.3)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    sampled = motion(gait, 20.0, 1.0, "mujoco")
    assert [model.joint(k).name for k in range(1, model.njnt)] == list(sampled.joint_names)
    ids = [model.body(name).id for name in sampled.body_names]
    at, bodies = sampled.samples, sampled.body_motion
    for k in range(len(at.time)):
        data.qpos[:3], data.qpos[3:7] = at.base_position[k], at.base_quaternion[k][[3, 0, 1, 2]]
        data.qpos[7:], data.qvel[6:] = at.q[k], at.dq[k]
        data.qvel[:3], data.qvel[3:6] = sampled.base_velocity[k, :3], at.base_twist[k, 3:]
        mujoco.mj_forward(model, data)
        assert bodies.position[k] == pytest.approx(data.xpos[ids], abs=1e-9)
        speed = np.zeros(6)
        for column, body in enumerate(ids):
            kind = mujoco.mjtObj.mjOBJ_XBODY
            mujoco.mj_objectVelocity(model, data, kind, body, speed, 0)
            assert bodies.linear[k, column] == pytest.approx(speed[3:], abs=1e-9)
    assert np.abs(sampled.anchors).max() == pytest.approx(0.02)
