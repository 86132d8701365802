#!/usr/bin/env bash
# Version:  urchin 0.0.30 (the maintained urdfpy), pin 4.0.0 to read what it saves
# Does:     URDF.copy(scale=s) moves the joints of all links, and gives a link with collision shapes the centre and the moments
#           of these shapes, filled evenly, and s cubed of its mass; the given centre and tensor are thrown away, even
#           for s = 1. A link without collision shapes keeps mass, centre and tensor as they were. And a link without
#           inertial, a mere frame, is saved with 1 kg and 1 kg·m² about each axis, copied or not.
# Guess:    "scale applied to meshes and inertial" (its docstring): masses by s cubed, centres by s, moments by the fifth
#           power, for every link; a copy of scale 1 is a copy; URDF says that no inertial is no mass.
# Means:    a child- or a giant-sized twin of a robot has shanks of the old weight hanging high in long legs, thighs
#           balanced like bricks, and a kilogram at each IMU and sole that swings like 1 kg at a metre. Compare the mass
#           and the centre of each link before and after, or scale the numbers by hand.
# Seen:     leg of 10 kg: saved as read 11 kg, the trunk's moments 0.04 to 1.04 kg·m²; scale 2: trunk and thigh 40 and 24 kg (and that 1), shank
#           2 kg for 16, its centre 0.15 m below the knee for 0.30; scale 1: thigh's centre 0.20 m for 0.15 below the hip
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check urchin==0.0.30 trimesh==5.2.0 pin==4.0.0 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin
import urchin


def inertial(height, mass, tensor):
    x, y, z = tensor
    return (f'<inertial><origin xyz="0 0 {height}"/><mass value="{mass}"/>'
            f'<inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/></inertial>')


def box(height, size):
    return f'<collision><origin xyz="0 0 {height}"/><geometry><box size="{size}"/></geometry></collision>'


def hinge(name, parent, child, height):
    return (f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {height}"/>'
            '<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="100" velocity="10"/></joint>')


Path("leg.urdf").write_text(f"""<robot name="leg">
<link name="trunk">{inertial(0.1, 5.0, (0.04, 0.03, 0.02))}{box(0.0, ".2 .3 .2")}</link><link name="imu"/>
<link name="thigh">{inertial(-0.15, 3.0, (0.05, 0.05, 0.01))}{box(-0.2, ".1 .1 .4")}</link>
<link name="shank">{inertial(-0.15, 2.0, (0.03, 0.03, 0.005))}</link>
<joint name="imu" type="fixed"><parent link="trunk"/><child link="imu"/><origin xyz="0 0 .1"/></joint>
{hinge("hip", "trunk", "thigh", -0.1)}{hinge("knee", "thigh", "shank", -0.4)}</robot>""")


def weighed(robot):
    """Mass, height of the centre and moments of trunk, thigh and shank as Pinocchio reads the saved file; length of the thigh."""
    robot.save("saved.urdf")
    model = pin.buildModelFromUrdf("saved.urdf", pin.JointModelFreeFlyer())
    bodies = [(each.mass, each.lever[2], np.diag(each.inertia)) for each in list(model.inertias)[1:]]
    return bodies, -model.jointPlacements[3].translation[2]


robot = urchin.URDF.load("leg.urdf")
before = [(each.mass, each.lever[2], np.diag(each.inertia))
          for each in list(pin.buildModelFromUrdf("leg.urdf", pin.JointModelFreeFlyer()).inertias)[1:]]
seen = {"as read": weighed(robot)} | {f"scale {s:g}": weighed(robot.copy(scale=s)) for s in (1.0, 2.0)}
print("file:", *(f"{mass:g} kg at {height:+.3f} m;" for mass, height, _ in before))
for name, (bodies, thigh) in seen.items():
    print(f"{name}:", *(f"{mass:g} kg at {height:+.3f} m;" for mass, height, _ in bodies), f"thigh {thigh:g} m long")
same, _ = seen["as read"]
assert np.isclose(same[0][0], 6.0) and np.allclose(same[0][2], before[0][2] + 1.0)  # the IMU sits at the trunk's centre
assert all(np.isclose(a[0], b[0]) and np.isclose(a[1], b[1]) for a, b in zip(same[1:], before[1:]))
one, _ = seen["scale 1"]
assert np.isclose(one[1][1], -0.2) and np.isclose(one[1][2][0], 3.0 * (0.1**2 + 0.4**2) / 12)  # the brick's
two, thigh = seen["scale 2"]
assert np.isclose(thigh, 0.8) and np.isclose(two[1][0], 24.0) and np.isclose(two[1][1], -0.4)
assert np.isclose(two[0][0], 41.0)
assert np.isclose(two[2][0], 2.0) and np.isclose(two[2][1], -0.15) and np.allclose(two[2][2], before[2][2])
PY
