#!/usr/bin/env bash
# Version:  newton 1.8.0, warp-lang 1.19.0, mujoco 4.0.0, dm-control 1.0.50 (its humanoid)
# Does:     Newton's MJCF reader makes one joint of the hinges of a body, at the place of the first; the
#           places of the others are lost. None of its warnings says so.
# Guess:    two hinges 40 mm apart are two axes, as in MuJoCo.
# Means:    the ankle of this humanoid rolls about an axis 40 mm too high; feet that a motion puts flat on
#           the ground hang in the air or sink. Give each hinge a body of its own.
# Seen:     ankle_x of the file at 0.04 m, ankle_y at 0.08 m; one D6 joint, both axes at 0.08 m; the foot
#           moves to a place 17.7 mm from where MuJoCo has it when ankle_x turns by 0.5 rad
set -euo pipefail
work=$(mktemp -d)
export WARP_CACHE_PATH="$work/cache"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check newton==1.8.0 warp-lang==1.19.0 mujoco==4.0.0
"$work/env/bin/pip" download --quiet --disable-pip-version-check --no-deps --dest "$work" dm-control==1.0.50
cd "$work"
python3 -m zipfile -e dm_control-*.whl wheel
"$work/env/bin/python" - wheel/dm_control/suite/humanoid.xml 2>/dev/null <<'PY'
import sys
import warnings

import mujoco
import newton
import numpy as np
import warp

JOINT, ANGLE = "right_ankle_x", 0.5
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
data.qpos[:] = model.qpos0
data.joint(JOINT).qpos = ANGLE
mujoco.mj_forward(model, data)
right = data.body("right_foot").xpos

builder = newton.ModelBuilder()
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    builder.add_mjcf(sys.argv[1])
print(f"warnings: {[str(one.message)[:90] for one in told]}")
assert not any("ankle" in str(one.message) for one in told)
(row,) = [row for row, name in enumerate(builder.joint_label) if name.endswith("right_ankle_y_right_ankle_x")]
place = np.array(builder.joint_X_c[row])[:3]
written = [model.joint(name).pos for name in ("right_ankle_y", JOINT)]
print(f"kind: {builder.joint_type[row].name}; place {place} (of the file: {written[0]} and {written[1]})")
assert builder.joint_type[row] == newton.JointType.D6 and np.allclose(place, written[0])
assert not np.allclose(place, written[1])

robot = builder.finalize(device="cpu")
angles = np.array(builder.joint_q)
angles[:3] = data.qpos[:3]
angles[builder.joint_q_start[row] + 1] = ANGLE
state = robot.state()
warp_angles = warp.array(angles, dtype=float, device="cpu")
newton.eval_fk(robot, warp_angles, robot.joint_qd, state)
(foot,) = [row for row, name in enumerate(builder.body_label) if name.endswith("right_foot")]
read = state.body_q.numpy()[foot][:3]
print(f"foot at {read} (MuJoCo {right}): {1e3 * np.linalg.norm(read - right):.1f} mm apart")
assert 0.01 < np.linalg.norm(read - right) < 0.03
PY
