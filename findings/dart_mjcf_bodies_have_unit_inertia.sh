#!/usr/bin/env bash
# Version:  dartpy 6.20.0, mujoco 4.0.0
# Does:     DART's MJCF reader gives every body moments of inertia of 1 kg·m², whether the file states
#           them (diaginertia, fullinertia) or they follow from the shapes; masses and centres of mass
#           are right, so nothing looks wrong. The <freejoint> of the trunk is no joint. Nothing says
#           either.
# Guess:    inertias that are written in the file are read.
# Means:    a shin of 3 kg swings as if it were sixty times as hard to turn; gaits, gains and motors
#           from such a model are for another robot. Compare the mass matrix with MuJoCo's first.
# Seen:     moments [1, 1, 1] for stated [0.017, 0.017, 0.004] and for shapes of [0.625, 0.5, 0.325];
#           inertia at the knee 1.120 kg·m² (MuJoCo 0.137); degrees of freedom 2 (MuJoCo 8)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check dartpy==6.20.0 mujoco==4.0.0 \
  numpy==2.4.6
cd "$work"
cat > leg.xml <<'XML'
<mujoco model="leg">
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.1 0.15 0.2" mass="30"/>
      <body name="thigh" pos="0 0 -0.2">
        <joint name="hip" type="hinge" axis="0 1 0" range="-1 1"/>
        <geom type="box" size="0.05 0.05 0.2" pos="0 0 -0.2" mass="5"/>
        <body name="shin" pos="0 0 -0.4">
          <joint name="knee" type="hinge" axis="0 1 0" range="0 2"/>
          <inertial pos="0 0 -0.2" mass="3" diaginertia="0.017 0.017 0.004"/>
          <geom type="box" size="0.04 0.04 0.2" pos="0 0 -0.2"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
XML
"$work/env/bin/python" - "$work/leg.xml" 2>/dev/null <<'PY'
import sys

import dartpy
import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
matrix = np.zeros((model.nv, model.nv))
mujoco.mj_fullM(model, data, matrix)

(robot,) = [
    world.getSkeleton(index)
    for world in [dartpy.utils.MjcfParser.readWorld("file://" + sys.argv[1])]
    for index in range(world.getNumSkeletons())
]
for name in ("trunk", "thigh", "shin"):
    body, right = robot.getBodyNode(name), model.body(name)
    moments = np.diag(body.getInertia().getMoment())
    print(f"{name}: mass {body.getMass():g} ({right.mass[0]:g}), moments {moments} ({right.inertia})")
    assert np.isclose(body.getMass(), right.mass[0])
    assert np.allclose(body.getLocalCOM(), right.ipos)
    assert np.array_equal(moments, np.ones(3)) and right.inertia.max() < 1.0
dofs = [robot.getDof(index).getName() for index in range(robot.getNumDofs())]
knee = robot.getMassMatrix()[dofs.index("knee"), dofs.index("knee")]
print(f"degrees of freedom {len(dofs)} ({model.nv})")
print(f"knee: {knee:.3f} kg·m² (MuJoCo {matrix[-1, -1]:.3f})")
assert dofs == ["hip", "knee"] and model.nv == 8
assert np.isclose(knee - matrix[-1, -1], 1.0 - 0.017)
PY
