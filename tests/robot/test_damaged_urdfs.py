"""Robots that are wrong in one way: each is refused in words, or read with a warning."""

import copy
import re
from xml.etree import ElementTree as ET

import pytest
from typer.testing import CliRunner
from urdf_edits import edited_urdf, joint, link, scale_mass, set_limit

from gaitopt.cli.app import app
from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.robot import Robot

SIDES = ("left", "right")


def on(tag, owner, path, /, **values):
    """An edit that sets attributes of an element of a link or joint; None removes one."""

    def edit(root):
        found = _entry(root, tag, owner).find(path)
        for key, value in values.items():
            found.attrib.pop(key, None)
            if value is not None:
                found.set(key, value)

    return edit


def _entry(root, tag, name):
    return {"link": link, "joint": joint}[tag](root, name)


def both(edit):
    """An edit of either leg."""

    def edits(root):
        for side in SIDES:
            edit(side)(root)

    return edits


def without(tag, name, path):
    """An edit that removes an element of a link or joint."""

    def edit(root):
        owner = _entry(root, tag, name)
        owner.remove(owner.find(path))

    return edit


def removed(root, *names):
    for element in list(root):
        if element.get("name") in names:
            root.remove(element)


def appended(*texts):
    def edit(root):
        root.extend(ET.fromstring(text) for text in texts)

    return edit


def mimic(side):
    return lambda root: ET.SubElement(joint(root, f"{side}_knee"), "mimic", joint="no_hip_pitch")


def stiff(side, *names):
    def edit(root):
        for name in names:
            joint(root, f"{side}_{name}").set("type", "fixed")

    return edit


def with_eight_joints(side):
    """Split the shin: a second and a third knee below the first."""

    def edit(root):
        for k in (2, 3):
            extra = copy.deepcopy(joint(root, f"{side}_knee"))
            extra.set("name", f"{side}_knee_{k}")
            extra.find("parent").set("link", f"{side}_shin_{k}")
            extra.find("origin").set("xyz", "0 0 0")
            half = copy.deepcopy(link(root, f"{side}_shin"))
            half.set("name", f"{side}_shin_{k}")
            joint(root, f"{side}_knee").find("child").set("link", f"{side}_shin_{k}")
            root.extend([half, extra])

    return edit


def one_legged(root):
    parts = ("hip_yaw_link", "hip_roll_link", "thigh", "shin", "ankle", "foot", "sole")
    joints = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll", "sole_joint")
    removed(root, *(f"left_{name}" for name in (*parts, *joints)))


def torso_only(root):
    for element in list(root):
        if element.tag in ("link", "joint") and element.get("name") != "torso":
            root.remove(element)


LOOP = appended(
    "<joint name='brace' type='fixed'><parent link='left_shin'/><child link='right_shin'/></joint>"
)
HIP = "left_hip_pitch"

