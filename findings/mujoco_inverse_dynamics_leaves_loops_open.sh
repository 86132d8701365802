#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     a foot hangs on a passive ankle and is held by a crank through a rod, closed by a <connect>.
#           At rest, with the loop closed exactly, mj_inverse asks for -1.962 N·m at the passive ankle
#           and almost nothing at the crank: the rod carries no force.
# Guess:    the loop's force is part of the answer: 0 at the ankle, -1.97 N·m at the crank.
# Means:    equalities are springs: without violation, rate or acceleration they carry nothing, and the
#           inverse dynamics of an exact posture is that of the tree. Size the crank's motor with
#           J^T (the loop's Jacobian): torque at passive joints must vanish. Feet on the ground likewise.
# Seen:     mj_inverse (-1.96200, -0.00981, 0.0); with the rod's force: (0.0, -1.97181, 0.0)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

ROBOT = """<mujoco><worldbody>
<body name="foot"><joint name="ankle" axis="0 1 0"/>
<inertial pos=".1 0 0" mass="2" diaginertia=".01 .01 .01"/></body>
<body name="crank" pos="0 0 .3"><joint name="motor" axis="0 1 0"/>
<inertial pos="0 0 0" mass=".01" diaginertia="1e-5 1e-5 1e-5"/>
<body name="rod" pos=".1 0 0"><joint name="pin" axis="0 1 0"/>
<inertial pos="0 0 -.15" mass=".01" diaginertia="1e-4 1e-4 1e-4"/></body></body></worldbody>
<equality><connect body1="rod" body2="foot" anchor="0 0 -.3"/></equality></mujoco>"""
model = mujoco.MjModel.from_xml_string(ROBOT)
data = mujoco.MjData(model)
mujoco.mj_inverse(model, data)
tree = data.qfrc_inverse.copy()
print("mj_inverse (ankle, motor, pin):", tree.round(5), "force of the loop:", data.efc_force[:3])
# First principles: the loop's force makes the torque at the passive joints vanish.
jacobian = data.efc_J.reshape(-1, model.nv)[:3]
passive = [0, 2]
force = np.linalg.lstsq(jacobian[:, passive].T, tree[passive], rcond=None)[0]
closed = tree - jacobian.T @ force
print("with the force that the rod must carry:", closed.round(5))
assert np.abs(data.efc_pos[:3]).max() < 1e-12 and np.abs(data.efc_force[:3]).max() < 1e-9
assert np.isclose(tree[0], -2 * 9.81 * 0.1) and abs(tree[1]) < 0.011
assert np.allclose(closed[passive], 0.0) and np.isclose(closed[1], -0.1 * 9.81 * 2.01)
PY
