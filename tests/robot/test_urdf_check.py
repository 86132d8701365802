"""The checks that loaders of URDFs do not make."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from example_robots import BIPEDS, example_robot, needs_example_robots
from urdf_edits import add_arm, edited_urdf, joint, link

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import refuse_unsound
from gaitopt.importers.reader import read_source
from gaitopt.importers.urdf_check import check_urdf
from gaitopt.importers.xml_document import parse_xml
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.robot import Robot

TEXT = urdf_text(biped13())


def edited(pattern, replacement):
    text, count = re.subn(pattern, replacement, TEXT, count=1)
    assert count == 1
    return text


def checked(text):
    return check_urdf(parse_xml(text)).problems


def line_of(text, part):
    return 1 + text[: text.index(part)].count("\n")


def test_a_sound_urdf_has_no_problems():
    assert checked(TEXT) == ()


FATAL = {
    r"link 'torso': the mass is -40\.55 kg; it must be above 0": (
        'mass value="40.55"', 'mass value="-40.55"'
    ),
    r"link 'torso': mass is 'nan'; it must be a finite number \[kg\]": (
        'mass value="40.55"', 'mass value="nan"'
    ),
    r"link 'torso': mass is 'heavy'; it must be a finite number": (
        'mass value="40.55"', 'mass value="heavy"'
    ),
    r"link 'torso': no mass is given; add it \[kg\]": ('<mass value="40.55" />', ""),
    r"link 'torso': no ixx is given; add it \[kg·m²\]": (r'ixx="[^"]*" ', ""),
    r"link 'torso': the xyz of its centre of mass is '0 nan 1'; it must be three": (
        r'(<inertial>\s*<origin) xyz="[^"]*"', r'\1 xyz="0 nan 1"'
    ),
    r"joint 'left_hip_yaw': the xyz of its origin is '0 0'; it must be three finite": (
        r'(joint name="left_hip_yaw"(.|\n)*?<origin) xyz="[^"]*"', r'\1 xyz="0 0"'
    ),
    r"joint 'left_hip_yaw': the rpy of its origin is 'inf 0 0'": (
        r'(joint name="left_hip_yaw"(.|\n)*?) rpy="[^"]*"', r'\1 rpy="inf 0 0"'
    ),
    r"joint 'left_hip_yaw': its axis is 0 0 0; it needs a direction": (
        'axis xyz="0 0 1"', 'axis xyz="0 0 0"'
    ),
    r"joint 'left_hip_yaw': its axis is 'nan 0 1'; it must be three finite numbers": (
        'axis xyz="0 0 1"', 'axis xyz="nan 0 1"'
    ),
    r"joint 'left_hip_yaw': its axis is ''; it must be three finite numbers": (
        'axis xyz="0 0 1"', "axis"
    ),
    r"joint 'left_hip_yaw': its type is 'hinge'; it must be one of revolute, continuous": (
        'type="revolute"', 'type="hinge"'
    ),
    r"joint 'left_hip_yaw': its type is None; it must be one of": (' type="revolute"', ""),
    r"line \d+: a joint has no name; give it one": ('joint name="left_hip_yaw"', "joint"),
    r"line \d+: a link has no name; give it one": ('link name="torso"', 'link name=" "'),
    r"link 'torso': another link has this name \(line \d+\); rename one of them": (
        'link name="left_thigh"', 'link name="torso"'
    ),
    r"joint 'left_knee': another joint has this name": (
        'joint name="left_hip_yaw"', 'joint name="left_knee"'
    ),
    r"joint 'left_hip_yaw': its parent link 'body' does not exist; add that link": (
        'parent link="torso"', 'parent link="body"'
    ),
    r"joint 'left_hip_yaw': no parent link is given; add <parent link": (
        '<parent link="torso" />', ""
    ),
    r"joint 'left_hip_yaw': no child link is given": ('child link="left_hip_yaw_link"', "child"),
    r"joint 'left_hip_roll': its child link 'left_hip_yaw_link' already hangs on joint": (
        'child link="left_hip_roll_link"', 'child link="left_hip_yaw_link"'
    ),
    r"not well-formed XML: line \d+, column \d+: .*; correct that line": ("</robot>", ""),
    r"mismatched tag": ("</link>", "</lnk>"),
    r"the file holds <html>, not a URDF": (r"(.|\n)*", "<html/>"),
    r"the URDF has no <link>; it describes no robot": (r"(.|\n)*", "<robot/>"),
}  # fmt: skip


@pytest.mark.parametrize("message", FATAL)
def test_what_leaves_no_robot_is_refused(message, capfd):
    with pytest.raises(RobotError, match=message):
        checked(edited(*FATAL[message]))
    assert capfd.readouterr().err == ""


def test_messages_lead_to_the_line():
    text = edited('mass value="40.55"', 'mass value="-40.55"')
    with pytest.raises(RobotError, match=rf"^line {line_of(text, '-40.55')}: link 'torso'"):
        checked(text)


def test_a_second_root_is_refused():
    text = edited_urdf(lambda root: root.append(ET.fromstring("<link name='lost'/>")))
    with pytest.raises(RobotError, match=r"link 'lost': no joint leads to it.*'torso'.*one root"):
        checked(text)


def test_a_loop_is_refused():
    def edit(root):
        for a, b in ("pq", "qp"):
            root.append(ET.fromstring(f"<link name='{a}'/>"))
            ends = f"<parent link='{a}'/><child link='{b}'/>"
            root.append(ET.fromstring(f"<joint name='{a}{b}' type='fixed'>{ends}</joint>"))

    with pytest.raises(
        RobotError, match=r"joint 'qp': it is part of a loop of joints \('p', 'q'\)"
    ):
        checked(edited_urdf(edit))


def test_a_loop_of_everything_is_refused():
    def edit(root):
        ends = "<parent link='left_sole'/><child link='torso'/>"
        root.append(ET.fromstring(f"<joint name='back' type='fixed'>{ends}</joint>"))

    with pytest.raises(RobotError, match=r"it is part of a loop of joints \('torso', .* more\)"):
        checked(edited_urdf(edit))


INERTIA = {
    "the inertia is not positive definite: its principal moments are -": (
        r'ixx="1\.5', 'ixx="-1.5'
    ),
    "the inertia cannot belong to a body of positive mass": (r'ixx="1\.5', 'ixx="100.5'),
    "the mass is 0 kg, but its principal moments are": ('mass value="40.55"', 'mass value="0"'),
}  # fmt: skip


@pytest.mark.parametrize("message", INERTIA)
def test_bodies_that_cannot_be_are_problems(message):
    text = edited(*INERTIA[message])
    (problem,) = checked(text)
    assert (problem.kind, problem.name) == ("inertia", "torso")
    assert problem.line == line_of(text, "<inertial>")
    assert str(problem).startswith(f"line {problem.line}: link 'torso': {message}")


@pytest.mark.parametrize("message", INERTIA)
def test_bodies_that_cannot_be_are_refused_in_a_robot(message):
    source = read_source(edited(*INERTIA[message]))
    with pytest.raises(RobotError, match=f"link 'torso': {message}"):
        refuse_unsound(source.model(), source.problems)


def test_a_strange_hand_on_a_sound_trunk_is_let_be():
    def edit(root):
        add_arm(root)
        link(root, "arm").find("inertial/inertia").set("izz", "0.05")

    source = read_source(edited_urdf(edit))
    assert [(p.kind, p.name) for p in source.problems] == [("inertia", "arm")]
    model = source.model()
    locked = pin.buildReducedModel(model, [model.getJointId("shoulder")], pin.neutral(model))
    refuse_unsound(locked, source.problems)
    with pytest.raises(RobotError, match="link 'arm': the inertia cannot belong"):
        refuse_unsound(model, source.problems)


def test_a_body_at_fault_without_a_known_link_is_named_by_its_joint():
    model = read_source(TEXT).model()
    knee = model.getJointId("left_knee")
    thin = np.diag([1.0, 1.0, 3.0])
    model.inertias[knee] = pin.Inertia(2.0, np.zeros(3), thin)
    with pytest.raises(RobotError, match="the body moved by joint 'left_knee': the inertia cannot"):
        refuse_unsound(model, ())


@pytest.mark.parametrize("inertial", ["", "<inertial><mass value='0'/>{zero}</inertial>"])
def test_links_that_weigh_nothing_are_told(inertial):
    zero = "<inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/>"

    def edit(root):
        add_arm(root)
        arm = link(root, "arm")
        arm.remove(arm.find("inertial"))
        if inertial:
            arm.append(ET.fromstring(inertial.format(zero=zero)))

    text = edited_urdf(edit)
    (problem,) = checked(text)
    assert (problem.kind, problem.name) == ("massless", "arm")
    assert "link 'arm': a joint moves it, but it has no mass" in str(problem)
    assert Robot.from_urdf(text).mass == pytest.approx(Robot.from_urdf(edited_urdf(_same)).mass)


def _same(root):
    """An edit of nothing."""


def without_inertia(*names):
    """An edit that leaves links without mass; all of them if none is named."""

    def edit(root):
        for element in root.findall("link"):
            inertial = element.find("inertial")
            if inertial is not None and (not names or element.get("name") in names):
                element.remove(inertial)

    return edit


FEET = ("left_foot", "right_foot")


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ((), "joint 'left_hip_yaw' moves no mass: .* so on for 9 more.*give the links of the legs"),
        (FEET, r"joint 'left_ankle_roll' moves no mass: .*\(the same holds for right_ankle_roll\)"),
    ],
)
def test_a_joint_that_moves_no_mass_is_refused(names, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(without_inertia(*names)))


def test_a_link_without_mass_between_others_is_let_be(robot):
    light = Robot.from_urdf(
        edited_urdf(without_inertia("left_hip_roll_link", "right_hip_roll_link"))
    )
    assert 0.0 < light.mass < robot.mass - 0.1


@pytest.mark.parametrize(
    ("attribute", "value", "name"),
    [
        ("value", "1e300", r"mass is '1e300'"),
        ("ixx", "-1e9", r"ixx is '-1e9'"),
        ("xyz", "0 1e200 0", r"xyz of its .* is '0 1e200 0'"),
        ("rpy", "1e300 0 0", r"rpy of its .* is '1e300 0 0'"),
        ("rpy", "1e300 0 x", r"rpy of its .* is '1e300 0 x'"),
    ],
)
def test_numbers_of_no_robot_are_refused(attribute, value, name, capfd):
    text = re.sub(rf'\b{attribute}="[^"]*"', f'{attribute}="{value}"', urdf_text(biped13()))
    hint = " in digits 0 to 9" if "x" in value else r"( \[.*\])?; correct it"
    says = rf"line \d+: .*{name}; it must be .* below 1e\+09{hint}"
    with pytest.raises(RobotError, match=says):
        Robot.from_urdf(text)
    assert capfd.readouterr().err == ""


def test_a_shape_of_no_size_is_left_out_in_words(robot):
    text = re.sub('<sphere radius="[^"]*"', '<sphere radius="1e200"', urdf_text(biped13()), count=1)
    odd = Robot.from_urdf(text)
    (told,) = (f.text for f in odd.findings if "1e200" in f.text)
    assert "must be a finite number below 1e+09 [m]" in told
    assert told.endswith(": it is left out")
    assert odd.mass == robot.mass


def test_a_chain_of_too_many_joints_is_refused():
    parts = ["<link name='l0'/>"]
    for k in range(1, 400):
        ends = f"<parent link='l{k - 1}'/><child link='l{k}'/>"
        kind = "fixed" if k <= 50 else "continuous"
        parts.append(f"<link name='l{k}'/><joint name='j{k}' type='{kind}'>{ends}</joint>")
    with pytest.raises(RobotError, match="has 349 joints that move; at most 300 can be read; make"):
        checked(f"<robot name='snake'>{''.join(parts)}</robot>")


def test_a_robot_without_a_name_is_refused_by_its_line():
    text = urdf_text(biped13()).replace(' name="biped13"', "", 1)
    with pytest.raises(
        RobotError, match=r"^line \d+: <robot> has no name; give it one, as <robot n"
    ):
        checked(text)


def test_a_massless_link_that_carries_a_heavy_one_is_sound():
    def edit(root):
        add_arm(root)
        arm = link(root, "arm")
        hand = ET.SubElement(root, "link", name="hand")
        hand.append(arm.find("inertial"))
        arm.remove(arm.find("inertial"))
        ends = "<parent link='arm'/><child link='hand'/>"
        root.append(ET.fromstring(f"<joint name='wrist' type='fixed'>{ends}</joint>"))

    assert checked(edited_urdf(edit)) == ()


def test_a_point_mass_and_a_bare_frame_are_sound():
    def edit(root):
        moments = link(root, "left_foot").find("inertial/inertia").attrib
        moments.update(dict.fromkeys(moments, "0"))

    assert checked(edited_urdf(edit)) == ()


def limits(**values):
    """An edit that changes or removes attributes of the left knee's limit."""

    def edit(root):
        limit = joint(root, "left_knee").find("limit")
        for name, value in values.items():
            limit.attrib.pop(name)
            if value is not None:
                limit.set(name, value)

    return edit


