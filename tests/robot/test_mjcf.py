"""Reading robots from MJCF: they must move as their URDF does."""

from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from mesh_files import TETRAHEDRON, sorted_rows, write_stl
from mjcf_text import mjcf_text
from motion_twins import same_motion

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import RobotError
from gaitopt.importers.mjcf_compile import whole_mjcf
from gaitopt.importers.reader import read_source
from gaitopt.importers.xml_document import parse_xml

COLLISION = pin.GeometryType.COLLISION


@pytest.fixture(scope="module")
def model():
    return read_source(urdf_text(biped13())).model()


@pytest.mark.parametrize("freejoint", [True, False])
def test_mjcf_moves_as_the_urdf_does(tmp_path, model, rng, freejoint):
    path = tmp_path / "biped.xml"
    path.write_text(mjcf_text(model, freejoint=freejoint), encoding="utf-8")
    source = read_source(path)
    twin = source.model()
    assert source.format == "mjcf"
    assert twin.joints[1].shortname() == "JointModelFreeFlyer"
    assert same_motion(twin, model, rng)
    np.testing.assert_allclose(twin.effortLimit[6:], model.effortLimit[6:])
    np.testing.assert_allclose(twin.lowerPositionLimit[7:], model.lowerPositionLimit[7:])
    assert np.isinf(twin.velocityLimit[6:]).all()
    assert same_motion(read_source(source.text).model(), model, rng)


def test_mjcf_is_read_with_what_it_includes(tmp_path, model, rng):
    whole = ET.fromstring(mjcf_text(model))
    for part in ("worldbody", "actuator"):
        element = whole.find(part)
        file = tmp_path / "parts" / f"{part}.xml"
        file.parent.mkdir(exist_ok=True)
        included = ET.Element("mujocoinclude")
        included.append(element)
        file.write_text(ET.tostring(included, encoding="unicode"), encoding="utf-8")
        whole.remove(element)
        ET.SubElement(whole, "include", file=f"parts/{part}.xml")
    ET.SubElement(ET.SubElement(whole, "worldbody"), "light", name="sun")
    path = tmp_path / "biped.xml"
    path.write_text(ET.tostring(whole, encoding="unicode"), encoding="utf-8")
    source = read_source(path)
    assert same_motion(source.model(), model, rng)
    np.testing.assert_allclose(source.model().effortLimit[6:], model.effortLimit[6:])
    assert same_motion(read_source(source.text).model(), model, rng)
    with pytest.raises(
        RobotError, match=r"line \d+: cannot include 'parts/.*': it is read as text"
    ):
        read_source(path.read_text(encoding="utf-8"))


def test_mjcf_meshes(tmp_path, model):
    write_stl(tmp_path / "assets" / "foot.stl")
    root = ET.fromstring(mjcf_text(model, foot_geom="type='mesh' mesh='foot'"))
    root.find("compiler").set("meshdir", "assets")
    asset = ET.SubElement(root, "asset")
    ET.SubElement(asset, "mesh", file="foot.stl", scale="2 1 1")
    path = tmp_path / "biped.xml"
    path.write_text(ET.tostring(root, encoding="unicode"), encoding="utf-8")
    source = read_source(path)
    body = "left_ankle_roll_body"
    (item,) = source.geometry(COLLISION, {body}).geometryObjects
    np.testing.assert_allclose(
        sorted_rows(item.geometry.vertices()), sorted_rows(TETRAHEDRON * [2.0, 1.0, 1.0])
    )
    (tmp_path / "assets" / "foot.stl").unlink()
    assert [(p.link, p.file) for p in source.mesh_problems()] == [
        (body, "assets/foot.stl"),
        ("right_ankle_roll_body", "assets/foot.stl"),
    ]
    assert source.geometry(COLLISION) is None
    assert source.model().nv == model.nv


CHAIN = """<mujoco><compiler angle='radian' autolimits='true'/>
<default><default class='hip'><joint armature='0.02' actuatorfrcrange='-50 50'/>
 <motor ctrlrange='-3 3' gear='10'/></default></default>
<worldbody><body name='ball'><geom size='1'/></body>
<body name='pelvis'><freejoint/><inertial pos='0 0 0' mass='3' diaginertia='0.1 0.2 0.2'/>
 <body name='leg' pos='0 0.1 -0.2' childclass='hip'>
  <inertial pos='0.1 0.2 -0.3' mass='2' diaginertia='0.1 0.1 0.15'/>
  <joint name='yaw' axis='0 0 1' pos='0 0.05 0' range='-1 1' ref='0.25'/>
  <joint name='roll' axis='1 0 0'/><joint name='pitch' axis='0 1 0' pos='0 0 0.1'/>
  <site name='tip' pos='0 0 -0.5'/>
 </body></body></worldbody>
<actuator><motor joint='yaw' class='hip'/><position joint='roll' forcerange='-20 20'/>
</actuator></mujoco>"""


