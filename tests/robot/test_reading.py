"""Heading, soles and formats: what is read where the file does not say it."""

from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from humanoids import edits, new_root
from mjcf_text import mjcf_text
from numerics import relative_error
from urdf_edits import edited_urdf, joint, link, set_limit

from gaitopt.errors import RobotError
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.model.sole_detection import sole_normal

FOOT = "type='box' size='0.107 0.068 0.02' pos='0.03 0 -0.085'"


def effort(robot: Robot, seed: int = 3) -> np.ndarray:
    """Torques and the two rows of the wrench that do not depend on the sole frame's place."""
    rng = np.random.default_rng(seed)
    q = pin.neutral(robot.model)
    q[7:] = rng.uniform(-0.6, 0.6, 12)
    v, a = (np.r_[np.zeros(6), rng.normal(0.0, s, 12)] for s in (2.0, 20.0))
    tau = pin.rnea(robot.model, robot.model.createData(), q, v, a)
    return np.r_[tau[:3], tau[6:]]


def said(robot: Robot, topic: str) -> str:
    return "; ".join(f"{f.how}: {f.text}" for f in robot.findings if f.topic == topic)


def both(name: str, **values: float):
    return edits(*(set_limit(f"{side}_{name}", **values) for side in ("left", "right")))


def feet(shape: str, xyz: str):
    """Edit that gives both feet one box."""

    def edit(root):
        for side in ("left", "right"):
            foot = link(root, f"{side}_foot")
            for old in [*foot.findall("collision"), *foot.findall("visual")]:
                foot.remove(old)
            foot.append(
                ET.fromstring(
                    f"<collision><origin xyz='{xyz}'/><geometry>{shape}</geometry></collision>"
                )
            )

    return edit


def test_mjcf_gives_the_robot_of_the_urdf(robot):
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    found = Robot.from_urdf(mjcf_text(whole, foot_geom=FOOT))
    assert found.joint_names == robot.joint_names
    assert relative_error(effort(found), effort(robot)) < 1e-9
    assert found.sole == Sole(toe=0.137, heel=-0.077, left=0.068, right=-0.068)
    assert np.isinf(found.limits.speed).all()
    again = Robot.from_urdf(found.urdf, choices=found.choices)
    assert again.model == found.model


def test_armature_of_mjcf_stays_with_its_joint(robot):
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    text = mjcf_text(whole, foot_geom=FOOT)
    for k, name in enumerate(("left_knee", "right_knee")):
        text = text.replace(f'<joint name="{name}"', f'<joint armature="0.0{k + 3}" name="{name}"')
    found = Robot.from_urdf(text)
    armatures = dict(zip(found.joint_names, found.model.armature[6:], strict=True))
    # Left and right differ, and both walk with the mean.
    assert armatures.pop("left_knee") == armatures.pop("right_knee") == pytest.approx(0.035)
    told = next(f for f in found.findings if f.subject.startswith("rotors of"))
    assert "differed by 0.01 kg·m² (armature)" in told.text


SYMMETRIC_FOOT = feet("<box size='0.2 0.12 0.04'/>", "0 0 -0.085")
LONG_HEEL = feet("<box size='0.2 0.12 0.04'/>", "-0.05 0 -0.085")


def test_knees_tell_the_front_where_the_feet_do_not(robot):
    found = Robot.from_urdf(edited_urdf(edits(SYMMETRIC_FOOT, new_root("0 0 3.141592653589793"))))
    assert found.choices.forward == "-x"
    assert "of the root link: the knees bend that way" in said(found, "heading")
    assert found.joint_names == robot.joint_names


def test_a_foot_that_contradicts_the_knees_is_a_warning(robot):
    found = Robot.from_urdf(edited_urdf(LONG_HEEL))
    assert found.joint_names == robot.joint_names
    words = "warning: though the feet reach 150 mm ahead of the ankle and 50 mm behind it if it"
    assert words in said(found, "heading")
    # Where the usual root axis speaks for the feet, they count.
    turned = Robot.from_urdf(edited_urdf(edits(LONG_HEEL, new_root("0 0 3.141592653589793"))))
    assert turned.choices.forward == "x"
    assert "warning: the knees' ranges speak for the opposite direction" in said(turned, "heading")
    given = Robot.from_urdf(turned.urdf, choices=ImportOptions(forward="-x"))
    assert given.joint_names == robot.joint_names
    assert given.legs.flexion.tolist() == [1.0, 1.0]
    assert "given: forward is -x" in said(given, "heading")


def test_without_any_sign_forward_is_x_by_convention():
    unclear = edits(SYMMETRIC_FOOT, both("knee", lower=-2.0, upper=2.0))
    found = Robot.from_urdf(edited_urdf(unclear))
    assert found.choices.forward == "x"
    assert "warning: front and back cannot be told apart" in said(found, "heading")
    askew = edited_urdf(edits(unclear, new_root("0 0 1.0")))
    untold = "front and back cannot be told apart: .*say where the robot looks [^;]*"
    chains = "; the chains to '(left|right)_sole' and .* taken for legs, as they reach lowest; .*"
    with pytest.raises(RobotError, match=f"^{untold}{chains}$"):
        Robot.from_urdf(askew)
    with pytest.raises(RobotError, match=f"^{untold}$"):  # nothing was taken for anything
        Robot.from_urdf(askew, choices=ImportOptions(feet=("right_foot", "left_foot")))


def test_soles_beside_the_feet_are_told_with_their_places(robot):
    """As iCub's in pyCub, whose plates begin at the same corner on both sides."""
    aside = feet('<box size="0.2 0.03 0.02"/>', "0.05 0.036 -0.07")
    hip = abs(robot.legs.stance_width) / 2.0 * 1e3
    right, left = (f"y {-hip + y - 15:.0f} to {-hip + y + 15:.0f} mm" for y in (36, -36))
    with pytest.raises(RobotError, match=f"nothing in common: .*{right} .*the left one .*{left};"):
        Robot.from_urdf(edited_urdf(aside))