def no_limit(root):
    knee = joint(root, "left_knee")
    knee.remove(knee.find("limit"))


def slides(root):
    joint(root, "left_knee").set("type", "prismatic")
    limits(effort="0", upper="-3")(root)


def mimics(root):
    ET.SubElement(joint(root, "left_knee"), "mimic", joint="right_knee", multiplier="nan")


def floats(root):
    joint(root, "left_knee").set("type", "floating")


@pytest.mark.parametrize(
    ("edit", "kinds", "message"),
    [
        (no_limit, ["effort", "velocity", "range"], "it has no limits; add <limit effort"),
        (limits(effort=None), ["effort"], r"the effort limit is not given; give it \[N.m\]"),
        (limits(velocity="0"), ["velocity"], r"the velocity limit is '0'; .*give it \[rad/s\]"),
        (limits(velocity="inf"), ["velocity"], "the velocity limit is 'inf'; it must be above 0"),
        (limits(lower="3"), ["range"], r"the range is from 3 to 2\.6 rad; lower must be below"),
        (slides, ["effort", "range"], r"give it \[N\]$"),
        (mimics, ["mimic"], "its <mimic> cannot be followed: its multiplier and"),
        (floats, ["free"], "its type is floating; only revolute joints are moved"),
    ],
)
def test_joints_that_would_be_wrong_in_a_leg(edit, kinds, message):
    text = edited_urdf(edit)
    problems = checked(text)
    assert [p.kind for p in problems] == kinds
    assert {p.name for p in problems} == {"left_knee"}
    assert re.search(f"^line {problems[0].line}: joint 'left_knee': .*{message}", str(problems[0]))
    with pytest.raises(RobotError, match="left_knee"):
        Robot.from_urdf(text)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (limits(effort="-150"), r"the effort limit is '-150'; it must be above 0; give it \[N.m\]"),
        (limits(velocity="fast"), r"the velocity limit is 'fast', which is no number; give it"),
        (limits(effort="2_5"), r"the effort limit is '2_5', which is no number in digits 0 to 9"),
        (limits(lower="low"), r"the lower limit is 'low', which is no number; give it \[rad\]"),
    ],
)
def test_limits_that_no_loader_takes_are_refused(edit, message):
    with pytest.raises(RobotError, match=rf"^line \d+: joint 'left_knee': {message}"):
        checked(edited_urdf(edit))