def test_mjcf_bodies_may_have_several_joints():
    model = read_source(CHAIN).model()
    assert list(model.names[2:]) == ["yaw", "roll", "pitch"]
    assert [joint.nv for joint in model.joints][2:] == [1, 1, 1]
    assert pin.computeTotalMass(model) == pytest.approx(5.0)
    q = np.concatenate([pin.neutral(model)[:7], [0.3, -0.4, 0.5]])
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)

    def turned(angle, axis, at):
        R = pin.AngleAxis(angle, np.array(axis, dtype=float)).toRotationMatrix()
        at = np.array(at)
        return pin.SE3(R, at - R @ at)

    expected = (
        pin.SE3(np.eye(3), np.array([0.0, 0.1, -0.2]))
        * turned(0.3 - 0.25, [0, 0, 1], [0.0, 0.05, 0.0])  # ref is 0.25
        * turned(-0.4, [1, 0, 0], [0.0, 0.0, 0.0])
        * turned(0.5, [0, 1, 0], [0.0, 0.0, 0.1])
    )
    np.testing.assert_allclose(
        data.oMf[model.getFrameId("tip")].translation, expected.act(np.array([0, 0, -0.5]))
    )


def test_mjcf_limits_come_from_classes_and_actuators():
    model = read_source(CHAIN).model()
    np.testing.assert_allclose(model.effortLimit[6:], [30.0, 20.0, 50.0])
    np.testing.assert_allclose(model.armature[6:], 0.02)
    # The file calls its own posture 0.25 rad; coordinates are MuJoCo's.
    assert (model.lowerPositionLimit[7], model.upperPositionLimit[7]) == (-1.0, 1.0)
    assert read_source(CHAIN).drawn_posture == {"yaw": 0.25}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass='2'", "mass='-2'", "line 6: body 'leg': MuJoCo refuses it: mass and inertia"),
        ("'0.1 0.1 0.15'", "'0.1 -0.1 0.15'", "line 6: body 'leg': .*inertia must satisfy A"),
        ("mass='2'", "", r"line 7: <inertial>: .*required attribute missing: 'mass'"),
        ("axis='1 0 0'", "axis='0 0 0'", "line 9: joint 'roll': .*axis too small in joint"),
        ("<body name='leg'", "<body name='pelvis'", "line 6: body 'pelvis': .*repeated name"),
        ("class='hip'/>", "class='knee'/>", "line 12: motor of joint 'yaw': .*class name 'knee'"),
    ],
)
def test_what_mujoco_refuses_is_refused_in_its_words(old, new, message):
    assert CHAIN.count(old) >= 1
    text = CHAIN.replace(old, new)
    with pytest.raises(RobotError, match=message):
        read_source(text).model()


INCLUDED = """<mujocoinclude>
<!-- the left
leg -->
 <body name='leg'
       pos='0 0.1 -0.2'>
  <inertial pos='0 0 0'
            mass='{mass}' diaginertia='0.1 0.1 0.15'/>
  <joint name='yaw' axis='{axis}' class='{kind}'/>
 </body>{more}
</mujocoinclude>"""
MAIN = """<mujoco><!-- two
lines --><compiler angle='radian'/><default><joint damping='1'/><default class='hip'/></default>
<worldbody><body name='pelvis'><freejoint/>
<inertial pos='0 0 0' mass='3' diaginertia='1 1 1'/>
<include file='parts/leg.xml'/></body></worldbody></mujoco>"""


def with_parts(folder, **changes):
    values = {"mass": "2", "axis": "0 0 1", "kind": "hip", "more": "", **changes}
    (folder / "parts").mkdir()
    (folder / "parts" / "leg.xml").write_text(INCLUDED.format(**values), encoding="utf-8")
    path = folder / "robot.xml"
    path.write_text(MAIN, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": "-2"}, "line 4 of 'parts/leg.xml': body 'leg': MuJoCo refuses it: mass"),
        ({"axis": "0 0 0"}, "line 8 of 'parts/leg.xml': joint 'yaw': .*axis too small"),
        ({"kind": "knee"}, "line 8 of 'parts/leg.xml': joint 'yaw': .*class name 'knee'"),
        ({"more": "</body>"}, "the included file 'parts/leg.xml' is not well-formed XML: line 9"),
        (
            {"more": "<include file='parts/leg.xml'/>"},
            r"line 9 of 'parts/leg.xml': cannot include 'parts/leg.xml': too many levels",
        ),
        (
            {"more": "<include file='parts/arm.xml'/>"},
            r"line \d+ of '.*': cannot read the included file '.*arm.xml': no such file",
        ),
    ],
)
def test_what_is_wrong_in_an_included_file_is_found_there(tmp_path, changes, message):
    with pytest.raises(RobotError, match=rf"^{message}"):
        read_source(with_parts(tmp_path, **changes))


def test_lines_are_those_of_the_file(tmp_path):
    path = with_parts(tmp_path)
    path.write_text(MAIN.replace("mass='3'", "mass='x'"), encoding="utf-8")
    with pytest.raises(
        RobotError, match=r"^line 4: <inertial>: MuJoCo refuses it: bad format in attribute 'mass'"
    ):
        read_source(path)


def test_what_is_read_is_left_as_it_was(tmp_path):
    path = with_parts(tmp_path)
    tree = parse_xml(path.read_text(encoding="utf-8"))
    before = ET.tostring(tree.root)
    whole = whole_mjcf(tree, tmp_path)
    assert ET.tostring(tree.root) == before != ET.tostring(whole.root)