def test_forward_must_be_level_and_across_the_hips(robot):
    for axis in ("y", "z"):
        with pytest.raises(RobotError, match=f"forward = {axis} is not level and across the hips"):
            Robot.from_urdf(robot.urdf, choices=ImportOptions(forward=axis))


def test_a_foot_off_the_middle_gets_a_frame_in_its_middle(robot):
    def wide(root):
        feet("<box size='0.2 0.12 0.04'/>", "0.04 0 -0.085")(root)
        for side, y in (("left", 0.02), ("right", -0.02)):
            origin = link(root, f"{side}_foot").find("collision/origin")
            origin.set("xyz", f"0.04 {y} -0.085")

    found = Robot.from_urdf(edited_urdf(wide))
    assert found.sole == Sole(toe=0.14, heel=-0.06, left=0.06, right=-0.06)
    np.testing.assert_allclose(found.legs.ankles, [[0, 0.02, 0.105], [0, -0.02, 0.105]], atol=1e-12)
    assert "right_sole_frame" in found.stance_sole
    # Frames of the file that the user names are used, with what is left of the width.
    named = Robot.from_urdf(found.urdf, stance_sole="right_sole", swing_sole="left_sole")
    assert (named.sole.left, named.sole.right) == (0.04, -0.04)
    assert "warning: 40.0 mm of the soles' width are not used" in said(named, "sole")


def test_soles_of_two_sizes_are_their_common_part():
    def edit(root):
        feet("<box size='0.2 0.12 0.04'/>", "0.04 0 -0.085")(root)
        shape = link(root, "left_foot").find("collision")
        shape.find("geometry/box").set("size", "0.18 0.1 0.04")

    found = Robot.from_urdf(edited_urdf(edit))
    width = found.sole.left - found.sole.right
    assert (found.sole.toe - found.sole.heel, width) == pytest.approx((0.18, 0.1))
    assert "warning: the soles of the two feet differ by 10.0 mm" in said(found, "sole")


def test_one_named_frame_finds_its_partner(robot):
    found = Robot.from_urdf(robot.urdf, stance_sole="left_sole")
    assert (found.stance_sole, found.swing_sole) == ("left_sole", "right_sole")


def test_a_frame_that_is_no_sole_is_refused_unless_the_sole_is_given(robot):
    with pytest.raises(RobotError, match=r"'right_foot' is not in the plane .* lies 105.0 mm"):
        Robot.from_urdf(robot.urdf, stance_sole="right_foot", swing_sole="left_foot")
    sole = Sole(0.1, -0.1, 0.05, -0.05)
    found = Robot.from_urdf(robot.urdf, stance_sole="right_foot", swing_sole="left_foot", sole=sole)
    assert found.sole == sole
    np.testing.assert_allclose(found.legs.ankles, 0.0, atol=1e-12)


def test_a_sole_may_be_measured(robot):
    choices = ImportOptions(sole=Sole(0.13, -0.07, 0.06, -0.06), sole_drop=0.11)
    found = Robot.from_urdf(robot.urdf, choices=choices)
    np.testing.assert_allclose(found.legs.ankles, [[0, 0, 0.11]] * 2, atol=1e-12)
    assert found.choices.sole_placements is not None
    assert found.choices.sole_drop is None
    assert Robot.from_urdf(found.urdf, choices=found.choices).model == found.model


def test_feet_that_are_tilted_at_zero_are_levelled(robot):
    bent = 0.2

    def edit(root):
        for side in ("left", "right"):
            joint(root, f"{side}_ankle_pitch").find("origin").set("rpy", f"0 {bent} 0")

    found = Robot.from_urdf(edited_urdf(edit))
    assert "guessed: is tilted by 11.46 degrees in the reference posture" in said(found, "sole")
    assert found.sole == robot.sole
    data = found.model.createData()
    pin.framesForwardKinematics(found.model, data, pin.neutral(found.model))
    tilt = pin.log3(data.oMf[found.pelvis_frame].rotation)
    np.testing.assert_allclose(tilt, [0.0, -bent, 0.0], atol=1e-12)


def test_the_normal_of_a_foot_is_that_of_its_largest_lower_face(rng):
    corners = np.array(np.meshgrid([-0.1, 0.15], [-0.05, 0.06], [0.0, 0.08])).reshape(3, -1).T
    turn = pin.rpy.rpyToMatrix(0.1, -0.3, 0.2)
    down = np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(sole_normal(corners @ turn.T, down), turn @ down, atol=1e-12)
    assert sole_normal(corners, down) is None
    assert sole_normal(corners[:3], down) is None
    ball = rng.normal(size=(400, 3))
    assert sole_normal(ball / np.linalg.norm(ball, axis=1)[:, None], down) is None


def test_height_and_natural_step_of_the_biped(robot):
    assert robot.legs.height == pytest.approx(0.705, abs=1e-12)
    assert robot.legs.bound == pytest.approx(0.6, abs=1e-12)
    # Alexander's stride of 2.3 h (v²/gh)^0.3: at a Froude number of 0.25 it is 1.517 h.
    speed = np.sqrt(0.25 * 9.81 * 0.705)
    assert robot.legs.natural_step(speed) == pytest.approx(0.705 * 1.5174 / 2.0, rel=1e-4)
    assert np.linalg.norm(robot.model.gravity.linear) == robot.legs.gravity == 9.81
    assert robot.legs.natural_step(0.5) < robot.legs.natural_step(1.0)
