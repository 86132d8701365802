"""Collada files that lie on their side, and those that only say so."""

from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from example_robots import example_robot, needs_example_robots
from mesh_files import TETRAHEDRON, sorted_rows
from urdf_edits import edited_urdf, link

from gaitopt.importers.meshes import up_axis
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import load_mesh
from gaitopt.view.robot_shapes import unseen

COLLISION = pin.GeometryType.COLLISION
ON_ITS_SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # x y z -> x z -y
UP = TETRAHEDRON + np.array([0.0, 0.0, 3.0])

DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>{up}</asset>
<library_geometries><geometry id="m"><mesh>
<source id="p"><float_array id="pa" count="12">{points}</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#m"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""


def write_dae(path, points, up):
    numbers = " ".join(map(repr, points.ravel().tolist()))
    axis = f"<up_axis>{up}</up_axis>" if up else ""
    path.write_text(DAE.format(points=numbers, up=axis), encoding="utf-8")
    return path


def torso_with(path):
    """The generated biped with one shape that touches on its torso, whose mass is above."""

    def edit(root):
        torso = link(root, "torso")
        text = f"<collision><geometry><mesh filename='{path}'/></geometry></collision>"
        torso.append(ET.fromstring(text))
        torso.find("inertial/origin").set("xyz", "0.25 0.25 3.25")

    return read_source(edited_urdf(edit))


@pytest.mark.parametrize(
    ("up", "points", "turned"),
    [
        ("Y_UP", UP @ ON_ITS_SIDE.T, True),
        ("", UP @ ON_ITS_SIDE.T, True),
        ("Y_UP", UP, False),  # made for loaders that do not turn it
        ("Z_UP", UP, False),
    ],
)
def test_shapes_stand_where_the_masses_are(tmp_path, up, points, turned):
    source = torso_with(write_dae(tmp_path / "torso.dae", points, up))
    (item,) = source.geometry(COLLISION, {"torso"}).geometryObjects
    assert np.allclose(item.placement.rotation, np.eye(3)) is not turned
    placed = item.geometry.vertices() @ item.placement.rotation.T
    np.testing.assert_allclose(sorted_rows(np.round(placed, 9)), sorted_rows(UP), atol=1e-6)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<COLLADA><asset><up_axis> Z_UP </up_axis></asset></COLLADA>", "Z_UP"),
        ("<COLLADA><asset/></COLLADA>", "Y_UP"),
        ("<COLLADA><asset>", ""),
    ],
)
def test_the_upward_axis_of_a_file(tmp_path, text, expected):
    path = tmp_path / "mesh.dae"
    path.write_text(text, encoding="utf-8")
    assert up_axis(str(path)) == expected


def test_a_file_that_is_not_there_has_no_upward_axis(tmp_path):
    assert up_axis(str(tmp_path / "none.dae")) == ""


@needs_example_robots
@pytest.mark.parametrize(
    ("path", "turned"),
    [
        ("icub_description/robots/icub_reduced.urdf", True),
        ("hextilt_description/urdf/hextilt_flying_arm_5.urdf", False),
        ("tiago_description/robots/tiago.urdf", False),
    ],
)
def test_robots_that_mean_y_and_robots_that_do_not(path, turned):
    """All of their Collada files for collisions say that y is up; only iCub's are."""
    source = read_source(example_robot(path))
    as_read, shapes = source._shapes(COLLISION, None, load_mesh), source.geometry(COLLISION)
    same = [
        a.placement == b.placement
        for a, b in zip(as_read.geometryObjects, shapes.geometryObjects, strict=True)
        if a.meshPath.endswith(".dae")
    ]
    assert len(same) > 5
    assert set(same) == {not turned}


A_ONE = "<transparent opaque='A_ONE'><color>1 1 1 {}</color></transparent>"
RGB_ZERO = "<transparent opaque='RGB_ZERO'><color>{0} {0} {0} 1</color></transparent>"
FACTOR = "<transparency><float>{}</float></transparency>"


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ("", False),
        (A_ONE.format(0), True),
        (A_ONE.format(1), False),
        (A_ONE.format(0.4), False),
        (A_ONE.format(1) + FACTOR.format(0), True),
        (FACTOR.format("0.0"), True),
        (FACTOR.format(0.3), False),
        (FACTOR.format("none"), False),
        (RGB_ZERO.format(1), True),
        (RGB_ZERO.format(0), False),
        (RGB_ZERO.format(1) + FACTOR.format(0), False),
        ("<transparent><color>1 1 1 1</color></transparent>" + FACTOR.format("0.0"), True),
        ("<transparent opaque='A_ZERO'><color>1 1 1 1</color></transparent>", True),
        ("<transparent opaque='RGB_ONE'><color>0 0 0 1</color></transparent>", True),
        ("<transparent><texture texture='a'/></transparent>", False),
    ],
)
def test_meshes_that_the_viewer_would_not_show(parts, expected):
    """The viewer is three.js, whose opacities these are: it was read and tried."""
    text = f"<phong xmlns='http://www.collada.org/2005/11/COLLADASchema'>{parts}</phong>"
    assert unseen(ET.fromstring(text)) is expected
