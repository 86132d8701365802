#!/usr/bin/env bash
# Version:  example-robot-data 6.0.0 (simple_humanoid.urdf), pin 4.1.0
# Does:     each of the 29 moving links of the example humanoid has 1 kg·m² about every axis of its own, the feet
#           (1.9 kg) and the wrists (0.4 kg) like the chest. A foot of 1.9 kg needs a radius of 0.73 m for that.
#           The mass matrix is made of them: of the inertia at the ankle's roll 93 % is this placeholder, at the knee
#           66 %, at the wrist 99.6 %. Ranges of the legs belong to the joint above: the ankle's pitch turns from
#           0 to 150 degrees, a knee's range, and only one way.
# Guess:    the humanoid of tutorials and benchmarks stands for a humanoid; its total mass and its poses do.
# Means:    torques, costs and step times found on it are those of no robot (armature of real ankles is 0.01 to
#           0.4 kg·m²), and a gain that suits its ankle's roll is 14 times that of the same masses as points.
#           Compare sqrt(moment / mass) with the size of the link.
# Seen:     diagonal of the mass matrix with the file's moments and with the same masses as points: ankle roll 1.076 and
#           0.076, knee 4.535 and 1.535, hip yaw 4.213 and 0.213, wrist roll 1.004 and 0.004 kg·m²; radius of
#           gyration of the foot 0.73 m, of the wrist 1.58 m, of the whole robot 0.54 m; range of both
#           ankle pitches 0 to 2.618 rad
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/data" \
  example-robot-data==6.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin

(file,) = Path("data").rglob("simple_humanoid_description/urdf/simple_humanoid.urdf")
model = pin.buildModelFromUrdf(str(file))
points = model.copy()
for k in range(1, model.njoints):
    body = model.inertias[k]
    points.inertias[k] = pin.Inertia(body.mass, body.lever, np.zeros((3, 3)))


def matrix(model):
    full = pin.crba(model, model.createData(), pin.neutral(model))
    return np.triu(full) + np.triu(full, 1).T


whole, by_points = matrix(model), matrix(points)
shares = {}
for name in ("LLEG_ANKLE_R", "LLEG_KNEE", "LLEG_HIP_Y", "LARM_WRIST_R"):
    at = model.joints[model.getJointId(name)].idx_v
    shares[name] = whole[at, at], by_points[at, at]
    print(f"{name}: {whole[at, at]:.3f} kg m2, by the masses alone {by_points[at, at]:.3f}")

# Unit tensors turn alike about every axis, so each adds exactly 1 to the joint that carries it and to those above
# that turn about any axis: the ankle's roll carries one link, its pitch two, the knee three.
for name, bodies in (("LLEG_ANKLE_R", 1), ("LLEG_ANKLE_P", 2), ("LLEG_KNEE", 3), ("LARM_WRIST_R", 1)):
    at = model.joints[model.getJointId(name)].idx_v
    assert abs(whole[at, at] - by_points[at, at] - bodies) < 1e-9, name
assert abs(shares["LLEG_ANKLE_R"][1] - 0.076) < 1e-3

units = [k for k in range(1, model.njoints) if np.allclose(model.inertias[k].inertia, np.eye(3))]
print(f"{len(units)} of {model.njoints - 1} moving bodies have the unit tensor")
for name, least in (("LLEG_ANKLE_R", 0.72), ("LARM_WRIST_R", 1.5)):
    body = model.inertias[model.getJointId(name)]
    radius = (np.linalg.eigvalsh(body.inertia)[0] / body.mass) ** 0.5
    print(f"{name}: {body.mass} kg, radius of gyration {radius:.2f} m")
    assert radius > least
data = model.createData()
pin.ccrba(model, data, pin.neutral(model), np.zeros(model.nv))
size = (np.linalg.eigvalsh(data.Ig.inertia)[0] / data.Ig.mass) ** 0.5
print(f"whole robot: {data.Ig.mass:.1f} kg, smallest radius of gyration {size:.2f} m")
for side in "LR":
    at = model.joints[model.getJointId(side + "LEG_ANKLE_P")].idx_q
    assert np.allclose([model.lowerPositionLimit[at], model.upperPositionLimit[at]], [0.0, 2.618])
assert abs(size - 0.54) < 0.01
assert len(units) == model.njoints - 1
PY
