"""Reading robots from files of all kinds."""

import struct
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from example_robots import BIPEDS, example_robot, needs_example_robots
from mesh_files import TETRAHEDRON, sorted_rows, write_stl
from motion_twins import same_motion
from places import CASES
from urdf_edits import add_arm, edited_urdf, joint, link

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot

TEXT = urdf_text(biped13())
COLLISION, VISUAL = pin.GeometryType.COLLISION, pin.GeometryType.VISUAL


@pytest.fixture(scope="module")
def model():
    return read_source(TEXT).model()


def with_shape(shape):
    """The biped's URDF with a shape that touches on its torso."""

    def edit(root):
        text = f"<collision><origin xyz='0.5 0 0'/><geometry>{shape}</geometry></collision>"
        link(root, "torso").append(ET.fromstring(text))

    return edited_urdf(edit)


def with_mesh(file):
    return with_shape(f"<mesh filename='{file}'/>")


def torso_vertices(source: Source) -> np.ndarray:
    geometry = source.geometry(COLLISION, {"torso"})
    assert [item.name for item in geometry.geometryObjects] == ["torso_0"]
    return sorted_rows(geometry.geometryObjects[0].geometry.vertices())


def test_a_file_and_its_text_describe_the_same_robot(tmp_path, model, rng):
    path = tmp_path / "biped.urdf"
    path.write_text("\ufeff" + TEXT, encoding="utf-8")
    source = read_source(path)
    assert (source.text, source.format, source.path) == (TEXT, "urdf", path)
    assert read_source("\n " + TEXT).path is None
    assert same_motion(source.model(), model, rng)
    assert pin.computeTotalMass(source.model()) == pytest.approx(56.87)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, r"cannot read the URDF '.*robot.urdf': no such file or directory; check the path"),
        ("directory", r"'.*robot.urdf': is a directory; check the path"),
        (b"", r"'.*robot.urdf': the file is empty"),
        (b"<robot name='caf\xe9'/>", r"'.*robot.urdf': it is not UTF-8 text; save it as UTF-8"),
        (b"<robot>", r"not well-formed XML: line 1, column 8: no element found"),
        (b"solid foot", r"not well-formed XML: line 1, column 1"),
        (
            b"<sdf version='1.6'/>",
            r"the file holds <sdf>, not a URDF \(<robot>\) or MJCF \(<mujoco>\); convert it",
        ),
        (b"<robot name='a'><xacro:leg side='left'/></robot>", "still holds xacro macros"),
        (
            b"<robot name='a' xmlns:x='http://ros.org/xacro'><x:if value='1'><link name='b'/>"
            b"</x:if></robot>",
            r"still holds xacro macros \(<x:if>\); expand the xacro",
        ),
        (b"<robot name='a'><property name='m' value='2'/></robot>", r"macros \(<property>\)"),
        (
            b"<robot name='a'><link name='b'/><joint name='c' type='fixed'>"
            b"<parent link='${side}_b'/></joint></robot>",
            r'xacro macros \(link="\$\{side\}_b"\); expand the xacro macros first: xacro robot',
        ),
        (
            b"<robot name='a'><link name='$(arg side)_b'/></robot>",
            r'still holds xacro macros \(name="\$\(arg side\)_b"\)',
        ),
        (b"<robot name='a'><include filename='legs.urdf'/></robot>", r"macros \(<include>\)"),
        (
            b"<robot name='a'>\n<link name='b'/><group><link name='c'/></group></robot>",
            "line 2: link 'c': it stands inside <group>, where it does not count; put it",
        ),
        (
            b"<robot name='a'>\n<link name='b'>\n<joint name='c' type='fixed'/></link></robot>",
            "line 3: joint 'c': it stands inside <link>",
        ),
        (b"<mujoco><worldbody/></mujoco>", "has no body that moves"),
    ],
)
def test_files_that_hold_no_robot_are_refused(tmp_path, content, message, capfd):
    path = tmp_path / "robot.urdf"
    if content == "directory":
        path.mkdir()
    elif content is not None:
        path.write_bytes(content)
    with pytest.raises(RobotError, match=message):
        read_source(path)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("text", ["", "  \n"])
def test_empty_text_is_refused(text):
    with pytest.raises(RobotError, match="the robot is empty text; give a URDF"):
        read_source(text)


MESH = "robots/legs_description/meshes/foot.stl"  # below the test's directory


