"""Robots that nobody prepared, made from the biped: they must give the biped's own numbers."""

import json
import re
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, add_joint, add_link, add_toes, edits, new_root, rename
from numerics import relative_error
from urdf_edits import edited_urdf, joint, link

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import import_robot
from gaitopt.model.leg_detection import speaks_for_other_side
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.view.inspection import inspect_robot, inspection_tables

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
    bent = ImportOptions(posture={"waist": 0.3})
    turned = Robot.from_urdf(waisted.urdf, choices=bent)
    np.testing.assert_allclose(turned.choices.forward, [np.cos(0.3), np.sin(0.3), 0], atol=1e-12)
    assert relative_error(effort(turned), effort(robot)) < 1e-10


@pytest.mark.parametrize(
    ("count", "step"), [(3, -0.05), (6, -0.05), (7, -0.1), (4, -0.5), (6, -0.25), (7, -0.4)]
)
def test_arms_are_not_legs(robot, count, step):
    """Nor where they reach lower than the feet."""
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


def _shod_toes(root):
    """Toes with soles of their own, as high as the foot's and 4 cm ahead of it."""
    add_toes()(root)
    for side in ("left", "right"):
        shape = ET.SubElement(link(root, f"{side}_toes_0"), "collision")
        ET.SubElement(shape, "origin", xyz="0.037 0 -0.009")
        ET.SubElement(ET.SubElement(shape, "geometry"), "box", size="0.04 0.136 0.012")


def _fixed_toes(root):
    _shod_toes(root)
    for side in ("left", "right"):
        joint(root, f"{side}_toe_0").set("type", "fixed")


def test_locked_toes_bear_as_fixed_ones_do(robot):
    toed, fixed = (Robot.from_urdf(edited_urdf(edit)) for edit in (_shod_toes, _fixed_toes))
    assert toed.sole == fixed.sole
    assert toed.sole.toe == pytest.approx(robot.sole.toe + 0.04, abs=1e-9)
    assert relative_error(effort(toed), effort(fixed)) < 1e-12


def test_toes_that_move_bear_nothing(robot):
    moved = Robot.from_urdf(edited_urdf(_shod_toes), moving=("*_toe_*",))
    assert moved.joint_names[-2:] == ("left_toe_0", "right_toe_0")
    assert moved.sole == robot.sole
    assert "locked" not in said(moved, "legs")


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
        found = Robot.from_urdf(robot.urdf, choices=ImportOptions(feet=names))
        assert found.joint_names == robot.joint_names
    with pytest.raises(RobotError, match="'right_foot' and 'right_sole' are moved by the same"):
        Robot.from_urdf(robot.urdf, choices=ImportOptions(feet=("right_foot", "right_sole")))


def test_either_foot_may_stand(robot):
    left = Robot.from_urdf(robot.urdf, choices=ImportOptions(stance="left"))
    assert (left.stance_sole, left.swing_sole) == ("left_sole", "right_sole")
    assert left.joint_names[0] == "left_ankle_roll"
    same = Robot.from_urdf(robot.urdf, stance_sole="left_sole")
    assert same.model == left.model
    with pytest.raises(RobotError, match="'right_sole' makes the right foot stand, but stance the"):
        Robot.from_urdf(robot.urdf, choices=ImportOptions(stance="left", stance_sole="right_sole"))
    with pytest.raises(RobotError, match="frame 'torso' is on neither foot"):
        Robot.from_urdf(robot.urdf, stance_sole="torso")


def _knees(kind: str):
    def edit(root):
        for side in ("left", "right"):
            joint(root, f"{side}_knee").set("type", kind)

    return edit


def _mimic(root):
    joint(root, "left_knee").append(ET.Element("mimic", joint="nothing"))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (edits(_knees("fixed"), add_toes()), r"_sole' cannot put a foot flat .* no knee between"),
        (
            _knees("fixed"),
            r"no knee between hip .*: .*ankle_pitch, \w+_ankle_roll; the",
        ),
        (_knees("prismatic"), r"joint '\w+_knee' is prismatic; gaitopt needs two legs of four"),
        (_knees("planar"), r"^line \d+: joint '\w+_knee': its type is planar; only revolute"),
        (_mimic, r"^line \d+: joint 'left_knee': its <mimic> cannot be followed: it follows 'noth"),
    ],
)
def test_legs_that_cannot_walk_are_named(edit, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(edit))


def _said_of(edit, **choices):
    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(**choices))
    return str(caught.value)


def _shifted(name: str, xyz: str):
    return lambda root: joint(root, name).find("origin").set("xyz", xyz)


@pytest.mark.parametrize(("end", "count"), [("ankle_roll", 6), ("knee", 4)])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("arms", [0, 3])
def test_a_root_in_a_leg_is_named(end, count, side, arms):
    def reverse(root):
        for name in LEG[LEG.index(end) :]:
            way = joint(root, f"{side}_{name}")
            parent, child = way.find("parent"), way.find("child")
            above, below = parent.get("link"), child.get("link")
            parent.set("link", below)
            child.set("link", above)

    foot = {"ankle_roll": "foot", "knee": "shin"}[end]
    said = rf"'{side}_{foot}', lies in a leg: {count} joints lie .* '\w*torso'; .* as its root"
    with pytest.raises(RobotError, match=said):
        Robot.from_urdf(edited_urdf(edits(add_arms(arms), reverse)))


