import copy
import pickle
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from sample_gait import sample_gait
from urdf_edits import add_arm, edited_urdf, joint, link, scale_mass, set_limit

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import InputError, RobotError
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole


def sent(one):
    return pickle.loads(pickle.dumps(one))


LEG = ("ankle_roll", "ankle_pitch", "knee", "hip_pitch", "hip_roll", "hip_yaw")


def test_joints_run_from_stance_ankle_to_swing_ankle(robot):
    expected = [f"right_{n}" for n in LEG] + [f"left_{n}" for n in reversed(LEG)]
    assert list(robot.joint_names) == expected


def test_the_biped_weighs_what_the_paper_says(robot):
    assert robot.mass == pytest.approx(56.87, abs=1e-9)


def test_the_sole_is_the_lower_face_of_the_foot(robot):
    assert robot.sole == Sole(toe=0.0, heel=-0.214, left=0.068, right=-0.068)


def test_limits_follow_their_joints(robot):
    spec = biped13().joints
    knee, hip = robot.joint_names.index("left_knee"), robot.joint_names.index("right_hip_yaw")
    assert robot.limits.torque[knee] == spec.knee.torque
    assert robot.limits.speed[hip] == spec.hip_yaw.speed
    assert (robot.limits.lower[knee], robot.limits.upper[knee]) == (
        spec.knee.lower,
        spec.knee.upper,
    )


def test_limits_of_one_joint_reach_both_legs_only_there():
    def edit(root):
        for side in ("left", "right"):
            set_limit(f"{side}_knee", effort=77.0, velocity=6.5)(root)

    robot = Robot.from_urdf(edited_urdf(edit))
    knees = [robot.joint_names.index(f"{side}_knee") for side in ("right", "left")]
    assert np.flatnonzero(robot.limits.torque == 77.0).tolist() == sorted(knees)
    assert np.flatnonzero(robot.limits.speed == 6.5).tolist() == sorted(knees)


def test_pelvis_frame_lies_midway_between_the_hips(robot):
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
    pelvis = data.oMf[robot.pelvis_frame]
    # Sole to hip height 0.105 + 0.3 + 0.3; the ankle lies 0.137 m behind the toes.
    np.testing.assert_allclose(pelvis.translation, [-0.137, 0.06, 0.705], atol=1e-12)
    np.testing.assert_allclose(pelvis.rotation, np.eye(3), atol=1e-12)


def test_the_other_foot_can_stand():
    robot = Robot.from_urdf(urdf_text(biped13()), stance_sole="left_sole", swing_sole="right_sole")
    assert robot.joint_names[0] == "left_ankle_roll"
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
    np.testing.assert_allclose(
        data.oMf[robot.swing_frame].translation, [0.0, -0.12, 0.0], atol=1e-12
    )


def test_a_file_and_its_text_give_the_same_robot(tmp_path, robot):
    path = tmp_path / "biped.urdf"
    path.write_text(urdf_text(biped13()), encoding="utf-8")
    from_file = Robot.from_urdf(path)
    assert from_file.urdf == robot.urdf
    np.testing.assert_array_equal(from_file.mirror, robot.mirror)


def test_an_arm_is_locked_but_its_mass_stays():
    robot = Robot.from_urdf(edited_urdf(add_arm))
    assert robot.mass == pytest.approx(58.87, abs=1e-9)
    assert "shoulder" not in robot.joint_names
    assert robot.model.nv == 18


def test_a_given_sole_replaces_the_collision_box():
    def edit(root):
        for side in ("left", "right"):
            foot = link(root, f"{side}_foot")
            for shape in [*foot.findall("collision"), *foot.findall("visual")]:
                foot.remove(shape)

    text = edited_urdf(edit)
    sole = Sole(toe=0.01, heel=-0.2, left=0.05, right=-0.04)
    assert Robot.from_urdf(text, sole=sole).sole == sole
    with pytest.raises(RobotError, match=r"no collision box .* 'right_sole'\); give the sole"):
        Robot.from_urdf(text)