@pytest.mark.parametrize(("upper", "refused"), [(2.0, False), (None, True)])
def test_a_range_that_was_given_otherwise_is_no_problem(upper, refused):
    lower = None if upper is None else 0.0
    given = LimitOverride("*_knee", torque=100.0, speed=8.0, lower=lower, upper=upper)
    text = edited_urdf(limits(lower="3"))
    if refused:
        with pytest.raises(RobotError, match=r"^line \d+: joint 'left_knee': the range is from 3"):
            Robot.from_urdf(text, choices=ImportOptions(limits=(given,)))
    else:
        robot = Robot.from_urdf(text, choices=ImportOptions(limits=(given,)))
        assert robot.limits.upper[robot.legs.knees[1]] == upper


@needs_example_robots
@pytest.mark.parametrize("path", BIPEDS)
def test_bipeds_of_others_pass(path):
    problems = checked(example_robot(path).read_text(encoding="utf-8"))
    kinds = {p.kind for p in problems}
    assert kinds <= {"inertia", "massless", "tied", "effort", "velocity", "placeholder"}
    # Inertias of 1, 1, 1 kg·m² from 0.4 to 30 kg, and a root link of 4.72 kg that has none.
    assert ("placeholder" in kinds) is ("simple_humanoid" in path or "icub" in path)
    # These two are known for bodies that cannot be, the others for none in their legs.
    legs = [p.name for p in problems if re.search(r"[hH]ip", p.name) and p.kind == "inertia"]
    assert legs == (["LHipPitch_link", "RHipPitch_link"] if "romeo_laas" in path else [])


