"""Of mesh files pages hold shapes and colours only; names from files are shown, not obeyed."""

import html
import re
from dataclasses import replace
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from example_robots import DIRECTORY, needs_example_robots
from page_scene import scene_of
from places import CASES
from sample_gait import sample_gait

from gaitopt.escape import filled_template, html_text, printable
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.view.inspection import inspect_robot
from gaitopt.view.inspection_page import inspection_text
from gaitopt.view.page import page_text
from gaitopt.view.robot_shapes import draw_shape, read_mesh, unloaded
from gaitopt.view.viewer import Node, RecordingWindow, umsgpack

SECRET = "secret"
FACE = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 0, 0], [0, 2, 0], [0, 0, 3.0]]])
NUMBERS = " ".join(f"{n:g}" for n in FACE.ravel())

COLLADA = f"""<?xml version="1.0"?><!-- {SECRET} -->
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><contributor><author>{SECRET}</author><source_data>/home/{SECRET}</source_data>
  </contributor><unit name="{SECRET}" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
 <library_images><image id="{SECRET}"><init_from>/home/{SECRET}.png</init_from></image>
  </library_images>
 <library_effects><effect id="{SECRET}-effect" name="{SECRET}"><profile_COMMON>
  <technique sid="{SECRET}"><phong><diffuse><color sid="{SECRET}">0.1 0.2 0.3 1</color></diffuse>
   <transparent opaque="A_ONE"><color>1 1 1 0</color></transparent></phong></technique>
  </profile_COMMON><extra>{SECRET}</extra></effect></library_effects>
 <library_materials><material id="{SECRET}-m"><instance_effect url="#{SECRET}-effect"/></material>
  </library_materials>
 <library_geometries><geometry id="{SECRET}-g" name="{SECRET}"><mesh>
  <source id="{SECRET}-p"><float_array id="{SECRET}-a" count="18">{NUMBERS}</float_array>
   <technique_common><accessor source="#{SECRET}-a" count="6" stride="3">
    <param name="X" type="float"/><param name="Y" type="float"/>
    <param name="Z" type="float"/></accessor></technique_common></source>
  <vertices id="{SECRET}-v"><input semantic="POSITION" source="#{SECRET}-p"/></vertices>
  <triangles count="2" material="{SECRET}-s"><input semantic="VERTEX" source="#{SECRET}-v"
   offset="0"/><p>0 1 2 3 4 5</p></triangles></mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="{SECRET}-w"><node id="{SECRET}-n" name="{SECRET}">
  <matrix sid="{SECRET}">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
  <instance_geometry url="#{SECRET}-g"><bind_material><technique_common>
   <instance_material symbol="{SECRET}-s" target="#{SECRET}-m"/></technique_common>
  </bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#{SECRET}-w"/></scene></COLLADA>
"""


def binary_stl() -> bytes:
    record = np.zeros(2, [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("r", "<u2")])
    record["v"] = FACE
    return f"solid {SECRET}".encode().ljust(80) + (2).to_bytes(4, "little") + record.tobytes()


def text_stl() -> str:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {' '.join(map(str, corner))}\n" for corner in face)
        + "endloop\nendfacet\n"
        for face in FACE
    )
    return f"solid {SECRET}\n{facets}endsolid {SECRET}\n"


OBJ = f"""# {SECRET}
mtllib {SECRET}.mtl
o {SECRET}
v 0 0 0
v 1 0 0
v 0 2 0
v 0 0 3
f 1/1/1 2//2 3
f -4 -2 -1
"""

FILES = {"a.stl": binary_stl(), "b.STL": text_stl().encode(), "c.obj": OBJ.encode()}