@pytest.mark.parametrize("case", ["base_mini.urdf", "base_mini.xml"])
@pytest.mark.parametrize("before", ["\n", " \n\t", "<!-- hips -- and ---- knees\n-->\n"])
def test_what_all_readers_of_robots_take_is_read(tmp_path, before, case):
    """Blanks before the declaration and dashes in comments, which XML does not allow."""
    text = (CASES / case).read_text(encoding="utf-8")
    own = read_source(CASES / case)
    if "--" in before:
        declaration, rest = text.split("\n", 1)
        text = f"{declaration}\n{before}{rest}"
    else:
        text = before + text
    path = tmp_path / case
    path.write_text(text, encoding="utf-8")
    source = read_source(path)
    assert source.model() == own.model()
    first = next(iter(source.tree.root))
    assert source.tree.line(first) == own.tree.line(next(iter(own.tree.root))) + before.count("\n")


@pytest.mark.parametrize(
    ("file", "robot", "options"),
    [
        ("package://legs_description/meshes/foot.stl", "robots/legs_description/urdf", {}),
        ("model://legs_description/meshes/foot.stl", "robots/other_description/urdf", {}),
        ("package://other_name/meshes/foot.stl", "robots/legs_description/urdf", {}),
        ("package://legs_description/meshes/foot.stl", "else", {"package_dirs": ["robots"]}),
        (
            "package://legs_description/meshes/foot.stl",
            "else",
            {"package_dirs": ["robots/legs_description"]},
        ),
        ("package://legs_description/meshes/foot.stl", "else", {"ROS_PACKAGE_PATH": "robots"}),
        ("../meshes/foot.stl", "robots/legs_description/urdf", {}),
        ("meshes/foot.stl", "robots/legs_description/urdf", {}),
        ("file:///home/someone/legs_description/meshes/foot.stl", "robots/demo/urdf", {}),
        ("file://localhost/home/someone/meshes/foot.stl", "robots/legs_description/urdf", {}),
        ("PACKAGE://legs_description/meshes/foot.stl", "robots/legs_description/urdf", {}),
        ("package://legs_description//meshes//foot.stl", "robots/legs_description/urdf", {}),
        ("package://legs%5Fdescription/meshes/foot.stl", "robots/legs_description/urdf", {}),
        (r"..\meshes\foot.stl", "robots/legs_description/urdf", {}),
    ],
)
def test_meshes_are_found(tmp_path, monkeypatch, file, robot, options):
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    write_stl(tmp_path / MESH)
    path = tmp_path / robot / "robot.urdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(with_mesh(file), encoding="utf-8")
    if "ROS_PACKAGE_PATH" in options:
        monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / options["ROS_PACKAGE_PATH"]))
    source = read_source(path, [tmp_path / d for d in options.get("package_dirs", [])])
    assert source.mesh_problems() == []
    np.testing.assert_allclose(torso_vertices(source), sorted_rows(TETRAHEDRON), atol=1e-6)


def test_meshes_of_an_installed_package_are_found(tmp_path, monkeypatch):
    write_stl(tmp_path / "install" / "share" / "legs" / "meshes" / "foot.stl")
    text = with_mesh("package://legs/meshes/foot.stl")
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    assert [p.link for p in read_source(text).mesh_problems()] == ["torso"]
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    np.testing.assert_allclose(torso_vertices(read_source(text)), sorted_rows(TETRAHEDRON))


def test_meshes_keep_their_scale(tmp_path):
    path = write_stl(tmp_path / "foot.stl")
    source = read_source(with_shape(f"<mesh filename='file://{path}' scale='1 -2 0.5'/>"))
    expected = sorted_rows(TETRAHEDRON * [1.0, -2.0, 0.5])
    np.testing.assert_allclose(torso_vertices(source), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (None, "was not found"),
        (b"", "is an empty file"),
        (b"version https://git-lfs.github.com/spec/v1\noid", "is a Git LFS pointer whose content"),
    ],
)
def test_dead_meshes_are_reported_and_left_out(tmp_path, capfd, model, rng, content, reason):
    if content is not None:
        (tmp_path / "foot.stl").write_bytes(content)
    path = tmp_path / "robot.urdf"
    path.write_text(with_mesh("foot.stl"), encoding="utf-8")
    source = read_source(path)
    (problem,) = source.mesh_problems()
    assert f"link 'torso': the collision mesh 'foot.stl' {reason}" in str(problem)
    assert same_motion(source.model(), model, rng)
    assert source.geometry(COLLISION, {"torso"}) is None
    assert source.geometry(COLLISION).ngeoms == 2
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("file", ["$(find talos)/foot.stl", "${meshes}/foot.stl"])
def test_a_mesh_that_xacro_would_name_is_told_as_one(file):
    """It is not lost: no directory helps."""
    (problem,) = read_source(with_mesh(file)).mesh_problems()
    assert str(problem) == (
        f"link 'torso': the collision mesh '{file}' is named by a macro of xacro; "
        "expand the xacro macros first: xacro robot.urdf.xacro > robot.urdf"
    )


