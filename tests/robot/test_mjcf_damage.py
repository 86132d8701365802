"""MJCF robots that are wrong in one way: each is refused in words, at its line."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from mjcf_edits import added, at, edited, together
from mjcf_text import mjcf_text
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.errors import RobotError
from gaitopt.robot.files.source import read_source
from gaitopt.robot.generated.presets import biped13
from gaitopt.robot.generated.urdf import urdf_text
from gaitopt.robot.model import Robot

FOOT = "type='box' size='0.1 0.05 0.01' pos='0.05 0 -0.05'"
KNEE, SHIN = "left_knee", "left_knee_body"


@pytest.fixture(scope="module")
def sound():
    """The text of a sound biped."""
    return mjcf_text(read_source(urdf_text(biped13())).model(), foot_geom=FOOT)


def body(**values):
    return at(f".//body[@name='{SHIN}']", **values)


def inertial(**values):
    return at(f".//body[@name='{SHIN}']/inertial", **values)


def joint(**values):
    return at(f".//joint[@name='{KNEE}']", **values)


def motor(**values):
    return at(f".//motor[@name='{KNEE}_motor']", **values)


def geom(**values):
    return at(".//body/geom", **values)


def tied(text):
    return added(".", f"<equality>{text}</equality>")


def in_class(tag, **values):
    """An edit that gives the knee a class, and that class attributes of one kind of element."""
    numbers = " ".join(f"{key}='{value}'" for key, value in values.items())
    default = f"<default><default class='own'><{tag} {numbers}/></default></default>"
    return together(added(".", default), at(f".//{tag}[@name='{KNEE}']", **{"class": "own"}))


def without_inertia(shape):
    """An edit that leaves a geometry to say what the shin weighs."""

    def edit(root):
        shin = root.find(f".//body[@name='{SHIN}']")
        shin.remove(shin.find("inertial"))
        shin.append(ET.fromstring(f"<geom {shape}/>"))

    return edit


def all_inertias(root):
    for element in root.iter("inertial"):
        element.set("fullinertia", "-1 1 1 0 0 0")


SHIN_SAYS, KNEE_SAYS = f"body '{SHIN}': ", f"joint '{KNEE}': "
ANGLES = r"\[rad or degrees, as <compiler> says\]; correct it"
LEGS = "a leg: every leg joint has its own motor; remove that <{}>; gaitopt needs two legs of six"
DAMAGE = {
    "negative mass": (inertial(mass="-3"), "-3", f"{SHIN_SAYS}the mass is -3 kg; .* above 0"),
    "zero mass": (inertial(mass="0"), '"0"', f"{SHIN_SAYS}the mass is 0 kg, but .*above 0"),
    "mass is nan": (
        inertial(mass="nan"), "nan", rf"{SHIN_SAYS}the inertial's mass is 'nan'; .* \[kg\]; correct"
    ),
    "mass is missing": (
        inertial(mass=None), "<inertial", rf"{SHIN_SAYS}no mass is given; add it \[kg\]"
    ),
    "negative inertias": (
        all_inertias, "-1 1 1", "body 'pelvis': the inertia is not positive definite: .* -1, 1, 1"
    ),
    "inertia is nan": (
        inertial(fullinertia="nan 1 1 0 0 0"), "nan",
        rf"{SHIN_SAYS}the inertial's fullinertia is 'nan 1 1 0 0 0'; .* six finite .*\[kg·m²\]",
    ),
    "inertia of five numbers": (
        inertial(fullinertia="1 1 1 0 0"), "1 1 1 0 0", "fullinertia is '1 1 1 0 0'; .* six finite"
    ),
    "impossible inertia": (
        inertial(fullinertia="1 1 1 0 0 2"), "0 0 2", f"{SHIN_SAYS}the inertia is not positive"
    ),
    "impossible moments": (
        inertial(fullinertia=None, diaginertia="0.1 0.1 0.5"), "0.5",
        f"{SHIN_SAYS}the inertia cannot belong to a body of positive mass: .* 0.1, 0.1, 0.5 kg·m²",
    ),
    "moments are two": (
        inertial(fullinertia=None, diaginertia="0.1 0.1"), "0.1 0.1", "diaginertia is '0.1 0.1'"
    ),
    "two inertias": (inertial(diaginertia="1 1 1"), "<inertial", "both diaginertia and fullin"),
    "centre of mass is nan": (
        inertial(pos="0 nan 0"), "nan", rf"{SHIN_SAYS}the inertial's pos is '0 nan 0'; .*\[m\]"
    ),
    "mass of a geometry": (
        without_inertia("size='0.1' mass='-1'"), "-1", r"the geom's mass is '-1'; .*below 0 \[kg\]"
    ),
    "size of a geometry": (
        without_inertia("type='box' size='1'"), "box",
        rf"{SHIN_SAYS}the size of a geom of type box is '1'; it must begin with 3 above 0 \[m\]",
    ),
    "size is zero": (geom(size="0.1 0 0.1"), "0.1 0 0.1", "size of a geom of type box is '0.1 0 0"),
    "size is nan": (geom(size="nan 1 1"), "nan", r"geom's size is 'nan 1 1'; .* finite .*\[m\]"),
    "size is negative": (geom(size="1 -1 1"), "-1", r"geom's size is '1 -1 1'; .*below 0 \[m\]"),
    "range is text": (joint(range="a 1"), "a 1", rf"{KNEE_SAYS}its range is 'a 1'; .*{ANGLES}"),
    "range is nan": (joint(range="nan 1"), "nan 1", rf"{KNEE_SAYS}its range is 'nan 1'.*{ANGLES}"),
    "range is infinite": (joint(range="-inf inf"), "-inf", rf"its range is '-inf inf'; .*{ANGLES}"),
    "range of one": (joint(range="1"), "knee", rf"its range is '1'; .* two finite .*{ANGLES}"),
    "range is empty": (joint(range=""), 'range=""', rf"its range is ''; .* two finite .*{ANGLES}"),
    "range upside down": (
        joint(range="2 1"), "2 1",
        rf"{KNEE_SAYS}the range is from 2 to 1 rad; lower must be below upper; or give a range",
    ),
    "range in degrees": (
        together(at("compiler", angle="degree"), joint(range="60 -5")), "60 -5",
        rf"{KNEE_SAYS}the range is from 60 to -5 degrees; lower must be below upper",
    ),
    "range of a class": (
        together(in_class("joint", range="2 1"), joint(range=None)), KNEE,
        rf"{KNEE_SAYS}the range of its class is from 2 to 1 rad; lower must be below upper",
    ),
    "class with a range of text": (
        in_class("joint", range="low high"), "low high", "<joint>: its range is 'low high'"
    ),
    "class with an armature below zero": (
        in_class("joint", armature="-0.1"), "-0.1",
        "<joint>: its armature is '-0.1'; it must not be below 0",
    ),
    "armature is nan": (joint(armature="nan"), "nan", f"{KNEE_SAYS}its armature is 'nan'; .*a fin"),
    "damping is text": (joint(damping="low"), "low", f"{KNEE_SAYS}its damping is 'low'"),
    "friction below zero": (joint(frictionloss="-1"), "-1", f"{KNEE_SAYS}its frictionloss is '-1'"),
    "ref is text": (joint(ref="zero"), "zero", f"{KNEE_SAYS}its ref is 'zero'; .*{ANGLES}"),
    "torque is nan": (
        joint(actuatorfrcrange="-9 nan"), "nan", rf"{KNEE_SAYS}its actuatorfrcrange .* \[N·m or N\]"
    ),
    "motor upside down": (
        motor(forcerange="9 -9"), "9 -9", rf"motor '{KNEE}_motor': its forcerange is '9 -9'; .*N·m"
    ),
    "motor range of one": (motor(ctrlrange="9"), "9", f"'{KNEE}_motor': its ctrlrange is '9'"),
    "gear is text": (motor(gear="big"), "big", f"'{KNEE}_motor': its gear is 'big'; .*one to"),
    "motor of no joint": (
        motor(joint="knee"), '"knee"', "there is no joint 'knee' in the robot; correct the name"
    ),
    "axis is nan": (joint(axis="nan 0 1"), "nan", f"{KNEE_SAYS}its axis is 'nan 0 1'; .*three fin"),
    "axis is zero": (joint(axis="0 0 0"), "0 0 0", f"{KNEE_SAYS}its axis is 0 0 0; it needs a dir"),
    "joint at nan": (joint(pos="0 0 nan"), "nan", rf"{KNEE_SAYS}its pos is '0 0 nan'; .*\[m\]"),
    "turned by zero": (
        body(quat="0 0 0 0"), "0 0 0 0", f"{SHIN_SAYS}its quat is 0 0 0 0; it .*, as 1 0 0 0"
    ),
    "turned by three": (body(quat="1 0 0"), "1 0 0", f"{SHIN_SAYS}its quat is '1 0 0'; .*four fin"),
    "turned by two": (
        body(quat=None, euler="0 1"), "0 1", rf"{SHIN_SAYS}its euler is '0 1'; .*three .*{ANGLES}"
    ),
    "turned about nothing": (
        body(quat=None, axisangle="0 0 0 1"), "0 0 0 1", f"{SHIN_SAYS}its axisangle is 0 0 0 1; it"
    ),
    "turned into a line": (
        body(quat=None, xyaxes="1 0 0 2 0 0"), "2 0 0", f"{SHIN_SAYS}its xyaxes is .*two directions"
    ),
    "body at nan": (body(pos="nan 0 0"), "nan", rf"{SHIN_SAYS}its pos is 'nan 0 0'; .* \[m\]"),
    "body at two": (body(pos="0 0"), '"0 0"', rf"{SHIN_SAYS}its pos is '0 0'; .*three finite"),
    "two bodies of one name": (
        body(name="pelvis"), '"pelvis"', r"body 'pelvis': another body has this name \(line 5\)"
    ),
    "two joints of one name": (
        joint(name="left_hip_yaw"), "", r"joint 'left_hip_yaw': another joint has this name \(line"
    ),
    "sum of the masses": (
        at("compiler", settotalmass="50"), "settotalmass",
        "<compiler>: its settotalmass is 50 kg, which is not supported; scale the masses",
    ),
    "balanced inertias": (
        at("compiler", balanceinertia="true"), "balanceinertia",
        "<compiler>: its balanceinertia is 'true', which is not supported; correct the inertias",
    ),
    "unknown limited": (
        joint(actuatorfrclimited="no"), '"no"', f"{KNEE_SAYS}its actuatorfrclimited is 'no'; it mu"
    ),
    "unknown angle": (at("compiler", angle="grad"), "grad", "its angle is 'grad'; it must be 'ra"),
    "unknown joint type": (
        joint(type="knee"), '"knee"', f"{KNEE_SAYS}its type is 'knee'; it must be 'hinge' or 's"
    ),
    "unknown shape": (geom(type="cone"), "cone", "<geom>: its type is 'cone'; it must be 'sphere'"),
    "joints that are tied": (
        tied("<joint joint1='left_knee' joint2='right_knee'/>"), "<joint joint1",
        "<joint> of 'left_knee' and 'right_knee' in <equality> ties it, which is not supported in "
        + LEGS.format("joint"),
    ),
    "joint that is held": (
        tied("<joint joint1='right_knee'/>"), "joint1", "joint 'right_knee': <joint> of 'right_kn"
    ),
    "joints on a tendon": (
        together(
            added(".", "<tendon><fixed name='t'><joint joint='left_knee'/></fixed></tendon>"),
            tied("<tendon tendon1='t'/>"),
        ),
        "tendon1", f"{KNEE_SAYS}<tendon> of 't' in <equality>",
    ),
    "feet that are connected": (
        tied("<connect body1='left_ankle_roll_body' body2='right_ankle_roll_body'/>"),
        "connect", "<connect> of 'left_ankle_roll_body' and .*in " + LEGS.format("connect"),
    ),
    "foot that is welded": (
        tied("<weld body1='left_ankle_roll_body'/>"), "weld", r"joint 'left_\w+': <weld> of 'left_a"
    ),
    "tied to nothing": (
        tied("<weld body1='toe'/>"), "toe", "its body1 is 'toe', but there is no such body; correct"
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_refused_in_words_at_its_line(sound, name, capfd):
    edit, there, message = DAMAGE[name]
    text = edited(sound, edit)
    with pytest.raises(RobotError, match=rf"^line \d+: .*{message}") as refusal:
        Robot.from_urdf(text)
    line = int(re.match(r"line (\d+):", str(refusal.value)).group(1))
    assert there in text.splitlines()[line - 1]
    assert capfd.readouterr().err == ""


def test_the_command_line_refuses_it_in_the_same_words(sound, tmp_path):
    path = tmp_path / "damaged.xml"
    path.write_text(edited(sound, joint(range="nan 1")), encoding="utf-8")
    result = CliRunner().invoke(app, ["optimise", "--urdf", str(path), "--speed", "0.5"])
    assert result.exit_code == 2
    assert "joint 'left_knee': its range is 'nan 1'" in " ".join(result.stderr.split())
    assert "Traceback" not in result.output


ARMS = "".join(
    f"<body name='{side}_arm' pos='0 {y} 0.3'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
    f"<joint name='{side}_shoulder' axis='0 1 0' range='-1 1'/><site name='{side}_hand'/></body>"
    for side, y in (("left", 0.3), ("right", -0.3))
)


@pytest.mark.parametrize(
    ("tie", "told"),
    [
        ("<joint joint1='left_shoulder' joint2='right_shoulder'/>", 2),
        ("<connect body1='left_arm' body2='right_arm' anchor='0 0 0'/>", 2),
        ("<weld site1='left_hand' site2='right_hand'/>", 2),
        ("<weld body1='left_arm' body2='pelvis'/>", 1),
        ("<joint joint1='left_knee' joint2='right_knee' active='false'/>", 0),
    ],
)
def test_what_ties_no_leg_is_told(sound, tie, told):
    arms = ET.fromstring(f"<arms>{ARMS}</arms>")
    text = edited(sound, together(added(".//body", *map(ET.tostring, arms)), tied(tie)))
    problems = read_source(text).problems
    kind = "mimic" if tie.startswith("<joint") else "free"
    assert [p.kind for p in problems] == [kind] * told
    assert all(p.name.endswith("_shoulder") for p in problems)
    assert Robot.from_urdf(text).joint_names[0].startswith("right_")


def test_a_default_may_switch_equalities_off(sound):
    tie = tied("<joint joint1='left_knee' joint2='right_knee'/>")
    off = added(".", "<default><equality active='false'/></default>")
    assert len(read_source(edited(sound, tie)).problems) == 2
    assert read_source(edited(sound, together(tie, off))).problems == ()


def test_a_body_of_nothing_is_told(sound):
    def edit(root):
        shin = root.find(f".//body[@name='{SHIN}']")
        shin.remove(shin.find("inertial"))

    (problem,) = read_source(edited(sound, edit)).problems
    assert (problem.kind, problem.name) == ("massless", SHIN)
    fixed = "<body name='shell'><geom size='0.05'/></body>"
    shell = added(f".//body[@name='{SHIN}']", fixed)
    assert read_source(edited(sound, together(edit, shell))).problems == ()


def test_a_robot_in_degrees_is_the_same_wherever_it_says_so(sound):
    def edit(root):
        root.find("compiler").set("angle", "degree")
        for element in root.iter("joint"):
            ends = np.degrees([float(word) for word in element.get("range").split()])
            element.set("range", " ".join(map(repr, map(float, ends))))

    def last(root):
        compiler = root.find("compiler")
        root.remove(compiler)
        root.append(compiler)

    model = read_source(sound).model()
    twin = read_source(edited(sound, together(edit, last))).model()
    np.testing.assert_allclose(twin.lowerPositionLimit[7:], model.lowerPositionLimit[7:])
    np.testing.assert_allclose(twin.upperPositionLimit[7:], model.upperPositionLimit[7:])


@pytest.mark.parametrize(
    "turn", ["axisangle='0 0 2 0.3'", "axisangle='0 0 1 0.3'", "euler='0 0 0.3'"]
)
def test_directions_may_have_any_length(sound, turn):
    """All say the same: 0.3 rad about z."""
    key, value = turn.rstrip("'").split("='")
    model = read_source(edited(sound, body(quat=None, **{key: value}))).model()
    R = model.jointPlacements[model.getJointId(KNEE)].rotation
    np.testing.assert_allclose(
        R, [[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]], atol=1e-12
    )
