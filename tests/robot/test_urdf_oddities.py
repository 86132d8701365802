"""What is odd in a URDF: refused by line where motion depends on it, told where it does not."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from places import CASES
from urdf_edits import edited_urdf, joint, link

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot

COLLISION, VISUAL = pin.GeometryType.COLLISION, pin.GeometryType.VISUAL


def kinds(source, *left_out):
    return [p.kind for p in source.problems if p.kind not in left_out]


DOUBLED = {
    "inertial": ("link", "torso"),
    "inertial/mass": ("link", "torso"),
    "inertial/inertia": ("link", "torso"),
    "inertial/origin": ("link", "torso"),
    "origin": ("joint", "left_knee"),
    "parent": ("joint", "left_knee"),
    "child": ("joint", "left_knee"),
    "axis": ("joint", "left_knee"),
    "limit": ("joint", "left_knee"),
}


@pytest.mark.parametrize("path", DOUBLED)
@pytest.mark.parametrize("apart", [True, False])
def test_what_is_there_twice_is_refused_with_both_lines(path, apart):
    tag, name = DOUBLED[path]

    def edit(root):
        owner = {"link": link, "joint": joint}[tag](root, name)
        above, _, last = path.rpartition("/")
        parent = owner.find(above) if above else owner
        twin = ET.fromstring(ET.tostring(parent.find(last)))
        if apart:
            twin.attrib.update(dict.fromkeys(twin.attrib, "1 1 1"))
        twin.tail = "\n\n"
        parent.append(twin)

    last = path.rpartition("/")[2]
    text = edited_urdf(edit)
    with pytest.raises(
        RobotError,
        match=rf"^line \d+: {tag} '{name}': it has 2 <{last}> \(lines \d+ and \d+\); one",
    ) as refusal:
        read_source(text)
    lines = [int(n) for n in re.search(r"lines (\d+) and (\d+)", str(refusal.value)).groups()]
    assert all(f"<{last}" in text.splitlines()[line - 1] for line in lines)


def test_two_inertials_of_a_file_are_refused():
    with pytest.raises(RobotError, match=r"link 'base': it has 2 <inertial>"):
        read_source(CASES / "urdf_two_inertials.urdf")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<inertial>", "<inertail>", "<inertail> is not known; write <inertial>"),
        ("<Inertial>", "<Inertial>", "<Inertial> is not known; write <inertial>"),
        ("<limit ", "<limits ", "<limits> is not known; write <limit>"),
        ("<axis ", "<axes ", "<axes> is not known; write <axis>"),
        ('<axis xyz="0 0 1"', '<axis xzy="0 0 1"', "<axis> has xzy=, which is not known"),
        (' rpy="', ' ryp="', "<origin> has ryp=, which is not known; write rpy="),
        (' lower="', ' Lower="', "<limit> has Lower=, which is not known; write lower="),
        (' ixy="', ' iyx="', "<inertia> has iyx=, which is not known; write ixy="),
    ],
)
def test_what_motion_depends_on_is_refused_misspelt(old, new, message):
    text = edited_urdf(lambda root: None)
    if old == "<Inertial>":
        old = "<inertial>"
    closing = old.rstrip().replace("<", "</") if old.startswith("<in") else ""
    text = text.replace(old, new, 1)
    if closing:
        text = text.replace(closing, new.replace("<", "</"), 1)
    with pytest.raises(RobotError, match=re.escape(message)):
        read_source(text)


def test_what_only_the_eye_misses_is_told_misspelt():
    def edit(root):
        link(root, "torso").append(ET.fromstring("<collsion><geometry/></collsion>"))
        link(root, "torso").append(ET.fromstring("<contact/>"))

    (problem,) = read_source(edited_urdf(edit)).problems
    assert problem.kind == "unknown"
    assert "<collsion> is not known; write <collision>" in str(problem)


def with_ear(name, kind):
    """The generated biped with an ear on a joint of some name."""

    def edit(root):
        mass = "<mass value='0.3'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4' {}/>"
        rest = "ixy='0' ixz='0' iyz='0'"
        inertial = f"<inertial>{mass.format(rest)}</inertial>"
        root.append(ET.fromstring(f"<link name='ear'>{inertial}</link>"))
        ends = "<parent link='torso'/><child link='ear'/><origin xyz='0 0 0.7'/>"
        limit = "<limit effort='1' velocity='1' lower='-1' upper='1'/>"
        root.append(ET.fromstring(f"<joint name='{name}' type='{kind}'>{ends}{limit}</joint>"))

    return edited_urdf(edit)


@pytest.mark.parametrize("name", ["universe", "root_joint"])
def test_joints_that_move_under_names_of_the_world_are_refused(name):
    with pytest.raises(RobotError, match=rf"^line \d+: joint '{name}': this name stands for"):
        read_source(with_ear(name, "revolute"))


@pytest.mark.parametrize("name", ["universe", "root_joint"])
def test_fixed_joints_may_have_names_of_the_world(name):
    plain, named = (Robot.from_urdf(with_ear(each, "fixed")) for each in ("lobe", name))
    assert named.mass == plain.mass == pytest.approx(57.17)
    assert named.model.inertias.tolist() == plain.model.inertias.tolist()


def test_a_world_on_a_floating_joint_may_have_any_name():
    def edit(root):
        root.insert(0, ET.fromstring("<link name='universe'/>"))
        ends = "<parent link='universe'/><child link='torso'/>"
        root.append(ET.fromstring(f"<joint name='root_joint' type='floating'>{ends}</joint>"))

    assert Robot.from_urdf(edited_urdf(edit)).mass == pytest.approx(56.87)


def test_a_link_named_as_the_world_and_a_leg_joint_are_refused():
    text = edited_urdf(lambda root: None).replace('"left_shin"', '"universe"')
    with pytest.raises(RobotError, match="link 'universe': this name stands for something else"):
        read_source(text)
    with pytest.raises(RobotError, match="line 423: joint 'universe': this name stands for"):
        read_source(CASES / "joint_universe.urdf")


def test_names_that_cannot_be_seen_are_told_and_read():
    text = edited_urdf(lambda root: None).replace('"left_shin"', '"left&#10;\u202eshin"')
    source = read_source(text)
    (problem,) = source.problems
    assert problem.kind == "name"
    assert str(problem).isprintable()
    assert r"link 'left\n\u202eshin': its name holds characters that cannot be seen" in str(problem)
    assert Robot.from_urdf(text).mass == pytest.approx(56.87)


def test_an_inertia_below_zero_by_rounding_is_read():
    path = CASES / "inertia_slack.urdf"
    assert Robot.from_urdf(path).mass == pytest.approx(56.87)
    model = read_source(path).model()
    shin = model.inertias[model.getJointId("left_knee")].inertia
    assert 0.0 < shin[2, 2] < 1e-10
    assert shin[0, 0] == pytest.approx(0.014058333333333334, rel=1e-12)


@pytest.mark.parametrize(
    "moments",
    [("0", "0.01", "0.01"), ("1e-17", "0.01", "0.01"), ("-1e-10", "0.01", "0.01"),
     ("0.01", "0.01", "0.0200000001"), ("0", "0", "0")],
)  # fmt: skip
@pytest.mark.parametrize("turn", ["0 0 0", "0.3 -0.2 0.7"])
def test_rods_plates_and_points_are_read(moments, turn):
    def edit(root):
        for side in ("left", "right"):
            inertial = link(root, f"{side}_foot").find("inertial")
            sign = 1.0 if side == "left" else -1.0
            roll, pitch, yaw = (float(word) for word in turn.split())
            inertial.find("origin").set("rpy", f"{sign * roll} {pitch} {sign * yaw}")
            tensor = dict(zip(("ixx", "iyy", "izz"), moments, strict=True))
            inertial.find("inertia").attrib.update(tensor, ixy="0", ixz="0", iyz="0")

    assert Robot.from_urdf(edited_urdf(edit)).mass == pytest.approx(56.87)


def test_one_inertia_for_all_is_a_placeholder():
    source = read_source(CASES / "urdf_unit_inertia.urdf")
    (problem,) = source.problems
    assert problem.kind == "placeholder"
    assert "link 'base': its inertia, 1, 1, 1 kg·m², is that of" in str(problem)
    assert "and 9 more too, though their masses go from 0.3 to 25 kg" in str(problem)
    (finding,) = source.findings()
    assert (finding.topic, finding.how) == ("inertia", "warning")
    assert "'left_ankle_roll_link': its inertia is 55.2 times the largest" in finding.text


def test_a_heavy_link_without_inertia_is_told():
    def edit(root):
        for name in ("torso", "left_foot"):
            moments = link(root, name).find("inertial/inertia").attrib
            moments.update(dict.fromkeys(moments, "0"))

    (problem,) = read_source(edited_urdf(edit)).problems
    assert (problem.kind, problem.name) == ("placeholder", "torso")
    assert "it has a mass of 40.55 kg but no inertia: a point mass?" in str(problem)


def test_one_body_for_most_links_is_a_placeholder():
    def edit(root):
        for inertial in root.iter("inertial"):
            inertial.find("mass").set("value", "1")
            inertial.find("inertia").attrib.update(ixx="1e-3", iyy="1e-3", izz="1e-3")

    (problem,) = read_source(edited_urdf(edit)).problems
    assert "and 9 more too, though these are most of all links: a placeholder?" in str(problem)


def test_links_that_are_alike_in_both_legs_are_no_placeholders():
    def edit(root):
        for name in ("left_ankle", "right_ankle", "left_hip_roll_link", "right_hip_roll_link"):
            link(root, name).find("inertial/inertia").attrib.update(
                ixx="1e-3", iyy="1e-3", izz="1e-3"
            )

    assert read_source(edited_urdf(edit)).problems == ()


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (30.0, True)])
def test_an_inertia_too_large_for_the_shape_is_told(factor, told):
    """A box has at most half of what its corners would; 30 times is beyond them."""

    def edit(root):
        for side in ("left", "right"):
            moments = link(root, f"{side}_foot").find("inertial/inertia").attrib
            moments.update({k: repr(factor * float(v)) for k, v in moments.items()})

    source = read_source(edited_urdf(edit))
    reading = import_robot(source, ImportOptions())
    large = [f for f in reading.findings if f.topic == "inertia"]
    assert [f.subject for f in large] == (["left_foot", "right_foot"] if told else [])
    assert all(
        "times the largest that a body of 1.64 kg within its shapes" in f.text for f in large
    )


def test_a_trunk_without_mass_is_told():
    def edit(root):
        torso = link(root, "torso")
        torso.remove(torso.find("inertial"))

    (problem,) = read_source(edited_urdf(edit)).problems
    assert (problem.kind, problem.name) == ("massless", "torso")
    assert "it is the root link, and neither it nor a link fixed to it has a mass" in str(problem)


def test_soft_limits_are_told_and_not_imposed():
    def edit(root):
        soft = ET.Element("safety_controller", soft_lower_limit="0.1", soft_upper_limit="2.5")
        joint(root, "left_knee").append(soft)

    source = read_source(edited_urdf(edit))
    (finding,) = source.findings()
    assert (finding.topic, finding.subject, finding.how) == ("limits", "left_knee", "warning")
    assert (
        "narrower ranges, which are not imposed here ('left_knee': 0.1 to 2.5 of 0 to 2.6 rad)"
        in (finding.text)
    )
    model = source.model()
    row = model.joints[model.getJointId("left_knee")].idx_q
    assert (model.lowerPositionLimit[row], model.upperPositionLimit[row]) == (0.0, 2.6)


@pytest.mark.parametrize("end", ["inf", "1e16", "1.7976931348623157e308"])
def test_soft_limits_of_any_size_are_none(end):
    def edit(root):
        soft = ET.Element("safety_controller", soft_lower_limit=f"-{end}", soft_upper_limit=end)
        joint(root, "left_knee").append(soft)

    source = read_source(edited_urdf(edit))
    assert (source.findings(), source.problems) == ((), ())


MATERIAL = "the material of its visual has no name; its colour is used"


def test_a_nameless_material_costs_its_name_alone(capfd):
    source = read_source(CASES / "unnamed_material.urdf")
    (problem,) = source.problems
    assert (problem.kind, problem.name, problem.line) == ("shape", "r3", 7)
    assert MATERIAL in problem.text
    assert "holds for 'r4' (line 9), 'r6' (line 13), 'l3' (line 19) and 2 more" in problem.text
    shapes = source.geometry(VISUAL)
    assert shapes.ngeoms == 6
    assert {tuple(np.round(s.meshColor, 6)) for s in shapes.geometryObjects} == {
        (0.1, 0.1, 0.1, 1.0)
    }
    assert capfd.readouterr() == ("", "")


BROKEN = {
    "<sphere radius='0'/>": "the sphere of its collision has radius 0 m; give both above 0",
    "<sphere radius='-1'/>": "the sphere of its collision has radius -1 m",
    "<sphere/>": "no radius of the sphere of its collision is given",
    "<cylinder radius='0' length='1'/>": "has radius 0 m and length 1 m",
    "<cylinder radius='1' length='-1'/>": "has radius 1 m and length -1 m",
    "<capsule radius='1'/>": "no length of the capsule of its collision is given",
    "<box size='1 1'/>": "the size of the box of its collision is '1 1'",
    "<box size='1 1 -1'/>": "the size of the box of its collision is '1 1 -1'",
    "<box size='1_0 1 1'/>": "the size of the box of its collision is '1_0 1 1'",
    "<mesh/>": "the mesh of its collision names no file",
    "<mesh filename='a.stl' scale='1 0 1'/>": "none may be 0",
    "<cone radius='1'/>": "the geometry of its collision has <cone>; it must be one of box, sphere",
    "<box size='1 1 1'/><sphere radius='1'/>": "has <box>, <sphere>; it must be one of",
    "": "the geometry of its collision has nothing",
}


@pytest.mark.parametrize("shape", BROKEN)
def test_a_broken_shape_costs_itself_and_is_told(shape, capfd):
    def edit(root):
        for text in (shape, "<box size='0.1 0.2 0'/>"):
            whole = f"<collision><geometry>{text}</geometry></collision>"
            link(root, "torso").append(ET.fromstring(whole))

    source = read_source(edited_urdf(edit))
    (problem,) = source.problems
    assert (problem.kind, problem.name) == ("shape", "torso")
    assert BROKEN[shape] in str(problem)
    assert str(problem).endswith("it is left out")
    (kept,) = source.geometry(COLLISION, {"torso"}).geometryObjects
    np.testing.assert_allclose(kept.geometry.halfSide, [0.05, 0.1, 0.0])
    assert Robot.from_urdf(source.text).mass == pytest.approx(56.87)
    assert capfd.readouterr() == ("", "")


def test_feet_without_a_sole_are_refused_with_the_shapes_that_were_left_out():
    text = (CASES / "base_mini.urdf").read_text().replace("0.24 0.12 0.02", "0.24 -0.12 0.02")
    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(text)
    said = str(caught.value)
    assert re.search(
        r"line \d+: link '\w+_ankle_roll_link': the size of the box of its collision", said
    )
    assert "'0.24 -0.12 0.02'" in said
    assert "(line 176); correct it, or give the sole rectangle" in said


def test_hips_that_lie_in_each_other_are_refused_with_what_to_do():
    text = (CASES / "base_mini.urdf").read_text().replace('xyz="0 0.1 0"', 'xyz="0 -0.1 0"')
    with pytest.raises(RobotError, match=r"less than 0\.1 mm apart to the side; correct"):
        Robot.from_urdf(text)


def test_a_mesh_of_an_unknown_format_is_as_a_missing_one(capfd):
    source = read_source(CASES / "wrl_mesh.urdf")
    (problem,) = source.mesh_problems()
    assert "visual mesh 'limb.wrl' is of a format that cannot be read (.wrl)" in str(problem)
    assert source.geometry(VISUAL) is None
    assert Robot.from_urdf(CASES / "wrl_mesh.urdf").mass == pytest.approx(37.6)
    assert capfd.readouterr() == ("", "")


UNREAD = {
    "safety": (
        '<safety_controller soft_lower_limit="1" soft_upper_limit="-1" k_velocity="1"/>',
        "soft limits from 1 to -1 rad; lower must be below upper: passed over",
    ),
    "unknown": (
        '<dynamics damping="0" spring_stiffness="20" spring_reference="0.1"/>',
        "<dynamics> has spring_stiffness and spring_reference, which a URDF does not know",
    ),
}


@pytest.mark.parametrize("kind", UNREAD)
def test_what_a_joint_says_in_vain_is_told(kind):
    element, told = UNREAD[kind]

    def edit(root):
        joint(root, "left_knee").append(ET.fromstring(element))

    source = read_source(edited_urdf(edit))
    (problem,) = [p for p in source.problems if p.kind == kind]
    assert problem.name == "left_knee"
    assert told in str(problem)
    robot = Robot.from_urdf(edited_urdf(edit))
    assert any(told in f.text and f.how == "warning" for f in robot.findings)


def test_an_axis_that_is_not_given_is_told():
    def edit(root):
        for side in ("left", "right"):
            moved = joint(root, f"{side}_hip_roll")
            assert moved.find("axis").get("xyz").split() == ["1", "0", "0"]
            moved.remove(moved.find("axis"))

    robot = Robot.from_urdf(edited_urdf(edit))
    told = [f.text for f in robot.findings if "it has no <axis>: taken as 1 0 0" in f.text]
    assert [text.split("'")[1] for text in told] == ["left_hip_roll", "right_hip_roll"]
    assert robot.model == Robot.from_urdf(edited_urdf(lambda root: None)).model
