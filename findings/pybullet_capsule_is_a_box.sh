#!/usr/bin/env bash
# Version:  pybullet 3.2.7 against trimesh 5.2.0
# Does:     the inertia that PyBullet gives a link from its capsule (its default: the tensor of a URDF is
#           not used) is that of the box round it: for a shank of radius 5 cm and length 40 cm 38 % too
#           large about its length and 15 % across. Spheres are right.
# Guess:    a capsule has the inertia of a capsule, as a sphere has that of a sphere.
# Means:    shins and arms made of capsules turn too heavily, and a swing leg needs other torques than in
#           any other engine, where a table of masses shows no difference. Load with
#           URDF_USE_INERTIA_FROM_FILE.
# Seen:     per kg: numerically (0.01889, 0.01889, 0.00121), PyBullet (0.02167, 0.02167, 0.00167)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 trimesh==5.2.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pybullet
import trimesh

radius, length = 0.05, 0.4
URDF = """<robot name="r"><link name="shank"><inertial><origin xyz="0 0 0"/><mass value="1"/>
<inertia ixx=".0189" ixy="0" ixz="0" iyy=".0189" iyz="0" izz=".0012"/></inertial>
<collision><geometry>{}</geometry></collision></link></robot>"""
shapes = {
    "sphere": (f'<sphere radius="{radius}"/>', trimesh.creation.icosphere(4, radius)),
    "capsule": (
        f'<capsule radius="{radius}" length="{length}"/>',
        trimesh.creation.capsule(height=length, radius=radius, count=[64, 64]),
    ),
}
pybullet.connect(pybullet.DIRECT)
for name, (tag, mesh) in shapes.items():
    path = Path.cwd() / f"{name}.urdf"
    path.write_text(URDF.format(tag))
    seen = np.array(pybullet.getDynamicsInfo(pybullet.loadURDF(str(path)), -1)[2])
    true = np.diag(mesh.moment_inertia) / mesh.volume
    ratio = seen / true
    print(f"{name}: PyBullet {seen.round(5)}, numerically {true.round(5)}, ratio {ratio.round(3)}")
    if name == "sphere":
        assert np.allclose(ratio, 1.0, atol=0.02)
sides = 2 * np.array([radius, radius, radius + length / 2])
box = (np.sum(sides**2) - sides**2) / 12
print("box round the capsule:", box.round(5))
assert np.allclose(seen, box, rtol=1e-4) and ratio[0] > 1.1 and ratio[2] > 1.3
PY
