#!/usr/bin/env bash
# Version:  trimesh 5.2.0
# Does:     a scene that places a part with a scale, as a glTF file does whose node says scale 0.001 (drawn in millimetres),
#           has the extents of the scaled part, and volume and area of the part as it was drawn. In the centre of mass
#           every part weighs as before its scaling. moment_inertia is divided by the square of the scale, where it
#           should be multiplied by its fifth power. The same scene made one mesh by to_mesh() is right in everything.
# Guess:    extents in metres mean volume in cubic metres; two equal boxes balance half-way between them.
# Means:    a link assembled of parts in two units has its centre of mass in the part that was drawn in the
#           smaller one, and its inertia is off by 21 powers of ten; even a scale of 2 gives a 128th. Nothing is said, and a scene
#           without scales, or one scaled by scene.scaled(), is right. Call to_mesh() before asking for masses.
# Seen:     two boxes of 0.1 x 0.2 x 0.4 m, at 0 in millimetres and at 1 m in metres: centre of mass at 0.000 for 0.500 m,
#           volume 8e6 for 0.016 m³; one box scaled by 2: volume 0.008 for 0.064 m³, moment 3.33e-5 for 4.27e-3, by hand
#           m (b² + c²) / 12
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import json
import struct
from pathlib import Path

import numpy as np
import trimesh


def box(scale, at):
    """A scene with a box of 0.1 x 0.2 x 0.4 m at x [m], drawn in units of the scale."""
    scene = trimesh.Scene()
    place = np.diag([scale, scale, scale, 1.0])
    place[0, 3] = at
    scene.add_geometry(trimesh.creation.box(np.array([0.1, 0.2, 0.4]) / scale), transform=place)
    return scene


scene = box(0.001, 0.0)
for part in box(1.0, 1.0).dump():
    scene.add_geometry(part)
scene.export("link.glb")
content = Path("link.glb").read_bytes()
(length,) = struct.unpack("<I", content[12:16])
nodes = json.loads(content[20 : 20 + length])["nodes"]
print("nodes of the file:", [{k: node[k] for k in ("matrix", "scale", "translation") if k in node} for node in nodes])

read = trimesh.load_scene("link.glb")
mesh = read.to_mesh()
print("extents [m]:", read.extents.round(6), mesh.extents.round(6))
print("centre of mass [m]:", read.center_mass.round(6), mesh.center_mass.round(6))
print(f"volume [m^3]: {read.volume:.6g} {mesh.volume:.6g}")
assert np.allclose(read.extents, [1.1, 0.2, 0.4]) and np.allclose(mesh.extents, [1.1, 0.2, 0.4])
assert np.allclose(mesh.center_mass, [0.5, 0, 0], atol=1e-6) and np.allclose(mesh.volume, 0.016)
assert np.allclose(read.center_mass, 0, atol=1e-6) and np.isclose(read.volume, 8e6)

for scale in (1.0, 2.0, 0.001):
    one = trimesh.Scene()
    one.add_geometry(trimesh.creation.box([0.1, 0.2, 0.4]), transform=np.diag([scale, scale, scale, 1.0]))
    mass = 0.008 * scale**3
    hand = mass * scale**2 * (0.2**2 + 0.4**2) / 12
    found, right = one.moment_inertia[0, 0], one.to_mesh().moment_inertia[0, 0]
    print(f"scale {scale}: volume {one.volume:.4g} for {mass:.4g} m^3, area {one.area:.4g} for {0.28 * scale**2:.4g} m^2,")
    print(f"   moment {found:.4g}, one mesh {right:.4g}, by hand {hand:.4g} kg m^2 at 1 kg/m^3")
    assert np.isclose(right, hand, rtol=1e-6) and np.isclose(one.volume, 0.008) and np.isclose(one.area, 0.28)
    assert np.isclose(found, hand / scale**7, rtol=1e-6)
PY
