#!/usr/bin/env bash
# Version:  pybullet 3.2.7 against pin 4.1.0
# Does:     when the inertial frame of the root link is turned (rpy of <inertial>), calculateInverseDynamics
#           turns gravity with it. The mass matrix stays right. For a root that is fixed to the world, whose
#           inertia moves nothing, the holding torque of a hip changes from 0.896 to -0.064 N·m.
# Guess:    the frame in which the inertia of a fixed link is written is of no consequence.
# Means:    CAD exports turn the inertial frame of a pelvis to its principal axes. Gravity compensation
#           from such a file is wrong while its mass matrix and its poses pass every comparison. Give the
#           root an inertial frame without rotation (turn the tensor instead), and compare torques at rest.
# Seen:     rpy 0: (0.89647, -0.06676) in both; rpy (0.3, 0.2, 0.1): (-0.06367, -0.13312) in PyBullet
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin
import pybullet

URDF = """<robot name="r"><link name="pelvis"><inertial><origin xyz="0 0 0" rpy="{}"/><mass value="5"/>
<inertia ixx=".2" ixy="0" ixz="0" iyy=".3" iyz="0" izz=".25"/></inertial></link>
<link name="leg"><inertial><origin xyz=".05 .02 -.2"/><mass value="1"/>
<inertia ixx=".02" ixy="0" ixz="0" iyy=".03" iyz="0" izz=".04"/></inertial></link>
<link name="foot"><inertial><origin xyz=".05 0 -.05"/><mass value=".5"/>
<inertia ixx=".002" ixy="0" ixz="0" iyy=".003" iyz="0" izz=".004"/></inertial></link>
<joint name="hip" type="revolute"><parent link="pelvis"/><child link="leg"/><origin xyz="0 .1 0"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="7" velocity="3"/></joint>
<joint name="ankle" type="revolute"><parent link="leg"/><child link="foot"/><origin xyz=".01 .02 -.4"/>
<axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="7" velocity="3"/></joint></robot>"""
q, rest = [0.4, -0.3], [0.0, 0.0]
pybullet.connect(pybullet.DIRECT)
pybullet.setGravity(0, 0, -9.81)
turned = pin.rpy.rpyToMatrix(0.3, 0.2, 0.1)
for name, rpy, frame in (("a", "0 0 0", np.eye(3)), ("b", "0.3 0.2 0.1", turned)):
    path = Path.cwd() / f"{name}.urdf"
    path.write_text(URDF.format(rpy))
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    mass = pin.crba(model, data, np.array(q))
    held = pin.computeGeneralizedGravity(model, data, np.array(q))
    robot = pybullet.loadURDF(
        str(path), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE
    )
    seen = np.array(pybullet.calculateInverseDynamics(robot, q, rest, rest))
    print(f"root's inertial frame turned by {rpy}: pin {held.round(5)}, PyBullet {seen.round(5)}")
    assert np.allclose(pybullet.calculateMassMatrix(robot, q), mass)
    model.gravity.linear = frame @ [0.0, 0.0, -9.81]  # gravity as a vector of that frame
    assert np.allclose(pin.computeGeneralizedGravity(model, data, np.array(q)), seen, atol=1e-6)
    assert np.allclose(seen, held, atol=1e-6) == (rpy == "0 0 0")
PY