DAMAGE = {
    "negative mass": (
        on("link", "left_shin", "inertial/mass", value="-3"),
        r"line \d+: link 'left_shin': the mass is -3 kg; it must be above 0; correct it",
    ),
    "zero mass": (
        on("link", "left_shin", "inertial/mass", value="0"),
        r"line \d+: link 'left_shin': the mass is 0 kg, but .*; the mass must be above 0",
    ),
    "mass is text": (
        on("link", "left_shin", "inertial/mass", value="3 kg"),
        r"line \d+: link 'left_shin': mass is '3 kg'; it must be a finite number \[kg\]",
    ),
    "mass is missing": (
        on("link", "left_shin", "inertial/mass", value=None),
        r"line \d+: link 'left_shin': no mass is given; add it \[kg\]",
    ),
    "inertia is not a number": (
        on("link", "left_foot", "inertial/inertia", iyy="nan"),
        r"line \d+: link 'left_foot': iyy is 'nan'; it must be a finite number \[kg·m²\]",
    ),
    "negative inertia": (
        on("link", "left_foot", "inertial/inertia", iyy="-0.01"),
        r"line \d+: link 'left_foot': the inertia is not positive definite: .* check the signs",
    ),
    "impossible inertia": (
        on("link", "left_foot", "inertial/inertia", iyy="0.5"),
        r"line \d+: link 'left_foot': the inertia cannot belong to a body of positive mass",
    ),
    "zero axis": (
        on("joint", HIP, "axis", xyz="0 0 0"),
        rf"line \d+: joint '{HIP}': its axis is 0 0 0; it needs a direction, as 0 1 0; correct it",
    ),
    "origin is not a number": (
        on("joint", HIP, "origin", xyz="0 nan 0"),
        rf"line \d+: joint '{HIP}': the xyz of its origin is '0 nan 0'; .*; correct it",
    ),
    "no limit": (
        without("joint", HIP, "limit"),
        rf"line \d+: joint '{HIP}': it has no limits; add <limit effort",
    ),
    "negative torque limit": (
        on("joint", HIP, "limit", effort="-150"),
        rf"line \d+: joint '{HIP}': the effort limit is '-150'; .* give it \[N.m\]",
    ),
    "speed limit is text": (
        on("joint", HIP, "limit", velocity="fast"),
        rf"line \d+: joint '{HIP}': the velocity limit is 'fast', .* give it \[rad/s\]",
    ),
    "empty range": (
        on("joint", HIP, "limit", lower="1", upper="-1"),
        rf"line \d+: joint '{HIP}': the range is from 1 to -1 rad; lower must be below upper",
    ),
    "mimic in a leg": (both(mimic), r"line \d+: joint '(left|right)_knee': its <mimic> cannot be"),
    "floating joint in a leg": (
        both(lambda side: on("joint", f"{side}_knee", ".", type="floating")),
        r"line \d+: joint '(left|right)_knee': its type is floating; only revolute",
    ),
    "prismatic joint in a leg": (
        both(lambda side: on("joint", f"{side}_knee", ".", type="prismatic")),
        r"joint '(left|right)_knee' is prismatic; gaitopt needs two legs of four to seven",
    ),
    "unknown joint type": (
        on("joint", HIP, ".", type="hinge"),
        rf"line \d+: joint '{HIP}': its type is 'hinge'; it must be one of revolute",
    ),
    "legs of three joints": (
        both(lambda side: stiff(side, "hip_yaw", "knee", "ankle_roll")),
        r"the chain that ends in '\w+' has 3 joints of its own.* two legs of four to seven",
    ),
    "legs of eight joints": (
        both(with_eight_joints), r"the chain that ends in '\w+' has 8 joints of its own"
    ),
    "legs without a knee": (
        both(lambda side: stiff(side, "knee")),
        r"the chain that ends in '\w+' cannot put a foot flat at a step: it has no knee",
    ),
    "legs without ankles": (
        both(lambda side: stiff(side, "ankle_pitch", "ankle_roll")),
        r"cannot put a foot flat at a step: it has no knee between hip and ankle; its",
    ),
    "one leg with a joint less": (
        stiff("left", "ankle_roll"),
        r"the chain that ends in 'left_sole' has 5 joints of its own.*; the other has 6",
    ),
    "torques differ": (
        set_limit("left_knee", effort=140.0),
        r"the torque limits of 'right_knee' and 'left_knee', 150 and 140 N·m; give both legs ",
    ),
    "ranges differ": (
        set_limit("left_knee", upper=2.0),
        r"the ranges of 'right_knee' and 'left_knee', 0 to 2.6 rad and 0 to 2 rad \(mirrored\); ",
    ),
    "lengths differ": (
        on("joint", "left_ankle_pitch", "origin", xyz="0.019 0.03 -0.29"),
        r"joints 'right_ankle_pitch' and 'left_ankle_pitch': \d+\.\d mm .* feet \d.*asymmetry = ",
    ),
    "masses differ": (
        scale_mass("left_shin", 1.5),
        r"links moved by 'right_knee' and 'left_knee': 875 g in mass, .*asymmetry = 0\.0\d+ in",
    ),
    "two links of one name": (
        on("link", "left_shin", ".", name="left_thigh"),
        r"line \d+: link 'left_thigh': another link has this name \(line \d+\); rename one",
    ),
    "two joints of one name": (
        on("joint", "left_knee", ".", name="right_knee"),
        r"line \d+: joint '\w+_knee': another joint has this name \(line \d+\); rename one",
    ),
    "missing link": (
        lambda root: removed(root, "left_shin"),
        r"line \d+: joint 'left_knee': its child link 'left_shin' does not exist; .*add that link",
    ),
    "two roots": (
        lambda root: removed(root, "left_knee"),
        r"link '\w+': no joint leads to it, and none to '\w+'; a robot has one root link",
    ),
    "loop": (
        LOOP, r"line \d+: joint 'brace': its child link 'right_shin' already hangs on .*right_knee"
    ),
    "one leg": (one_legged, r"no two legs were found: one chain of 6 joints, which ends in"),
    "no legs": (torso_only, "no two legs were found"),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_refused_in_words(name, capfd):
    edit, message = DAMAGE[name]
    with pytest.raises(RobotError, match=message) as refusal:
        Robot.from_urdf(edited_urdf(edit))
    assert "Traceback" not in str(refusal.value)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", DAMAGE)
def test_the_command_line_refuses_it_in_the_same_words(name, tmp_path):
    edit, message = DAMAGE[name]
    path = tmp_path / "damaged.urdf"
    path.write_text(edited_urdf(edit), encoding="utf-8")
    result = CliRunner().invoke(app, ["optimise", "--urdf", str(path), "--speed", "0.5"])
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.stderr.split()))
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the robot is empty text; give a URDF, or the path of a file"),
        ("<robot name='a'><link name='b'></robot>", "not well-formed XML: line 1, column 3"),
        ("<robot name='a'/>", "the URDF has no <link>; it describes no robot"),
        (
            "<html><body/></html>",
            r"the file holds <html>, not a URDF \(<robot>\) or MJCF \(<mujoco>\); give one",
        ),
        ("<robot name='a'><link name='b'/></robot>", "no two legs were found"),
    ],
)
def test_text_that_is_no_robot_is_refused(text, message, capfd):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(text)
    assert capfd.readouterr().err == ""


