#!/usr/bin/env bash
# Version:  sapien 3.0.3
# Does:     SAPIEN's URDF loader holds a mimic joint to its leader where it is the next one in the
#           tree; one that is two joints away is a free joint, and nothing says so. Efforts of limits are
#           not read: every joint may give 3.4e38 N·m.
# Guess:    a mimic joint follows its leader wherever it is in the tree, as in URDF.
# Means:    the foot that a linkage keeps parallel to the trunk hangs loose: ankles that follow the hip
#           past the knee are free in simulation. Compare the tie after some steps.
# Seen:     after 0.5 s: knee - 2 hip = 0.000 rad where the knee follows, ankle - hip = 0.15 rad
#           where the ankle should; effort 50 N·m read as 3.4e38
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check sapien==3.0.3 numpy==2.4.6
cd "$work"
cat > leg.py <<'PY'
BODY = """<inertial><origin xyz="0.05 0 -0.2"/><mass value="3"/>
<inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/>{tie}</joint>"""


def leg(knee="", ankle=""):
    links = "".join(f'<link name="{name}">{BODY}</link>' for name in ("trunk", "thigh", "shin", "foot"))
    joints = (
        JOINT.format(name="hip", parent="trunk", child="thigh", tie="")
        + JOINT.format(name="knee", parent="thigh", child="shin", tie=knee)
        + JOINT.format(name="ankle", parent="shin", child="foot", tie=ankle)
    )
    return f'<robot name="leg">{links}{joints}</robot>'
PY
"$work/env/bin/python" 2>/dev/null <<'PY'
from pathlib import Path

import numpy as np
import sapien
from leg import leg


def fallen(text):
    """Hang the leg on its trunk, let it go, and return its joint angles after half a second."""
    Path("leg.urdf").write_text(text)
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    scene.set_timestep(0.001)
    loader = scene.create_urdf_loader()
    loader.fix_root_link = True
    robot = loader.load("leg.urdf")
    assert [joint.name for joint in robot.active_joints] == ["hip", "knee", "ankle"]
    efforts = [float(joint.force_limit) for joint in robot.active_joints]
    robot.set_qpos(np.array([0.3, 0.6, 0.3]))
    for _ in range(500):
        scene.step()
    return np.array(robot.qpos), efforts


angles, efforts = fallen(leg(knee='<mimic joint="hip" multiplier="2"/>'))
held = angles[1] - 2 * angles[0]
print(f"knee follows the hip: angles {angles.round(3)}, knee - 2 hip = {held:.4f} rad; efforts {efforts}")
assert abs(held) < 1e-3 and min(efforts) > 1e30
angles, _ = fallen(leg(ankle='<mimic joint="hip" multiplier="1"/>'))
loose = angles[2] - angles[0]
print(f"ankle follows the hip: angles {angles.round(3)}, ankle - hip = {loose:.4f} rad")
assert abs(loose) > 0.1
PY