BINARY = b"solid".ljust(80) + struct.pack("<I", 1)
NONE = {
    "foot.stl": (b"not a mesh at all", "is a broken STL file"),
    "cut.stl": (BINARY + bytes(49), "is a broken STL file"),
    "nan.stl": (BINARY + struct.pack("<12fH", *[float("nan")] * 12, 0), "is not a mesh that can"),
    "foot.dae": (b"<COLLADA><asset>", "is a broken Collada file"),
    "void.dae": (b"<COLLADA/>", "is not a mesh that can be read"),
    "foot.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "is not a mesh that can be read"),
    "foot.wrl": (b"#VRML V2.0 utf8\n", r"is of a format that cannot be read (.wrl)"),
}


@pytest.mark.parametrize("name", NONE)
def test_a_mesh_that_is_none_costs_itself_and_is_named(tmp_path, capfd, name):
    content, reason = NONE[name]
    (tmp_path / name).write_bytes(content)
    good = write_stl(tmp_path / "good.stl")
    text = with_mesh(tmp_path / name).replace(
        "</link>",
        f"<collision><geometry><mesh filename='{good}'/></geometry></collision></link>",
        1,
    )
    source = read_source(text)
    assert source.model().nv == 18
    np.testing.assert_allclose(torso_vertices(source), sorted_rows(TETRAHEDRON), atol=1e-6)
    (problem,) = source.mesh_problems()
    assert f"link 'torso': the collision mesh '{tmp_path / name}' {reason}" in str(problem)
    assert "replace the file" in str(problem)
    assert capfd.readouterr() == ("", "")


def test_capsules_of_old_urdfs_are_read_in_silence(capfd):
    source = read_source(with_shape("<capsule radius='0.1' length='0.2'/>"))
    (item,) = source.geometry(COLLISION, {"torso"}).geometryObjects
    assert (item.geometry.radius, item.geometry.halfLength) == (0.1, 0.1)
    assert capfd.readouterr().err == ""


def test_geometry_there_is_none_of():
    source = read_source(edited_urdf(lambda root: None))
    assert source.geometry(COLLISION, {"torso"}) is None
    assert source.geometry(VISUAL, {"torso"}).ngeoms > 5


def test_an_arm_without_limits_is_read(model, capfd):
    def edit(root):
        add_arm(root)
        shoulder = joint(root, "shoulder")
        shoulder.remove(shoulder.find("limit"))

    source = read_source(edited_urdf(edit))
    assert {(p.kind, p.name) for p in source.problems} == {
        (kind, "shoulder") for kind in ("effort", "velocity", "range")
    }
    assert source.model().nv == model.nv + 1
    assert capfd.readouterr().err == ""


def test_a_model_is_read_once_and_handed_out_as_a_copy(monkeypatch):
    source = read_source(TEXT)
    first = source.model()
    first.addFrame(pin.Frame("mark", 1, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    first.inertias[1] = pin.Inertia.Zero()
    monkeypatch.setattr(pin, "buildModelFromXML", None)
    second = source.model()
    assert not second.existFrame("mark")
    assert pin.computeTotalMass(second) == pytest.approx(56.87)


def test_a_robot_may_be_made_of_its_reading():
    source = read_source(TEXT)
    robot = Robot.from_reading(source, import_robot(source, ImportOptions()))
    expected = Robot.from_urdf(TEXT)
    assert robot.model == expected.model
    assert robot.choices == expected.choices


def test_a_floating_joint_to_the_world_gives_way_to_the_free_flyer(model, rng):
    def edit(root):
        root.insert(0, ET.fromstring("<link name='world'/>"))
        root.append(
            ET.fromstring(
                "<joint name='floating_base' type='floating'><parent link='world'/>"
                "<child link='torso'/></joint>"
            )
        )

    floating = read_source(edited_urdf(edit)).model()
    assert floating.njoints == model.njoints
    assert same_motion(floating, model, rng)


@needs_example_robots
@pytest.mark.parametrize("path", BIPEDS)
def test_bipeds_of_others_are_read(path, capfd):
    source = read_source(example_robot(path))
    model = source.model()
    assert 1.0 < pin.computeTotalMass(model) < 140.0
    assert model.nv >= 12
    dead = {p.file.split("/")[2] for p in source.mesh_problems()}
    assert dead == ({""} if "romeo_laas" in path else set())
    assert capfd.readouterr().err == ""


@needs_example_robots
def test_bipeds_of_others_have_known_weights():
    masses = {
        "talos_data/robots/talos_reduced.urdf": 90.272,
        "g1_description/urdf/g1_29dof_rev_1_0.urdf": 33.341,
        "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf": 49.081,
        "icub_description/robots/icub_reduced.urdf": 28.347,
    }
    for path, mass in masses.items():
        model = read_source(example_robot(path)).model()
        assert pin.computeTotalMass(model) == pytest.approx(mass, abs=1e-3)
