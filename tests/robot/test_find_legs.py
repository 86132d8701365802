"""Robots that nobody prepared, made from the biped: they must give the biped's own numbers."""

from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, add_joint, add_link, add_toes, edits, new_root, rename
from numerics import relative_error
from urdf_edits import edited_urdf, joint, link

from gaitopt.errors import RobotError
from gaitopt.robot.choices import Choices
from gaitopt.robot.feet.sole import Sole
from gaitopt.robot.model import Robot

LEG = ("ankle_roll", "ankle_pitch", "knee", "hip_pitch", "hip_roll", "hip_yaw")
QUARTER = "1.5707963267948966"


def effort(robot: Robot, seed: int = 3) -> np.ndarray:
    """Ground wrench and torques in a random state."""
    rng = np.random.default_rng(seed)
    q = pin.neutral(robot.model)
    q[7:] = rng.uniform(-0.6, 0.6, 12)
    v, a = (np.r_[np.zeros(6), rng.normal(0.0, s, 12)] for s in (2.0, 20.0))
    return pin.rnea(robot.model, robot.model.createData(), q, v, a)


def pelvis(robot: Robot) -> np.ndarray:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
    return data.oMf[robot.pelvis_frame].homogeneous


def said(robot: Robot, topic: str) -> str:
    return "; ".join(f"{f.how}: {f.text}" for f in robot.findings if f.topic == topic)


@pytest.mark.parametrize(
    ("rpy", "forward", "up"),
    [
        ("0 0 0", "x", "z"),
        ("0 0 3.141592653589793", "-x", "z"),
        (f"0 0 {QUARTER}", "y", "z"),
        (f"{QUARTER} 0 0", "x", "-y"),
        (f"-{QUARTER} 0 0", "x", "y"),
        (f"0 {QUARTER} 0", "-z", "x"),
        ("3.141592653589793 0 0", "x", "-z"),
    ],
)
def test_the_root_may_be_turned(robot, rpy, forward, up):
    turned = Robot.from_urdf(edited_urdf(new_root(rpy)))
    assert (turned.choices.forward, turned.choices.up) == (forward, up)
    assert turned.joint_names == robot.joint_names
    np.testing.assert_array_equal(turned.mirror, robot.mirror)
    assert relative_error(effort(turned), effort(robot)) < 1e-10
    np.testing.assert_allclose(pelvis(turned), pelvis(robot), atol=1e-12)
    np.testing.assert_allclose(turned.legs.hips, robot.legs.hips, atol=1e-12)
    assert turned.sole == robot.sole


def test_a_robot_may_stand_askew_of_its_roots_axes(robot):
    turned = Robot.from_urdf(edited_urdf(new_root("0 0 0.4")))
    np.testing.assert_allclose(turned.choices.forward, [np.cos(0.4), np.sin(0.4), 0], atol=1e-12)
    assert relative_error(effort(turned), effort(robot)) < 1e-10
    assert Robot.from_urdf(turned.urdf, choices=turned.choices).model == turned.model


def test_a_waist_between_root_and_legs_is_locked(robot):
    waisted = Robot.from_urdf(edited_urdf(new_root("0 0 0", waist="revolute")))
    assert relative_error(effort(waisted), effort(robot)) < 1e-10
    assert "one joint that is not the legs', locked at 0: waist" in said(waisted, "posture")
    bent = Choices(posture={"waist": 0.3})
    turned = Robot.from_urdf(waisted.urdf, choices=bent)
    np.testing.assert_allclose(turned.choices.forward, [np.cos(0.3), np.sin(0.3), 0], atol=1e-12)
    assert relative_error(effort(turned), effort(robot)) < 1e-10


@pytest.mark.parametrize(("count", "step"), [(3, -0.05), (6, -0.05), (7, -0.1)])
def test_arms_are_not_legs(robot, count, step):
    armed = Robot.from_urdf(edited_urdf(add_arms(count, step=step)))
    assert armed.joint_names == robot.joint_names
    assert armed.mass == pytest.approx(56.87 + count, abs=1e-9)
    assert f"{2 * count} joints that are not the legs', locked" in said(armed, "posture")


@pytest.mark.parametrize("count", [1, 2])
def test_toes_belong_to_the_foot(robot, count):
    toed = Robot.from_urdf(edited_urdf(add_toes(count)))
    assert toed.joint_names == robot.joint_names
    assert "toe_" in said(toed, "posture")
    assert toed.mass == pytest.approx(56.87 + 0.2 * count, abs=1e-9)


