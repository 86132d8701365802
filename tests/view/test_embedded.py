"""Of mesh files pages hold shapes and colours only; names from files are shown, not obeyed."""

import base64
import html
import json
import re
from dataclasses import replace
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from sample_gait import sample_gait

from gaitopt.model.import_options import ImportOptions
from gaitopt.view.bare_collada import bare_collada
from gaitopt.view.inspection import inspect_robot
from gaitopt.view.inspection_page import inspection_text
from gaitopt.view.mesh_files import mesh_triangles
from gaitopt.view.meshcat_quiet import meshcat, umsgpack
from gaitopt.view.page import page_text
from gaitopt.view.recorder import Recorder
from gaitopt.view.shape_nodes import draw_shape
from gaitopt.view.visible import filled, on_page, visible

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
    found = mesh_triangles(str(path))
    assert found is not None
    assert found == pytest.approx(FACE)


@pytest.mark.parametrize("data", [b"", b"solid", b"f 1 2 3", b"v 1 x 3\nf 1 1 1", b"\0" * 90])
@pytest.mark.parametrize("name", ["a.stl", "a.obj"])
def test_files_that_hold_none_are_left(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data)
    assert mesh_triangles(str(path)) is None
    assert mesh_triangles(str(tmp_path / "absent.stl")) is None
    assert mesh_triangles("BOX") is None


def drawn(path: Path, *, own_colours: bool = False) -> list[dict]:
    loader = coal.CachedMeshLoader(coal.NODE_TYPE.BV_OBB)
    item = pin.GeometryObject("part", 0, pin.SE3.Identity(), loader.load(str(path), np.ones(3)))
    item.meshPath = str(path)
    item.overrideMaterial = not own_colours
    recorder = Recorder()
    draw_shape(meshcat.Visualizer(window=recorder)["robot"], "shin", item, pin.SE3.Identity())
    assert SECRET.encode() not in b"".join(recorder.commands)
    return [c for c in map(umsgpack.unpackb, recorder.commands) if c["type"] == "set_object"]


@pytest.mark.parametrize("name", [*FILES, "d.dae"])
def test_a_shape_is_drawn_without_the_rest_of_its_file(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(FILES.get(name, COLLADA.encode()))
    (made,) = drawn(path)
    (shape,) = made["object"]["geometries"]
    points = np.frombuffer(shape["data"]["attributes"]["position"]["array"].data, "<f4")
    assert sorted(points) == pytest.approx(sorted(FACE.ravel()), abs=1e-7)


def test_a_collada_file_keeps_its_colours_and_nothing_else(tmp_path):
    path = tmp_path / "d.dae"
    path.write_text(COLLADA)
    (made,) = drawn(path, own_colours=True)
    text = made["object"]["object"]["data"]
    assert made["object"]["object"]["format"] == "dae"
    assert text == bare_collada(str(path)) or "0.1 0.2 0.3 1" in text
    for kept in ("0.1 0.2 0.3 1", NUMBERS, 'meter="0.01"', "Z_UP", "0 1 2 3 4 5"):
        assert kept in text
    for gone in (SECRET, "transparent", "image", "param", "name", "extra", "author"):
        assert gone not in text
    labels = set(re.findall(r'(?:url|source|target|symbol|material)="#?(n\d+)"', text))
    assert labels
    assert labels - set(re.findall(r'(?:id|material)="(n\d+)"', text)) == set()


@pytest.mark.parametrize(
    ("old", "new"),
    [(NUMBERS, f"{NUMBERS} {SECRET}"), ("VERTEX", SECRET), ("Z_UP", SECRET), ("</scene>", "")],
)
def test_a_collada_file_that_is_not_understood_is_not_embedded(tmp_path, old, new):
    path = tmp_path / "d.dae"
    path.write_text(COLLADA.replace(old, new))
    assert bare_collada(str(path)) is None


def test_a_picture_becomes_grey_and_a_part_of_glass_stays_clear(tmp_path):
    path = tmp_path / "d.dae"
    picture = COLLADA.replace(f'<color sid="{SECRET}">0.1 0.2 0.3 1</color>', "<texture/>")
    path.write_text(picture.replace("1 1 1 0", "1 1 1 0.5"))
    text = bare_collada(str(path))
    assert text is not None
    assert "0.62 0.65 0.68 1" in text
    assert "1 1 1 0.5" in text


def test_marks_are_replaced_once():
    assert filled("@A@ @B@ @C@", {"@A@": "@B@", "@B@": "@A@"}) == "@B@ @A@ @C@"
    title = "@COMMANDS@ @MESHCAT@ <b>\x1b[31m\u202e"
    gait = sample_gait()
    text = page_text(replace(gait, meta={**gait.meta, "robot": title}), 1)
    head = text.partition("<script>")[0]
    assert "@COMMANDS@ @MESHCAT@ &lt;b&gt;\\x1b[31m\\u202e walks" in head
    commands = re.search(r"const commands = (\[.*?\]);", text)
    assert commands is not None
    assert base64.b64decode(json.loads(commands[1])[0])


def test_names_with_control_characters_are_shown():
    assert visible("plain ä µ") == "plain ä µ"
    assert visible("a\x1b[2Jb\r\n\x00\u2028\ud800") == "a\\x1b[2Jb\\r\\n\\x00\\u2028\\ud800"
    assert on_page("<\x07>") == "&lt;\\x07&gt;"
    urdf = '<robot name="&lt;i&gt;@TABLES@&#x9b;31m"><link name="b"/></robot>'
    text = inspection_text(inspect_robot(urdf, ImportOptions()))
    assert "<h1>&lt;i&gt;@TABLES@\\x9b31m</h1>" in html.unescape(text).replace(
        "<h1><i>", "<h1>&lt;i&gt;"
    )
    assert "\x9b" not in text