@pytest.mark.parametrize("name", FILES)
def test_triangles_of_files(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(FILES[name])
    found = read_mesh(str(path))
    assert found is not None
    assert found.corners == pytest.approx(FACE)
    assert found.normals is found.colours is None


@pytest.mark.parametrize("data", [b"", b"solid", b"f 1 2 3", b"v 1 x 3\nf 1 1 1", b"\0" * 90])
@pytest.mark.parametrize("name", ["a.stl", "a.obj", "a.dae"])
def test_files_that_hold_none_are_left(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data)
    assert read_mesh(str(path)) is None
    assert read_mesh(str(tmp_path / "absent.stl")) is None
    assert read_mesh("BOX") is None


def drawn(path: Path) -> list[dict]:
    item = pin.GeometryObject("part", 0, pin.SE3.Identity(), unloaded(str(path), np.ones(3)))
    item.meshPath = str(path)
    recorder = RecordingWindow()
    draw_shape(Node(recorder)["robot"], "shin", item, pin.SE3.Identity())
    assert SECRET.encode() not in b"".join(recorder.commands)
    return [c for c in map(umsgpack.unpackb, recorder.commands) if c["type"] == "set_object"]


@pytest.mark.parametrize("name", [*FILES, "d.dae"])
def test_a_shape_is_drawn_without_the_rest_of_its_file(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(FILES.get(name, COLLADA.encode()))
    (made,) = drawn(path)
    (shape,) = made["object"]["geometries"]
    points = np.frombuffer(shape["data"]["attributes"]["position"]["array"].data, "<f4")
    size = 0.01 if name == "d.dae" else 1.0  # its unit is the centimetre
    assert sorted(points) == pytest.approx(sorted(size * FACE.ravel()), abs=1e-7)


def test_a_collada_file_keeps_its_colours(tmp_path):
    path = tmp_path / "d.dae"
    path.write_text(COLLADA)
    found = read_mesh(str(path))
    assert found.corners == pytest.approx(0.01 * FACE)
    assert found.colours == pytest.approx(np.tile([0.1, 0.2, 0.3, 1.0], (2, 1)))
    (made,) = drawn(path)
    (material,) = made["object"]["materials"]
    assert material["color"] == 0x19334C
    path.write_text(COLLADA.replace("Z_UP", "Y_UP"))  # its numbers are taken as they are
    assert read_mesh(str(path)).corners == pytest.approx(FACE)


def test_geometries_with_several_materials_keep_their_corners(tmp_path):
    """Coal gives the triangles of the second material the corners of the first."""
    two = COLLADA.replace(
        "<p>0 1 2 3 4 5</p></triangles>",
        f"<p>0 1 2</p></triangles><triangles count='1' material='other'><input semantic='VERTEX' "
        f"source='#{SECRET}-v' offset='0'/><p>5 4 3</p></triangles>",
    ).replace("Z_UP", "Y_UP")
    two = two.replace('<triangles count="2"', '<triangles count="1"')
    path = tmp_path / "d.dae"
    path.write_text(two)
    found = read_mesh(str(path))
    assert found.corners == pytest.approx(np.array([FACE[0], FACE[1][::-1]]))
    assert found.colours[:, :3] == pytest.approx(np.array([[0.1, 0.2, 0.3], [0.62, 0.65, 0.68]]))
    assert len(drawn(path)) == 2


NODE = f'<matrix sid="{SECRET}">1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>'


def test_nodes_move_turn_and_stretch_in_their_order(tmp_path):
    path = tmp_path / "d.dae"
    moved = "<translate>0 0 5</translate><rotate>0 0 2 90</rotate><scale>1 2 3</scale>"
    normals = (
        '<source id="n"><float_array id="na" count="3">1 1 0</float_array><technique_common>'
        '<accessor source="#na" count="1" stride="3"/></technique_common></source><vertices'
    )
    text = COLLADA.replace(NODE, moved).replace("Z_UP", "Y_UP").replace("<vertices", normals)
    text = text.replace("<p>0 1 2 3 4 5</p>", '<input semantic="NORMAL" source="#n" offset="1"/>'
                        "<p>0 0 1 0 2 0 3 0 4 0 5 0</p>")  # fmt: skip
    path.write_text(text)
    found = read_mesh(str(path))
    stretched = FACE * [1.0, 2.0, 3.0]
    turned = np.stack([-stretched[..., 1], stretched[..., 0], stretched[..., 2] + 5.0], axis=-1)
    assert found.corners == pytest.approx(turned)
    across = np.array([-0.5, 1.0, 0.0]) / np.sqrt(1.25)  # perpendicular as before it was stretched
    assert found.normals == pytest.approx(np.broadcast_to(across, (2, 3, 3)))


@pytest.mark.parametrize(
    ("faces", "triangles"),
    [
        ("<polylist count='1'>{}<vcount>4</vcount><p>0 1 2 5</p></polylist>", [0, 1, 2, 0, 2, 5]),
        (
            "<polylist count='2'>{}<vcount>3 4</vcount><p>3 4 5 0 1 2 5</p></polylist>",
            [3, 4, 5, 0, 1, 2, 0, 2, 5],
        ),
        (
            "<polygons count='2'>{}<p>0 1 2</p><p>0 1 2 5</p></polygons>",
            [0, 1, 2, 0, 1, 2, 0, 2, 5],
        ),
    ],
)
def test_polygons_are_cut_into_fans(tmp_path, faces, triangles):
    own = re.search(r"<triangles.*?</triangles>", COLLADA, flags=re.DOTALL)[0]
    one = f'<input semantic="VERTEX" source="#{SECRET}-v" offset="0"/>'
    path = tmp_path / "d.dae"
    path.write_text(COLLADA.replace(own, faces.format(one)).replace("Z_UP", "Y_UP"))
    expected = FACE.reshape(-1, 3)[triangles].reshape(-1, 3, 3)
    assert read_mesh(str(path)).corners == pytest.approx(expected)


@needs_example_robots
@pytest.mark.parametrize("robot", ["icub_description", "romeo_description", "ur_description"])
def test_collada_files_of_others_are_where_coal_has_them(robot):
    """Boxes around the parts; only where it has one material is coal to be believed further."""
    load = coal.MeshLoader(coal.NODE_TYPE.BV_AABB).load
    files = sorted((DIRECTORY / robot).rglob("*.dae"), key=lambda path: path.stat().st_size)[:12]
    assert len(files) == 12
    for path in files:
        other = np.array(load(str(path), np.ones(3)).vertices())
        own = read_mesh(str(path)).corners.reshape(-1, 3)
        size = np.ptp(other, axis=0).max()
        assert own.min(axis=0) == pytest.approx(other.min(axis=0), abs=1e-5 * size), path
        assert own.max(axis=0) == pytest.approx(other.max(axis=0), abs=1e-5 * size), path


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (NUMBERS, f"{NUMBERS} {SECRET}"),
        ("VERTEX", SECRET),
        ("0 1 2 3 4 5", "0 1 2 3 4 99"),
        ("</scene>", ""),
        ("triangles", "tristrips"),
    ],
)
def test_a_collada_file_that_is_not_understood_is_left_to_others(tmp_path, old, new):
    path = tmp_path / "d.dae"
    path.write_text(COLLADA.replace(old, new))
    assert read_mesh(str(path)) is None


