#!/usr/bin/env bash
# Version:  adam-robotics 0.5.0, mujoco 4.0.0, dm-control 1.0.50 (its humanoid)
# Does:     KinDynComputations.from_mujoco_model lists every hinge of a body as an actuated joint, and
#           moves the body with the last of them alone. The rows and columns of the others in the mass
#           matrix are zero, and so are their gravity torques. Nothing says so.
# Guess:    what is listed moves the robot: MuJoCo's hips and ankles are two or three hinges of one body.
# Means:    inverse dynamics of such a robot asks no torque of two hip joints out of three; forward
#           dynamics divides by a singular matrix. Look at the rank of the mass matrix first.
# Seen:     21 joints listed; rank 18 of 27; zero rows of abdomen_z and of hip_x, hip_z, ankle_y,
#           shoulder1 of both sides, where MuJoCo has 0.0146 to 1.80 kg·m² without armature;
#           gravity torques there 0, also with all joints bent by 0.1 rad, where MuJoCo has up to 6.6 N·m
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check adam-robotics==0.5.0 mujoco==4.0.0
"$work/env/bin/pip" download --quiet --disable-pip-version-check --no-deps --dest "$work" dm-control==1.0.50
cd "$work"
python3 -m zipfile -e dm_control-*.whl wheel
"$work/env/bin/python" - wheel/dm_control/suite/humanoid.xml 2>/dev/null <<'PY'
import sys

import mujoco
import numpy as np
from adam.numpy import KinDynComputations

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
right = np.zeros((model.nv, model.nv))
mujoco.mj_fullM(model, data, right)
right -= np.diag(model.dof_armature)

robot = KinDynComputations.from_mujoco_model(model)
names = [model.joint(row).name for row in range(1, model.njnt)]
listed = list(robot.rbdalgos.model.actuated_joints)
base = np.eye(4)
base[:3, 3] = data.xpos[1]
read = robot.mass_matrix(base, np.zeros(len(listed)))
print(f"joints: {len(listed)} listed, {len(names)} in the file; rank {np.linalg.matrix_rank(read)} of {len(read)}")
assert listed == names and np.linalg.matrix_rank(read) == 18 and len(read) == 27

bent = np.full(len(listed), 0.1)
data.qpos[7:] = bent
mujoco.mj_forward(model, data)
still = [row for row in range(len(names)) if not np.any(read[6 + row])]
for row in still:
    print(f"{names[row]}: {read[6 + row, 6 + row]:.4f} kg·m² (MuJoCo {right[6 + row, 6 + row]:.4f})")
several = [
    model.joint(first + k).name
    for first, count in zip(model.body_jntadr, model.body_jntnum, strict=True)
    for k in range(count - 1)
]
pulled = np.abs(robot.gravity_term(base, bent)[6:][still]).max()
there = np.abs(data.qfrc_bias[6:][still]).max()
print(f"gravity torques of these, all joints bent by 0.1 rad: {pulled:.4f} N·m (MuJoCo up to {there:.1f})")
assert pulled < 1e-9 and there > 1.0
assert [names[row] for row in still] == several and all(right[6 + row, 6 + row] > 0.01 for row in still)
PY
