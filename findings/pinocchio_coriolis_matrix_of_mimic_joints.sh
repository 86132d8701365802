#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     a model read with `mimic=True` is refused in words by every algorithm that does not know such
#           joints (aba, computeMinverse, computeRNEADerivatives, energies, regressors, ...), but
#           `computeCoriolisMatrix` answers, and wrongly: C v is not nonLinearEffects minus gravity,
#           which are both right. `computeJointJacobians` answers with a column for each joint, the one
#           that follows too, where `getJointJacobian` and all frame Jacobians have one per motor.
# Guess:    what is not refused is right, and both Jacobians have nv columns.
# Means:    passivity-based and computed-torque controllers that take C from it are wrong by newton metres
#           for robots with parallel fingers, grippers or coupled hips; take nonLinearEffects instead.
# Seen:     C v differs from G' C_full G v of the same robot with free joints by several N·m, from
#           nonLinearEffects - gravity likewise; Jacobians (6, 4) and (6, 3)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin

RATIO, OFFSET = -1.7, 0.3
AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0")


def arm(mimic):
    """Return the URDF of four links; the third joint follows the second, or not."""
    text = ""
    for i in range(5):
        text += (
            f'<link name="l{i}"><inertial><origin xyz="{0.1 + 0.02 * i} 0.03 {0.05 * i}"/>'
            f'<mass value="{1 + i}"/><inertia ixx="{0.1 + 0.01 * i}" iyy="0.12" ixy="0.001"'
            f' izz="{0.13 + 0.01 * i}" ixz="0" iyz="0.002"/></inertial></link>'
        )
    for i, axis in enumerate(AXES):
        follows = f'<mimic joint="j1" multiplier="{RATIO}" offset="{OFFSET}"/>'
        text += (
            f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="0.1 0.02 0.3" rpy="0.1 0.2 0.3"/><axis xyz="{axis}"/>'
            f'<limit lower="-3" upper="3" effort="10" velocity="5"/>'
            f"{follows if mimic and i == 2 else ''}</joint>"
        )
    return f'<robot name="arm">{text}</robot>'


tied = pin.buildModelFromXML(arm(True), mimic=True)
free = pin.buildModelFromXML(arm(False))
data, whole = tied.createData(), free.createData()
G = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, RATIO, 0], [0, 0, 1.0]])
q, v, a = np.random.default_rng(1).standard_normal((3, 3))
Q, V, A = G @ q + [0.0, 0.0, OFFSET, 0.0], G @ v, G @ a

assert np.abs(pin.rnea(tied, data, q, v, a) - G.T @ pin.rnea(free, whole, Q, V, A)).max() < 1e-12
bias = pin.nonLinearEffects(tied, data, q, v) - pin.computeGeneralizedGravity(tied, data, q)
right = G.T @ pin.computeCoriolisMatrix(free, whole, Q, V) @ V
assert np.abs(bias - right).max() < 1e-12
refused = 0
for ask in (
    lambda: pin.aba(tied, data, q, v, a),
    lambda: pin.computeMinverse(tied, data, q),
    lambda: pin.computeRNEADerivatives(tied, data, q, v, a),
    lambda: pin.computeKineticEnergy(tied, data, q, v),
):
    try:
        ask()
    except RuntimeError as error:
        refused += "Mimic" in str(error)
print(f"refused in words: {refused} of 4")
answer = pin.computeCoriolisMatrix(tied, data, q, v) @ v
print(f"C v:                 {np.round(answer, 3)} N·m")
print(f"bias minus gravity:  {np.round(bias, 3)} N·m")
columns = pin.computeJointJacobians(tied, data, q).shape, pin.getJointJacobian(
    tied, data, 4, pin.WORLD
).shape
print(f"Jacobians: computeJointJacobians {columns[0]}, getJointJacobian {columns[1]}")
assert refused == 4
assert np.abs(answer - bias).max() > 1.0
assert columns == ((6, 4), (6, 3))
PY
