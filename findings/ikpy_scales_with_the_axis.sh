#!/usr/bin/env bash
# Version:  ikpy 4.2.1
# Does:     a URDF joint about "0 3 4" (a valid axis: the format asks readers to normalise it) makes
#           the homogeneous matrix of forward_kinematics a scaling: its rotation has determinant 72.8
#           and the end point lies 1.6 m away.
# Guess:    the axis is normalised, as Pinocchio, MuJoCo and Drake do, or the file is refused.
# Means:    axes written with few digits ("0.94 0 0.34") are off by as much as their length: lengths
#           of legs change with the angle, by little, and nobody sees why.
# Seen:     determinant 72.82 for "0 3 4", 1.0000 for "0 0.6 0.8"
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check ikpy==4.2.1
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
from pathlib import Path

import numpy as np
from ikpy.chain import Chain

URDF = """<robot name="r"><link name="base"/><link name="leg"/><link name="foot"/>
<joint name="hip" type="revolute"><parent link="base"/><child link="leg"/><origin xyz="0 .1 0"/>
<axis xyz="{}"/><limit lower="-1" upper="2" effort="7" velocity="3"/></joint>
<joint name="sole" type="fixed"><parent link="leg"/><child link="foot"/>
<origin xyz=".1 .2 -.4"/></joint></robot>"""
found = {}
for axis in ("0 0.6 0.8", "0 3 4"):
    path = Path("leg.urdf")
    path.write_text(URDF.format(axis))
    pose = Chain.from_urdf_file(str(path), base_elements=["base"]).forward_kinematics([0, 0.7, 0])
    found[axis] = pose
    print(f"axis {axis}: determinant {np.linalg.det(pose[:3, :3]):.4f}, end {pose[:3, 3].round(4)}")
assert np.isclose(np.linalg.det(found["0 0.6 0.8"][:3, :3]), 1.0)
assert 72 < np.linalg.det(found["0 3 4"][:3, :3]) < 74
assert np.linalg.norm(found["0 3 4"][:3, 3] - found["0 0.6 0.8"][:3, 3]) > 1.0
PY