def test_sides_are_told_by_place_not_by_name(robot):
    crossed = Robot.from_urdf(edited_urdf(rename({"left": "right", "right": "left"})))
    assert crossed.joint_names == tuple(
        n.replace("left", "LEFT").replace("right", "left").replace("LEFT", "right")
        for n in robot.joint_names
    )
    assert "warning: is the right leg by its place, though" in said(crossed, "heading")
    assert relative_error(effort(crossed), effort(robot)) < 1e-12
    nameless = Robot.from_urdf(edited_urdf(rename({"left": "p", "right": "q"})))
    assert nameless.joint_names == tuple(f"q_{n}" for n in LEG) + tuple(
        f"p_{n}" for n in reversed(LEG)
    )


def test_without_sole_frames_new_ones_are_made(robot):
    def drop_soles(root):
        for side in ("left", "right"):
            root.remove(link(root, f"{side}_sole"))
            root.remove(joint(root, f"{side}_sole_joint"))

    bare = Robot.from_urdf(edited_urdf(drop_soles))
    assert (bare.stance_sole, bare.swing_sole) == ("right_sole", "left_sole")
    assert bare.choices.sole_placements is not None
    # The ankle is 0.137 m behind the toes, 0.077 m before the heel.
    assert bare.sole == Sole(toe=0.137, heel=-0.077, left=0.068, right=-0.068)
    assert relative_error(effort(bare)[6:], effort(robot)[6:]) < 1e-10
    assert "guessed: the sole reaches 137.0 mm forward, 77.0 mm back" in said(bare, "sole")


def test_resolved_choices_need_no_shapes(robot):
    text = robot.urdf
    for tag in ("visual", "collision"):
        while f"<{tag}>" in text:
            start = text.index(f"<{tag}>")
            text = text[:start] + text[text.index(f"</{tag}>") + len(tag) + 3 :]
    with pytest.raises(RobotError, match="no collision box or visual shape of the feet shows"):
        Robot.from_urdf(text)
    again = Robot.from_urdf(text, choices=robot.choices)
    assert again.model == robot.model
    assert again.choices == robot.choices
    assert again.sole == robot.sole


def test_feet_may_be_named_by_link_joint_or_frame(robot):
    for names in (("right_foot", "left_foot"), ("left_ankle_roll", "right_sole")):
        found = Robot.from_urdf(robot.urdf, choices=Choices(feet=names))
        assert found.joint_names == robot.joint_names
    with pytest.raises(RobotError, match="'right_foot' and 'right_sole' are moved by the same"):
        Robot.from_urdf(robot.urdf, choices=Choices(feet=("right_foot", "right_sole")))


def test_either_foot_may_stand(robot):
    left = Robot.from_urdf(robot.urdf, choices=Choices(stance="left"))
    assert (left.stance_sole, left.swing_sole) == ("left_sole", "right_sole")
    assert left.joint_names[0] == "left_ankle_roll"
    same = Robot.from_urdf(robot.urdf, stance_sole="left_sole")
    assert same.model == left.model
    with pytest.raises(RobotError, match="'right_sole' makes the right foot stand, but stance the"):
        Robot.from_urdf(robot.urdf, choices=Choices(stance="left", stance_sole="right_sole"))
    with pytest.raises(RobotError, match="frame 'torso' is on neither foot"):
        Robot.from_urdf(robot.urdf, stance_sole="torso")


def _seventh_joint(root):
    for side in ("left", "right"):
        child = joint(root, f"{side}_hip_yaw").find("parent")
        add_link(root, f"{side}_extra", 0.3)
        add_joint(root, f"{side}_seventh", "torso", f"{side}_extra", xyz="0 0 0", axis="1 0 0")
        child.set("link", f"{side}_extra")


def _knees(kind: str):
    def edit(root):
        for side in ("left", "right"):
            joint(root, f"{side}_knee").set("type", kind)

    return edit


def _mimic(root):
    joint(root, "left_knee").append(ET.Element("mimic", joint="right_knee"))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (_seventh_joint, r"has 7 joints of its own; gaitopt needs .*: \w+_seventh, \w+_hip_yaw"),
        (edits(_knees("fixed"), add_toes()), r"has 5 joints of its own; gaitopt needs two legs"),
        (_knees("fixed"), r"_sole' has 5 joints of its own; .*ankle_pitch, \w+_ankle_roll$"),
        (_knees("prismatic"), r"joint '\w+_knee' of a leg is prismatic; gaitopt needs two legs of"),
        (_knees("continuous"), r"joint '\w+_knee' of a leg is continuous \(without a range\)"),
        (_knees("planar"), r"^line \d+: joint '\w+_knee': its type is planar; only revolute"),
        (_mimic, r"^line \d+: joint 'left_knee': it mimics joint 'right_knee', which is not"),
    ],
)
def test_legs_that_cannot_walk_are_named(edit, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(edit))


def test_a_robot_with_one_leg_asks_for_the_feet():
    def edit(root):
        joint(root, "left_hip_yaw").find("origin").set("xyz", "0 0.06 0.2")

    with pytest.raises(RobotError, match=r"no two legs were found: .*name the feet"):
        Robot.from_urdf(edited_urdf(edit))