def test_a_picture_becomes_grey_and_a_part_of_glass_stays_clear(tmp_path):
    path = tmp_path / "d.dae"
    picture = COLLADA.replace(f'<color sid="{SECRET}">0.1 0.2 0.3 1</color>', "<texture/>")
    path.write_text(picture.replace("1 1 1 0", "1 1 1 0.5"))
    assert read_mesh(str(path)).colours == pytest.approx(np.tile([0.62, 0.65, 0.68, 0.5], (2, 1)))
    (material,) = drawn(path)[0]["object"]["materials"]
    assert (material["opacity"], material["transparent"]) == (0.5, True)


def test_black_parts_stay_black_beside_others_but_not_alone(tmp_path):
    path = tmp_path / "d.dae"
    black = COLLADA.replace("0.1 0.2 0.3 1", "0 0 0 1")
    path.write_text(black)
    assert read_mesh(str(path)).colours[:, :3] == pytest.approx(np.tile([0.62, 0.65, 0.68], (2, 1)))
    two = black.replace(
        "<p>0 1 2 3 4 5</p></triangles>",
        f"<p>0 1 2</p></triangles><triangles count='1'><input semantic='VERTEX' "
        f"source='#{SECRET}-v' offset='0'/><p>5 4 3</p></triangles>",
    )
    path.write_text(two)
    assert read_mesh(str(path)).colours[:, 0] == pytest.approx([0.0, 0.62])


def test_marks_are_replaced_once():
    assert filled_template("@A@ @B@ @C@", {"@A@": "@B@", "@B@": "@A@"}) == "@B@ @A@ @C@"
    title = "@COMMANDS@ @MESHCAT@ <b>\x1b[31m\u202e"
    gait = sample_gait()
    text = page_text(replace(gait, meta={**gait.meta, "robot": title}), 1)
    head = text.partition("<script>")[0]
    assert "@COMMANDS@ @MESHCAT@ &lt;b&gt;\\x1b[31m\\u202e walks" in head
    assert len(scene_of(text)) > 50


def test_names_with_control_characters_are_shown():
    assert printable("plain ä µ") == "plain ä µ"
    assert printable("a\x1b[2Jb\r\n\x00\u2028\ud800") == "a\\x1b[2Jb\\r\\n\\x00\\u2028\\ud800"
    assert html_text("<\x07>") == "&lt;\\x07&gt;"
    urdf = '<robot name="&lt;i&gt;@TABLES@&#x9b;31m"><link name="b"/></robot>'
    text = inspection_text(inspect_robot(urdf, ImportOptions()))
    assert "<h1>&lt;i&gt;@TABLES@\\x9b31m</h1>" in html.unescape(text).replace(
        "<h1><i>", "<h1>&lt;i&gt;"
    )
    assert "\x9b" not in text


def test_a_robot_whose_exporter_wrote_alpha_0_is_seen():
    """Three of its links were drawn fully transparent."""
    source = read_source(CASES / "dae_alpha0.urdf")
    shapes = source.geometry(pin.GeometryType.VISUAL).geometryObjects
    limbs = {item.meshPath for item in shapes if item.meshPath.endswith("limb.dae")}
    assert len(limbs) == 1
    (path,) = limbs
    assert "<color>1 1 1 0</color>" in Path(path).read_text("utf-8")
    assert read_mesh(path).colours[:, 3] == pytest.approx(1.0)
    (material,) = drawn(Path(path))[0]["object"]["materials"]
    assert (material["opacity"], material["transparent"]) == (1.0, False)