@pytest.mark.parametrize("others", [[], [add_arms(7)], [add_arms(6)]])
@pytest.mark.parametrize(
    ("name", "xyz", "fault"),
    [
        ("left_hip_yaw", "0 0.06 0.2", r"'(right|left)_hip_yaw' lies 200.0 mm away"),
        ("right_knee", "0 0 -0.35", r"'(right|left)_knee' lies 50.0 mm away .*_hip_pitch' and '"),
    ],
)
def test_unequal_legs_are_named_whatever_else_would_do(name, xyz, fault, others):
    told = _said_of(edits(_shifted(name, xyz), *others))
    assert re.search(rf"^the legs are not mirror images: {fault}", told)
    assert "arm" not in told


def test_nameless_legs_are_a_pair_where_they_nearly_mirror():
    names = rename({"left_": "", "right": "r"})
    told = _said_of(edits(_shifted("right_knee", "0 0 -0.35"), names))
    assert re.search("'(r_)?knee' lies 50.0 mm away from the mirror image of '(r_)?knee'", told)


def test_a_posture_that_bends_one_leg_is_named():
    told = _said_of(add_arms(7), posture={"right_knee": 1.5})
    assert "bends the legs unequally: 'left_knee' stands at 0 rad, its partner 'right_kn" in told
    assert "at 1.5 rad" in told


def _four_legs(root):
    for name, x in (("front", 0.3), ("hind", -0.3)):
        for side, y in (("left", 0.1), ("right", -0.1)):
            parent, xyz = "torso", f"{x} {y} 0"
            for k in range(3):
                link_name = f"{name}_{side}_{k}"
                add_link(root, link_name, 0.5)
                add_joint(root, f"{link_name}_joint", parent, link_name, xyz=xyz)
                parent, xyz = link_name, "0 0 -0.5"


def test_four_legs_are_counted():
    told = _said_of(_four_legs)
    assert "two legs were found: four chains of 3 joints each reach equally low, down to" in told
    assert all(f"'{a}_{b}_2'" in told for a in ("front", "hind") for b in ("left", "right"))
    assert told.endswith('name its feet: feet = ["RIGHT", "LEFT"] in the file for --choices '
                         "(in Python, feet)")  # fmt: skip


def _no_legs(root):
    for side in ("left", "right"):
        joint(root, f"{side}_hip_yaw").set("type", "fixed")
        for part in ("hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"):
            joint(root, f"{side}_{part}").set("type", "fixed")


def test_arms_are_not_called_legs():
    told = _said_of(edits(_no_legs, add_arms(7)))
    assert "the chain that ends in 'left_arm_6' cannot put a foot flat at a step: it has no" in told
    assert "if they are arms, the robot shows no legs" in told
    assert "leg that ends" not in told


def test_arms_that_could_be_legs_are_refused_by_their_names(robot):
    """As of robots on wheels: a certified walk on hands helps nobody. They may be named as feet."""
    arms = {"hip": "shoulder", "knee": "elbow", "ankle": "wrist", "foot": "hand", "sole": "palm",
            "thigh": "upper_arm", "shin": "forearm"}  # fmt: skip
    text = robot.urdf
    for of_leg, of_arm in arms.items():
        text = text.replace(of_leg, of_arm)
    with pytest.raises(RobotError, match=r"to '\w+_hand' and .*named as arms; .*name their"):
        Robot.from_urdf(text)
    hands = Robot.from_urdf(text, choices=ImportOptions(feet=("right_hand", "left_hand")))
    assert hands.legs.reach == pytest.approx(robot.legs.reach, abs=1e-12)


def _fingers(root):
    for side in ("left", "right"):
        for k in range(2):
            name = f"{side}_finger_{k}"
            add_link(root, name, 0.05)
            add_joint(root, name, f"{side}_arm_4", name, xyz=f"0 {0.02 * k} -0.05")
            joint(root, name).append(ET.Element("mimic", joint=f"{side}_arm_joint_4"))


def test_fingers_that_mimic_are_no_legs():
    told = _said_of(edits(_no_legs, add_arms(5), _fingers))
    assert told.startswith("no two legs were found: four chains, the longest, of 6 joints, end in")
    assert "follow other joints (<mimic>), as fingers do" in told


@pytest.mark.parametrize("rpy", ["0.05 0 0", "0.3 0.2 0.9", "-0.4 0 0.3", "1.2 0.5 -2"])
def test_up_is_told_from_the_legs_of_a_tilted_root(robot, rpy):
    tilted = edited_urdf(edits(new_root(rpy), _on_spheres if rpy == "0.05 0 0" else _as_it_is))
    turned = Robot.from_urdf(tilted)
    R = pin.rpy.rpyToMatrix(*map(float, rpy.split()))
    np.testing.assert_allclose(turned.choices.up, R[:, 2], atol=1e-9)
    np.testing.assert_allclose(pelvis(turned), pelvis(robot), atol=1e-9)
    assert relative_error(effort(turned), effort(robot)) < 1e-8
    assert "guessed: the root link is tilted by" in said(turned, "heading")
    assert Robot.from_urdf(turned.urdf, choices=turned.choices).model == turned.model