def _turn_knee_axis(root: ET.Element) -> None:
    joint(root, "left_knee").find("axis").set("xyz", "1 0 0")


def _fix_knees(root: ET.Element) -> None:
    for side in ("left", "right"):
        joint(root, f"{side}_knee").set("type", "fixed")


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (_turn_knee_axis, r"not its own mirror image: .* 0 mm and 90 degrees"),
        (_fix_knees, r"'(right|left)_sole' cannot put a foot flat at a step: it has no knee "),
        (
            scale_mass("left_foot", 3.0),
            r"mirror image: .* 'right_ankle_roll' .* 3\.28e\+03 g in mass",
        ),
        (
            set_limit("left_knee", effort=140.0),
            "the torque limits of 'right_knee' .* 150 and 140 N·m",
        ),
        (set_limit("left_knee", velocity=9.0), "speed limits of .*, 10 and 9 rad/s"),
        (set_limit("left_knee", lower=3.0), "joint 'left_knee': the range is from 3 to 2.6 rad"),
    ],
)
def test_what_is_not_a_mirrored_biped_is_refused(edit, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(edit))


def test_an_unknown_sole_lists_those_there_are():
    with pytest.raises(
        RobotError,
        match=r"no frame named 'rigth_sole'; did you mean 'right_sole'.*left_sole.*right_sole",
    ):
        Robot.from_urdf(urdf_text(biped13()), stance_sole="rigth_sole")


@pytest.mark.parametrize("text", ["<robot", "<robot name='a'/>", "<a/>"])
def test_text_that_is_no_urdf_is_refused(text):
    with pytest.raises(
        RobotError,
        match=r"the file is not well-formed|has no <link>|the file holds <a>",
    ):
        Robot.from_urdf(text)


@pytest.mark.parametrize("thing", [None, 3, b"abc"])
def test_what_is_neither_text_nor_path_is_refused(thing):
    with pytest.raises(InputError, match=f"urdf is {thing!r}; give a text or a path"):
        Robot.from_urdf(thing)


def test_the_root_is_no_foot():
    with pytest.raises(RobotError, match=r"ends in 'the root' has 0 joints .* four to seven rev"):
        Robot.from_urdf(urdf_text(biped13()), stance_sole="torso", swing_sole="left_sole")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(RobotError, match=r"cannot read the URDF '.*none.urdf': no such file"):
        Robot.from_urdf(tmp_path / "none.urdf")


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(RobotError, match="it is not UTF-8 text"):
        Robot.from_urdf(path)


def test_a_joint_is_no_sole_frame():
    with pytest.raises(RobotError, match="no frame named 'left_ankle_roll', a joint being none"):
        Robot.from_urdf(
            urdf_text(biped13()), stance_sole="right_sole", swing_sole="left_ankle_roll",
            sole=Sole(toe=0.0, heel=-0.214, left=0.068, right=-0.068),
        )  # fmt: skip


@pytest.mark.parametrize("copied", [lambda one: one, copy.deepcopy, copy.copy, sent])
def test_nobody_can_write_into_what_a_robot_knows(robot, copied):
    mine = copied(robot)
    known = mine.limits.torque, mine.mirror, mine.legs.hips, mine.multibody.mass, mine.tree.moves
    for array in (*known, copied(robot.multibody).mass, copied(sample_gait()).torque):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    assert np.array_equal(mine.mirror, robot.mirror)


def test_arrays_that_a_robot_is_given_stay_those_of_their_owner(robot):
    mirror, mass = 2.0 * robot.mirror, 2.0 * robot.multibody.mass
    view = mass[:]
    view.setflags(write=False)  # through `mass` one writes into it all the same
    changed = replace(robot, mirror=mirror, multibody=replace(robot.multibody, mass=view))
    kept = changed.mirror.copy(), changed.multibody.mass.copy()
    mirror[0], mass[0] = 7.0, 7.0
    assert np.array_equal(changed.mirror, kept[0])
    assert np.array_equal(changed.multibody.mass, kept[1])
