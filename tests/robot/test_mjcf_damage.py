"""MJCF robots that are wrong in one way: each is refused in words, at its line."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from mjcf_edits import added, at, edited, together
from mjcf_text import mjcf_text
from places import CASES
from typer.testing import CliRunner

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.cli.app import app
from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot

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
MUJOCO, NO_NUMBER = "MuJoCo refuses it: ", "; it must be finite; correct it"
LARGE = r"; its numbers must be below 1e\+09; correct it"
MASS, FEW = "mass and inertia of moving bodies must be larger", "does not have enough data"
LEGS = "a leg: every leg joint has its own motor; remove that <{}>; gaitopt needs two legs of four"
DAMAGE = {
    "negative mass": (inertial(mass="-3"), SHIN, f"{SHIN_SAYS}{MUJOCO}{MASS}"),
    "zero mass": (inertial(mass="0"), SHIN, f"{SHIN_SAYS}{MUJOCO}{MASS}"),
    "mass is nan": (inertial(mass="nan"), "nan", f"<inertial>: its mass is 'nan'{NO_NUMBER}"),
    "mass is missing": (inertial(mass=None), "<inertial", "required attribute missing: 'mass'"),
    "negative inertias": (
        all_inertias, "pelvis", f"body 'pelvis': {MUJOCO}.*inertia must have positive eigenvalues"
    ),
    "inertia is nan": (
        inertial(fullinertia="nan 1 1 0 0 0"), "nan", f"fullinertia is 'nan 1 1 0 0 0'{NO_NUMBER}"
    ),
    "inertia of five numbers": (
        inertial(fullinertia="1 1 1 0 0"), "1 1 1 0 0", f"{MUJOCO}attribute 'fullinertia' {FEW}"
    ),
    "impossible inertia": (
        inertial(fullinertia="1 1 1 0 0 2"), SHIN, f"{SHIN_SAYS}.*inertia must have positive"
    ),
    "impossible moments": (
        inertial(fullinertia=None, diaginertia="0.1 0.1 0.5"), SHIN,
        rf"{SHIN_SAYS}{MUJOCO}inertia must satisfy A \+ B >= C; use 'balanceinertia' to fix",
    ),
    "moments are two": (
        inertial(fullinertia=None, diaginertia="0.1 0.1"), "0.1 0.1", f"'diaginertia' {FEW}"
    ),
    "two inertias": (inertial(diaginertia="1 1 1"), SHIN, f"{SHIN_SAYS}.*cannot both be specified"),
    "centre of mass is nan": (inertial(pos="0 nan 0"), "nan", f"its pos is '0 nan 0'{NO_NUMBER}"),
    "mass of a geometry": (
        without_inertia("size='0.1' mass='-1'"), "-1", f"<geom>: {MUJOCO}mass, inertia or density"
    ),
    "size of a geometry": (
        without_inertia("type='box' size='1'"), "box", f"<geom>: {MUJOCO}size 1 must be positive"
    ),
    "size is zero": (geom(size="0.1 0 0.1"), "0.1 0 0.1", f"{MUJOCO}size 1 must be positive"),
    "size is nan": (geom(size="nan 1 1"), "nan", f"<geom>: its size is 'nan 1 1'{NO_NUMBER}"),
    "place is infinite": (geom(pos="-inf 0 0"), "ankle_roll", "geoms or sites is not finite"),
    "place is too far": (geom(pos="0 1e200 0"), "1e200", f"<geom>: its pos is '0 1e200 0'{LARGE}"),
    "turned by a large number": (
        body(quat="0 1e200 0 0"), "1e200", f"{SHIN_SAYS}its quat is '0 1e200 0 0'{LARGE}"
    ),
    "axis of the root is too long": (
        together(
            lambda root: setattr(root.find(".//freejoint"), "tag", "joint"),
            at(".//body/joint", type="slide", axis="1e200 0 0"),
        ),
        "1e200", f"joint 'floating': its axis is '1e200 0 0'{LARGE}",
    ),
    "size is negative": (geom(size="1 -1 1"), "-1", f"{MUJOCO}size 1 must be positive in geom"),
    "range is text": (joint(range="a 1"), "a 1", f"{KNEE_SAYS}{MUJOCO}bad format in .*'range'"),
    "range is half a number": (joint(range="0 2_6"), "2_6", f"{KNEE_SAYS}{MUJOCO}bad format in"),
    "range is nan": (joint(range="nan 1"), "nan 1", f"{KNEE_SAYS}its range is 'nan 1'{NO_NUMBER}"),
    "range of one": (joint(range="1"), "knee", f"{KNEE_SAYS}{MUJOCO}attribute 'range' {FEW}"),
    "range upside down": (
        joint(range="2 1", limited="true"), "2 1", f"{KNEE_SAYS}.*should be smaller than range.1."
    ),
    "range of a class": (
        together(in_class("joint", range="2 1", limited="true"), joint(range=None)), KNEE,
        f"{KNEE_SAYS}{MUJOCO}range.0. should be smaller than range.1. in joint",
    ),
    "range begins at infinity": (
        joint(range="inf inf", limited="true"), "inf inf", f"{KNEE_SAYS}.*smaller"
    ),
    "class with a range of text": (
        in_class("joint", range="low high"), "low high", f"<joint>: {MUJOCO}bad format"
    ),
    "class with an armature below zero": (
        in_class("joint", armature="-0.1"), KNEE, f"{KNEE_SAYS}its armature, .* may not be below 0"
    ),
    "armature of a ship": (
        joint(armature="1e4"), "1e4", f"{KNEE_SAYS}its armature is 10000 kg·m²; at most 1000 kg·m²"
    ),
    "damping of a planet": (
        joint(damping="1e200"), "1e200", rf"{KNEE_SAYS}its damping is 1e\+200; it must be below 1e"
    ),
    "friction of a planet": (
        joint(frictionloss="1e9"), "1e9", f"{KNEE_SAYS}its frictionloss is 1e.09; it must be below"
    ),
    "spring of a planet": (
        joint(stiffness="1e200"), "1e200", f"{KNEE_SAYS}its stiffness is 1e.200; it must be below"
    ),
    "ref of many turns": (joint(ref="1e200"), "1e200", f"{KNEE_SAYS}its ref is 1e.200; it must"),
    "armature is nan": (joint(armature="nan"), "nan", f"{KNEE_SAYS}its armature is 'nan'"),
    "armature is infinite": (joint(armature="inf"), "inf", f"{KNEE_SAYS}not all of its numbers"),
    "damping is text": (joint(damping="low"), "low", f"{KNEE_SAYS}{MUJOCO}.*attribute 'damping'"),
    "friction below zero": (joint(frictionloss="-1"), "-1", f"{KNEE_SAYS}.*may not be below 0"),
    "ref is text": (joint(ref="zero"), "zero", f"{KNEE_SAYS}{MUJOCO}bad format in attribute 'ref'"),
    "torque is nan": (
        joint(actuatorfrcrange="-9 nan"), "nan", f"{KNEE_SAYS}its actuatorfrcrange is '-9 nan'"
    ),
    "torque to one side": (
        motor(forcerange="9 20"), "", f"{KNEE_SAYS}its motors give from 18 to 40 N·m, which does "
        r"not reach to both sides of 0; .*; or give a torque: \[\[limits\]\]",
    ),
    "motor upside down": (
        motor(forcerange="9 -9", forcelimited="true"), "9 -9", f"'{KNEE}_motor': {MUJOCO}"
    ),
    "motor range of one": (motor(ctrlrange="9"), "9", f"{KNEE}_motor.*'ctrlrange' {FEW}"),
    "gear is text": (motor(gear="big"), "big", f"motor '{KNEE}_motor': {MUJOCO}bad format in"),
    "motor of no joint": (motor(joint="knee"), '"knee"', "unknown transmission target 'knee'"),
    "axis is too long": (
        joint(axis="1e300 1 0"), "1e300", f"{KNEE_SAYS}its axis is '1e300 1 0'{LARGE}"
    ),
    "axis is nan": (joint(axis="nan 0 1"), "nan", f"{KNEE_SAYS}its axis is 'nan 0 1'{NO_NUMBER}"),
    "axis is zero": (joint(axis="0 0 0"), "0 0 0", f"{KNEE_SAYS}{MUJOCO}axis too small in joint"),
    "body in a frame far away": (
        added("worldbody", "<frame pos='1e10 0 0'><body/></frame>"), "1e10",
        f"<frame>: its pos is '1e10 0 0'{LARGE}",
    ),
    "joint at nan": (joint(pos="0 0 nan"), "nan", f"{KNEE_SAYS}its pos is '0 0 nan'{NO_NUMBER}"),
    "turned by zero": (body(quat="0 0 0 0"), "0 0 0 0", f"{SHIN_SAYS}{MUJOCO}zero quaternion"),
    "turned by three": (body(quat="1 0 0"), "1 0 0", f"{SHIN_SAYS}{MUJOCO}attribute 'quat' {FEW}"),
    "turned by two": (body(quat=None, euler="0 1"), "0 1", f"{SHIN_SAYS}{MUJOCO}.*'euler' {FEW}"),
    "turned about nothing": (
        body(quat=None, axisangle="0 0 0 1"), "0 0 0 1", f"{SHIN_SAYS}.*axisangle too small"
    ),
    "turned into a line": (
        body(quat=None, xyaxes="1 0 0 2 0 0"), "2 0 0", f"{SHIN_SAYS}.*yaxis too small"
    ),
    "body at nan": (body(pos="nan 0 0"), "nan", f"{SHIN_SAYS}its pos is 'nan 0 0'{NO_NUMBER}"),
    "body at infinity": (body(pos="inf 0 0"), "inf", f"{SHIN_SAYS}"),
    "body at two": (body(pos="0 0"), '"0 0"', f"{SHIN_SAYS}{MUJOCO}attribute 'pos' {FEW}"),
    "two bodies of one name": (
        body(name="pelvis"), '"pelvis"', f"body 'pelvis': {MUJOCO}repeated name 'pelvis'"
    ),
    "two joints of one name": (
        joint(name="left_hip_yaw"), "", f"{MUJOCO}repeated name 'left_hip_yaw' in joint"
    ),
    "unknown limited": (joint(actuatorfrclimited="no"), '"no"', f"{KNEE_SAYS}{MUJOCO}invalid key"),
    "unknown angle": (at("compiler", angle="grad"), "grad", f"{MUJOCO}invalid keyword: 'grad'"),
    "unknown joint type": (joint(type="knee"), '"knee"', f"{KNEE_SAYS}{MUJOCO}invalid keyword"),
    "unknown shape": (geom(type="cone"), "cone", f"<geom>: {MUJOCO}invalid keyword: 'cone'"),
    "unknown attribute": (joint(axes="0 0 1"), "axes", f"{KNEE_SAYS}.*unrecognized attribute"),
    "keyframe of another robot": (
        added(".", f"<keyframe><key name='home' qpos='{'0 ' * 30}'/></keyframe>"), "home",
        "key 'home': MuJoCo refuses it: keyframe 'home': invalid qpos size",
    ),
    "copies without end": (
        added(".//body", "<replicate count='9999999'><site/></replicate>"), "9999999",
        "<replicate>: its count, .*; at most 10000 are made; lower it",
    ),
    "joints that are tied": (
        tied("<joint joint1='left_knee' joint2='right_knee' polycoef='0 1 2e3 0 0'/>"),
        "<joint joint1",
        "<joint> of 'left_knee' and 'right_knee' in <equality> ties it: a coefficient is 2000; "
        "allowed are 1000 to either side of 0",
    ),
    "joint that is held": (
        tied("<joint joint1='right_knee'/>"), "joint1", "joint 'right_knee': <joint> of 'right_kn"
    ),
    "joints on a tendon": (
        together(
            added(
                ".", "<tendon><fixed name='t'><joint joint='left_knee' coef='1'/></fixed></tendon>"
            ),
            tied("<tendon tendon1='t'/>"),
        ),
        "tendon1", f"{KNEE_SAYS}<tendon> of 't' in <equality>",
    ),
    "feet that are connected": (
        tied(
            "<connect body1='left_ankle_roll_body' body2='right_ankle_roll_body' anchor='0 0 0'/>"
        ),
        "connect", "<connect> of 'left_ankle_roll_body' and .* ties it, a loop of bodies that "
        "cannot be reduced to motors: it joins both legs. Leave all loops of bodies open by "
        "--without loops: .* --linkages FILE",
    ),
    "foot that is welded": (
        tied("<weld body1='left_ankle_roll_body'/>"), "weld", r"joint 'left_\w+': <weld> of 'left_a"
    ),
    "tied to nothing": (
        tied("<weld body1='toe'/>"), "toe", f"<weld>: {MUJOCO}unknown element 'toe' in equality"
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


def without_place(error):
    return re.sub(r"^line \d+( of '[^']*')?: |(?<=, )line \d+", "", str(error))


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_told_of_the_same_element_where_lines_do_not_tell(sound, tmp_path, name):
    """All of the file on one line, or in another file: MuJoCo says where by lines alone."""
    text = edited(sound, DAMAGE[name][0])
    (tmp_path / "robot.xml").write_text(text)
    whole = tmp_path / "whole.xml"
    whole.write_text("<mujoco><include file='robot.xml'/></mujoco>")
    refusals = []
    for robot in (text, " ".join(text.splitlines()), whole):
        with pytest.raises(RobotError) as refusal:
            Robot.from_urdf(robot)
        refusals.append(without_place(refusal.value))
    assert refusals == refusals[:1] * 3


@pytest.mark.parametrize(("levels", "read"), [(280, True), (300, False), (100_000, False)])
def test_elements_in_elements_are_read_as_deep_as_a_robot_may_need(sound, levels, read):
    deep = "<body>" * levels + "</body>" * levels
    text = sound.replace("</worldbody>", f"{deep}\n</worldbody>")
    if read:
        assert read_source(text).model().nq
        return
    with pytest.raises(RobotError, match=r"line \d+: <body>: it lies in 300 other elements"):
        read_source(text)


def test_the_command_line_refuses_it_in_the_same_words(sound, tmp_path):
    path = tmp_path / "damaged.xml"
    path.write_text(edited(sound, joint(range="0 2_6")), encoding="utf-8")
    result = CliRunner().invoke(app, ["optimise", "--urdf", str(path), "--speed", "0.5"])
    assert result.exit_code == 2
    told = "joint 'left_knee': MuJoCo refuses it: bad format in attribute 'range'"
    assert told in " ".join(result.stderr.split())
    assert "Traceback" not in result.output


ARMS = "".join(
    f"<body name='{side}_arm' pos='0 {y} 0.3'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
    f"<joint name='{side}_shoulder' axis='0 1 0' range='-1 1'/><site name='{side}_hand'/></body>"
    for side, y in (("left", 0.3), ("right", -0.3))
)


@pytest.mark.parametrize(
    ("tie", "told"),
    [
        ("<joint joint1='left_shoulder' joint2='right_shoulder'/>", 1),
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
    kind = "tied" if tie.startswith("<joint") else "loop"
    assert [p.kind for p in problems] == [kind] * told
    assert all(p.name.endswith("_shoulder") for p in problems)
    assert Robot.from_urdf(text).joint_names[0].startswith("right_")


def test_a_loop_may_be_left_open(sound):
    """The advice works: the legs are those of the file without its loop."""
    tie = tied("<connect body1='left_ankle_roll_body' body2='left_knee_body' anchor='.1 0 0'/>")
    text = edited(sound, tie)
    held = "it holds 'left_ankle_pitch', which opens it by 0.1 m per rad: .* --without loops"
    with pytest.raises(RobotError, match=held):
        Robot.from_urdf(text)
    robot = Robot.from_urdf(text, choices=ImportOptions(without=("loops",)))
    assert len(robot.joint_names) == 12


def test_a_default_may_switch_equalities_off(sound):
    tie = tied("<joint joint1='left_knee'/>")
    off = added(".", "<default><equality active='false'/></default>")
    assert len(read_source(edited(sound, tie)).problems) == 1
    assert read_source(edited(sound, together(tie, off))).problems == ()


@pytest.mark.parametrize(
    "name", ["axis", "pos", "armature", "damping", "frictionloss", "stiffness", "ref", "springref"]
)
def test_numbers_of_the_root_are_finite_though_they_do_not_count(name):
    """What holds the pelvis in the file is left out, but nobody means infinity."""
    root = ET.fromstring((CASES / "mj_root6.xml").read_text())
    joint = root.find(".//joint[@name='rot']")
    joint.set(name, "inf 0 1" if name in ("axis", "pos") else "inf")
    with pytest.raises(RobotError, match="joint 'rot': not all of its numbers are finite"):
        Robot.from_urdf(ET.tostring(root, "unicode"))


def test_a_body_of_nothing_needs_one_fixed_to_it(sound):
    def edit(root):
        shin = root.find(f".//body[@name='{SHIN}']")
        shin.remove(shin.find("inertial"))

    with pytest.raises(RobotError, match=f"{SHIN_SAYS}{MUJOCO}{MASS}"):
        read_source(edited(sound, edit))
    fixed = "<body name='shell'><geom size='0.05'/></body>"
    shell = added(f".//body[@name='{SHIN}']", fixed)
    assert read_source(edited(sound, together(edit, shell))).problems == ()


@pytest.mark.parametrize(
    "edit",
    [
        at("worldbody/geom", size="1e10 1e10 1", pos="0 0 -1e12"),
        added("worldbody", "<light pos='0 0 1e10'/>", "<geom type='box' size='1 1 1e10'/>"),
        added(f".//body[@name='{SHIN}']", "<camera pos='1e10 0 0'/>"),
        motor(ctrlrange="-1e10 1e10"),
        added("worldbody", "<frame pos='1e10 0 0'><geom size='1e10' pos='0 1e200 0'/></frame>"),
        together(
            added(".", "<asset><hfield name='field' nrow='2' ncol='2' size='1e10 1 1 1'/></asset>"),
            added("worldbody", "<geom type='hfield' hfield='field'/>"),
        ),
    ],
)
def test_ground_lights_and_ranges_may_be_large(sound, edit):
    assert read_source(edited(sound, edit)).problems == ()


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (joint(range="60 -5"), "its range 60 to -5 is upside down: to MuJoCo, it has none"),
        (motor(forcerange="9 -9"), "its forcerange 9 to -9 is upside down: to MuJoCo, none"),
        (at("option", density="1.2"), "the drag of the medium in <option> is left out"),
        (motor(forcerange="-9 20"), "its motors give from -18 to 40 N·m; a walk keeps the smaller"),
    ],
)
def test_what_mujoco_passes_over_is_told(sound, edit, told):
    text = edited(sound, together(added(".", "<option/>"), edit))
    assert any(told in finding.text for finding in read_source(text).findings())


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


BASE = (CASES / "base_mini.xml").read_text(encoding="utf-8")
BAD_MASS = "body 'left_knee_link': MuJoCo refuses it: mass and inertia of moving bodies"


@pytest.mark.parametrize(
    ("edit", "told", "advice", "remedy"),
    [
        (
            at(".//joint[@name='left_knee']", range="0 2_3"),
            "joint 'left_knee': MuJoCo refuses it: bad format in attribute 'range' (it is '0 2_3')",
            "write numbers in digits 0 to 9",
            at(".//joint[@name='left_knee']", range="0 2.3"),
        ),
        (
            at(".//body[@name='left_knee_link']/inertial", mass="0"),
            BAD_MASS,
            "above 1e-15 kg and kg·m²: give the body an <inertial> with mass and diaginertia",
            at(".//body[@name='left_knee_link']/inertial", mass="2.5"),
        ),
        (
            at(".//body[@name='left_knee_link']/inertial", diaginertia="0.02 0.02 0.1"),
            "body 'left_knee_link': MuJoCo refuses it: inertia must satisfy A + B >= C",
            'the sum of the other two: correct it, or write <compiler balanceinertia="true"/>',
            at("compiler", balanceinertia="true"),
        ),
        (
            lambda root: root.insert(0, ET.ProcessingInstruction("pi", "x")),
            "XML_ERROR_PARSING_DECLARATION",
            "remove <?...?> there",
            lambda root: root.remove(root[0]),
        ),
    ],
)
def test_advice_on_what_mujoco_refuses_works(edit, told, advice, remedy):
    with pytest.raises(RobotError, match=r"^line \d+: ") as caught:
        read_source(edited(BASE, edit))
    assert told in str(caught.value)
    assert advice in str(caught.value)
    assert read_source(edited(BASE, together(edit, remedy))).model().njoints == 14


def test_a_file_of_another_name_is_told_how_to_be_called(tmp_path):
    (tmp_path / "robot.txt").write_text(BASE, encoding="utf-8")
    with pytest.raises(RobotError, match=r"give the file a name that ends in \.xml"):
        read_source(tmp_path / "robot.txt")
    (tmp_path / "robot.txt").rename(tmp_path / "robot.xml")
    assert read_source(tmp_path / "robot.xml").model().njoints == 14