def _as_it_is(root):
    pass


def _on_spheres(root):
    """Four small balls under each foot in place of its shape, as many robots have."""
    for side in ("left", "right"):
        foot = link(root, f"{side}_foot")
        for shape in foot.findall("collision"):
            foot.remove(shape)
        for x in (-0.072, 0.132):
            for y in (-0.063, 0.063):
                foot.append(
                    ET.fromstring(
                        f"<collision><origin xyz='{x} {y} -0.1'/>"
                        "<geometry><sphere radius='0.005'/></geometry></collision>"
                    )
                )


def test_a_pitched_root_is_told_with_the_up_that_would_right_it(robot):
    tilted = edited_urdf(edits(new_root("0 0.0873 0"), _on_spheres))
    found = Robot.from_urdf(tilted)
    assert "is tilted by 5.00 degrees in the reference posture" in said(found, "sole")
    up = re.search(r"the root link that is tilted: up = \[(.*?)\]", said(found, "sole"))
    given = ImportOptions(up=tuple(float(n) for n in up[1].split(",")))
    righted = Robot.from_urdf(tilted, choices=given)
    assert "tilted" not in said(righted, "sole")
    np.testing.assert_allclose(pelvis(righted), pelvis(robot), atol=1e-5)


def test_a_posture_that_tilts_the_feet_too_far_is_refused():
    bent = {"left_knee": 1.5, "right_knee": 1.5}
    told = _said_of(_on_spheres, posture=bent)
    assert "the sole of the right foot is tilted by 85.9 degrees in the reference posture" in told
    assert "[posture]" in told
    level = {"hip_pitch": -0.3, "knee": 0.6, "ankle_pitch": -0.3}
    angles = {f"{side}_{name}": a for name, a in level.items() for side in ("left", "right")}
    assert (
        Robot.from_urdf(edited_urdf(_on_spheres), choices=ImportOptions(posture=angles)).mass > 0.0
    )


def test_spread_arms_are_no_legs_that_lie(robot):
    def spread(root):
        for side, sign in (("left", 1.0), ("right", -1.0)):
            for k in range(1, 6):
                place = joint(root, f"{side}_arm_joint_{k}").find("origin")
                place.set("xyz", f"0.01 {0.1 * sign} 0.02")

    told = _said_of(edits(_no_legs, add_arms(6), spread, new_root("0.3 0.2 0.9")))
    assert told.startswith("no two legs were found: two chains, the longest, of 6 joints, end in")


def test_legs_that_lie_without_soles_ask_for_up(robot):
    def bare(root):
        for tag in ("visual", "collision"):
            for element in root.findall("link"):
                for shape in element.findall(tag):
                    element.remove(shape)

    lying = edits(new_root("0.3 0.2 0.9"), bare)
    told = _said_of(lying)
    assert "mirror each other, but no soles show which way is up" in told
    assert "up = [X, Y, Z]" in told


def test_other_joints_that_mimic_are_told_in_one_line():
    text = edited_urdf(edits(add_arms(5), _fingers))
    reading = import_robot(read_source(text), ImportOptions())
    (told,) = [p for p in reading.problems if p.kind == "tied"]
    assert told.text.startswith("4 joints outside the legs mimic others; they are locked")
    assert "'left_finger_0', " in told.text
    shown = {s.title: s.rows for s in inspection_tables(inspect_robot(text, ImportOptions()))}
    assert shown["Odd in the file"] == ((str(told.line), told.text),)


@pytest.mark.parametrize(
    ("right", "left", "wrong"),
    [
        ("LR_HR", "LL_HR", False),  # both legs begin with L
        ("right_hip", "left_hip", False),
        ("left_hip", "right_hip", True),
        ("RLEG_R", "LLEG_R", False),
        ("hip_l_pitch", "hip_r_pitch", True),
        ("leg1", "leg2", False),
    ],
)
def test_names_speak_where_partners_differ(right, left, wrong):
    assert speaks_for_other_side([right], [left]) is wrong


def test_legs_of_unequal_length_can_be_averaged_as_the_refusal_says():
    def shorten(root):
        origin = joint(root, "left_knee").find("origin")
        x, y, z = map(float, origin.get("xyz").split())
        origin.set("xyz", f"{x} {y} {z + 0.03}")

    text = edited_urdf(shorten)
    with pytest.raises(RobotError, match="legs are not mirror images") as caught:
        Robot.from_urdf(text)
    feet = tuple(json.loads(re.search(r"feet = (\[[^]]*\])", str(caught.value))[1]))
    with pytest.raises(RobotError, match="averaging left and right") as caught:
        Robot.from_urdf(text, choices=ImportOptions(feet=feet))
    asymmetry = float(re.search(r"asymmetry = (\S+) in the file", str(caught.value))[1])
    Robot.from_urdf(text, choices=ImportOptions(feet=feet, asymmetry=asymmetry))
