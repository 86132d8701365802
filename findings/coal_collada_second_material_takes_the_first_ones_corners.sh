#!/usr/bin/env bash
# Version:  coal 3.0.3 (as pin 4.1.0 brings it), trimesh 5.2.0 to compare
# Does:     a geometry of a Collada file may have several groups of triangles, one for each material, over
#           the same points. coal's MeshLoader gives the triangles of every further group the corners of
#           the first: of two squares side by side, one red and one blue, it makes the red one twice.
# Guess:    a mesh has the triangles that its file lists, whatever their colours.
# Means:    links of two colours look shredded, and what is made from the triangles (hulls, distances,
#           soles) is of another body. Read such files another way, or give every material a geometry of
#           its own. Links of iCub have two.
# Seen:     one material: 4 triangles, those of the file; two materials: 4 triangles, the first two twice,
#           nothing of the second square; trimesh reads both files alike
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0 trimesh==5.2.0 pycollada==0.9.2
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import coal
import numpy as np
import trimesh

POINTS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]
GROUPS = {"red": [(0, 1, 2), (0, 2, 3)], "blue": [(1, 4, 5), (1, 5, 2)]}


def collada(groups):
    """A file of one geometry with one group of triangles for each material."""
    effects = "".join(
        f'<effect id="{m}-e"><profile_COMMON><technique sid="t"><lambert><diffuse><color>'
        f"{'1 0 0 1' if m == 'red' else '0 0 1 1'}</color></diffuse></lambert></technique>"
        "</profile_COMMON></effect>" for m in groups)
    materials = "".join(
        f'<material id="{m}-m"><instance_effect url="#{m}-e"/></material>' for m in groups)
    triangles = "".join(
        f'<triangles material="{m}" count="{len(t)}"><input semantic="VERTEX" source="#v" '
        f'offset="0"/><p>{" ".join(str(k) for one in t for k in one)}</p></triangles>'
        for m, t in groups.items())
    bound = "".join(
        f'<instance_material symbol="{m}" target="#{m}-m"/>' for m in groups)
    numbers = " ".join(str(x) for p in POINTS for x in p)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
<unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_effects>{effects}</library_effects><library_materials>{materials}</library_materials>
<library_geometries><geometry id="g"><mesh><source id="s">
<float_array id="a" count="{3 * len(POINTS)}">{numbers}</float_array><technique_common>
<accessor source="#a" count="{len(POINTS)}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>{triangles}</mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="scene"><node id="n">
<instance_geometry url="#g"><bind_material><technique_common>{bound}</technique_common>
</bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


def corners(points, faces):
    return sorted(sorted(tuple(np.round(points[k], 6).tolist()) for k in face) for face in faces)


def by_coal(path):
    mesh = coal.MeshLoader().load(str(path), np.ones(3))
    points = np.array(mesh.vertices())
    faces = [[int(mesh.tri_indices(i)[k]) for k in range(3)] for i in range(mesh.num_tris)]
    return corners(points, faces)


def by_trimesh(path):
    mesh = trimesh.load(path, force="mesh")
    return corners(np.asarray(mesh.vertices), np.asarray(mesh.faces))


one, two = Path("one.dae"), Path("two.dae")
one.write_text(collada({"red": GROUPS["red"] + GROUPS["blue"]}))
two.write_text(collada(GROUPS))
assert coal.__version__ == "3.0.3", coal.__version__
print("coal", coal.__version__)
for path in (one, two):
    print(path.name, "coal:   ", by_coal(path))
    print(path.name, "trimesh:", by_trimesh(path))
assert by_coal(one) == by_trimesh(one), "one material is read as it is"
assert by_trimesh(two) == by_trimesh(one), "colours change no triangle"
seen = by_coal(two)
assert seen != by_coal(one) and seen[::2] == seen[1::2] and max(max(seen))[0] == 1.0
PY