def test_feet_of_nothing_ask_for_a_sole(capfd):
    def edit(root):
        for side in SIDES:
            foot = link(root, f"{side}_foot")
            for element in [*foot.findall("collision"), *foot.findall("visual")]:
                foot.remove(element)

    with pytest.raises(RobotError, match=r"give .*sole"):
        Robot.from_urdf(edited_urdf(edit))
    assert capfd.readouterr().err == ""


def test_feet_whose_meshes_xacro_would_name_are_told_what_to_run():
    shape = "<geometry><mesh filename='$(find talos)/foot.stl'/></geometry>"

    def edit(root):
        for side in SIDES:
            foot = link(root, f"{side}_foot")
            for element in [*foot.findall("collision"), *foot.findall("visual")]:
                foot.remove(element)
            foot.append(ET.fromstring(f"<collision>{shape}</collision>"))

    told = r"\$\(find talos\)/foot.stl' .* is named by a macro of xacro; expand the xacro macros"
    with pytest.raises(RobotError, match=told):
        Robot.from_urdf(edited_urdf(edit))


def test_a_dead_mesh_does_not_stop_reading(robot, capfd):
    mesh = "<visual><geometry><mesh filename='package://lost/foot.stl'/></geometry></visual>"
    text = edited_urdf(lambda root: link(root, "left_shin").append(ET.fromstring(mesh)))
    assert Robot.from_urdf(text).sole == robot.sole
    (problem,) = read_source(text).mesh_problems()
    assert str(problem) == (
        "link 'left_shin': the visual mesh 'package://lost/foot.stl' was not found; give the "
        "directory that holds its package (--package-dir DIR; in Python package_dirs), or "
        "correct the path"
    )
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(("attribute", "field"), [("effort", "torque"), ("velocity", "speed")])
def test_a_limit_of_nearly_nothing_is_refused(attribute, field):
    edit = both(lambda side: on("joint", f"{side}_knee", "limit", **{attribute: "1e-200"}))
    with pytest.raises(RobotError, match=f"the {field} limit of 'left_knee' is 1e-200 .* between"):
        Robot.from_urdf(edited_urdf(edit))


@pytest.mark.parametrize(("attribute", "field"), [("effort", "torque"), ("velocity", "speed")])
def test_a_limit_that_is_not_given_is_told(attribute, field, capfd):
    edit = both(lambda side: on("joint", f"{side}_knee", "limit", **{attribute: None}))
    robot = Robot.from_urdf(edited_urdf(edit))
    told = [f for f in robot.findings if f.how == "warning" and "left_knee" in f.subject]
    assert [f.topic for f in told] == ["limits"]
    assert f"{field} limit" in told[0].text
    assert capfd.readouterr().err == ""
