#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     the hinges of one MJCF body become a JointModelComposite. For such a joint computeRNEADerivatives,
#           computeABADerivatives, computeGeneralizedGravityDerivatives, computeJointJacobiansTimeVariation and
#           dccrba differ from difference quotients of the functions that they differentiate, which
#           are right themselves. The same leg with each hinge in a body of its own has right derivatives.
#           Nothing is refused. (Issue 2053 of Pinocchio, open, says it of the Coriolis matrix and a
#           JointModelSphericalZYX, whose axes also turn with the angles of the joint.)
# Guess:    what is not refused is right, as it is for every joint of a single axis and for the free flyer.
# Means:    hips and ankles of two or three hinges are how MuJoCo's and dm_control's humanoids are drawn:
#           a trajectory optimiser on these derivatives walks along wrong gradients and stops anywhere. Give
#           every hinge a body (or URDF link) of its own, or compare one row with a difference quotient.
# Seen:     leg of 9 kg: d torque/d q off by 8.9 N·m/rad at rest and by 9.5 moving, of 24.6 at most; Jacobian's rate
#           off by 1.6; hinges in bodies of their own: 1e-8 at most
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin

HINGE = '<joint name="hip_{}" axis="{}" range="-100 100"/>'
HIP = [HINGE.format("x", "1 0 0"), HINGE.format("z", "0 0 1"), HINGE.format("y", "0 1 0")]
LIGHT = '<inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/><body name="hip_{}">'
OWN = HIP[0] + LIGHT.format(2) + HIP[1] + LIGHT.format(3) + HIP[2]
LEG = """<mujoco><worldbody><body name="thigh">{}<inertial pos="0 0 -.2" mass="6" diaginertia=".1 .1 .02"/>
<body name="shin" pos="0 0 -.4"><joint name="knee" axis="0 1 0" range="-100 100"/>
<inertial pos="0 0 -.2" mass="3" diaginertia=".05 .05 .01"/></body></body>{}</worldbody></mujoco>"""


def slopes(f, q):
    """Central difference quotients of f over the angles."""
    return np.array([f(q + 1e-6 * e) - f(q - 1e-6 * e) for e in np.eye(len(q))]).T / 2e-6


def errors(hip, end):
    """Joints, by how much d(torque)/dq (at rest, moving) and dJ/dt are off, and the torques."""
    Path("leg.xml").write_text(LEG.format(hip, end))
    read = pin.buildModelFromMJCF("leg.xml")
    model = read[0] if isinstance(read, tuple) else read
    data, q, rates = model.createData(), np.array([0.3, 0.2, -0.5, 0.8]), np.array([1.0, 2.0, -1.0, 0.5])
    off = []
    for v in (0 * rates, rates):
        given = pin.computeRNEADerivatives(model, data, q, v, 0 * v)[0].copy()
        right = slopes(lambda x: pin.rnea(model, data, x, v, 0 * v), q)
        off.append((np.abs(given - right).max(), np.abs(right).max()))
    turn = pin.computeJointJacobiansTimeVariation(model, data, q, rates).copy()
    ahead, behind = (
        pin.computeJointJacobians(model, data, q + h * rates).copy() for h in (1e-6, -1e-6)
    )
    off.append((np.abs(turn - (ahead - behind) / 2e-6).max(), np.abs(turn).max()))
    torque = pin.rnea(model, data, q, rates, 0 * rates)
    acceleration = pin.aba(model, data, q, rates, torque)
    assert np.abs(acceleration).max() < 1e-8  # inverse and forward dynamics agree in both models
    return [joint.shortname() for joint in model.joints][1:], off, torque


one, own = errors("".join(HIP), ""), errors(OWN, "</body></body>")
for name, (joints, off, torque) in (("one body", one), ("own bodies", own)):
    print(f"{name}: {[joint.removeprefix('JointModel') for joint in joints]}, torques {torque.round(3)} N·m")
    for what, (error, largest) in zip(("at rest d torque/d q", "moving d torque/d q", "dJ/dt"), off):
        print(f"  {what} off by {error:.2g}, largest {largest:.3g}")
assert len(one[0]) == 2 and len(own[0]) == 4
assert np.abs(one[2] - own[2]).max() < 1e-6  # the same leg
assert all(error > 0.5 for error, _ in one[1]) and all(error < 1e-6 for error, _ in own[1])
PY