def spoilt(text, *pairs):
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return text


@pytest.mark.parametrize(
    ("pairs", "faults"),
    [
        pytest.param(
            [('mass value="40.55"', 'mass value="4_0"'), ('lower="-1"', 'lower="-1,0"')],
            [r"link 'torso': mass is '4_0'", "lower limit is '-1,0'"],
            id="numbers of a link and a joint",
        ),
        pytest.param(
            [('mass value="40.55"', 'mass vlaue="40.55"'), ('lower="-1"', 'lower="low"')],
            ["<mass> has vlaue=, which is not known", "lower limit is 'low'"],
            id="misspelt, and not missed once more",
        ),
        pytest.param(
            [('type="revolute"', 'type="Revolute"'), ('parent link="torso"', 'parent link="tors"')],
            ["its type is 'Revolute'", "parent link 'tors' does not exist"],
            id="type and parent",
        ),
    ],
)
def test_faults_of_a_file_are_told_at_once(pairs, faults):
    with pytest.raises(RobotError) as caught:
        checked(spoilt(TEXT, *pairs))
    told = str(caught.value)
    assert told.startswith(f"{len(faults)} faults keep this robot from being used: (1) line ")
    for number, fault in enumerate(faults, 1):
        assert re.search(rf"\({number}\) line \d+: [^;]*{fault}", told)


def test_all_impossible_bodies_are_told_at_once():
    def spoil(root):
        for name in ("left_shin", "right_thigh", "torso"):
            inertia = link(root, name).find("inertial/inertia")
            inertia.set("ixx", "900")

    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(edited_urdf(spoil))
    told = str(caught.value)
    for name in ("left_shin", "right_thigh", "torso"):
        assert re.search(rf"\(\d\) line \d+: link '{name}': the inertia cannot belong to", told)


def test_legs_that_weigh_nothing_beside_the_trunk_are_refused_by_their_mass():
    text = edited(r'mass value="40\.55"', 'mass value="4.055e8"')
    with pytest.raises(RobotError, match=r"legs carry mass, but of 4\.055e\+08 kg, .* the trunk"):
        Robot.from_urdf(text)
