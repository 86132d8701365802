#!/usr/bin/env bash
# Version:  holosoma 0.0.3 (motion clips of Unitree G1), mujoco 4.0.0
# Does:     joint_vel of a clip is a MuJoCo velocity of 35 numbers, but its base turns about the axes of
#           the world, where MuJoCo has those of the trunk. The clip's own body_lin_vel_w and
#           body_ang_vel_w were computed by MuJoCo from it, so they are wrong too: they are not the
#           derivative of body_pos_w, by up to 2.6 m/s at a foot. The angles' rates are exact.
# Guess:    arrays of one file, made by one program, agree; body_ang_vel_w looks like a check.
# Means:    a tracker rewarded for these velocities is asked to slide its planted foot. Difference the
#           positions yourself, or turn joint_vel[3:6] by the base's inverse rotation first.
# Seen:     planted left foot: 0.015 m/s by its positions, 0.546 by body_lin_vel_w; the base's rate fits
#           the quaternions in world axes within 0.02 rad/s, in the trunk's axes within 3.8
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  holosoma==0.0.3
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np

data_folder = Path("robots/holosoma/data")
(clip,) = data_folder.rglob("sub3_largebox_003_mj.npz")
motion = np.load(clip)
(scene,) = data_folder.rglob("scene_g1_29dof_wbt_plane.xml")
model = mujoco.MjModel.from_xml_path(str(scene))
data = mujoco.MjData(model)
step = 1.0 / float(motion["fps"][0])
q, v = motion["joint_pos"], motion["joint_vel"]
foot = list(motion["body_names"]).index("left_ankle_roll_link")
body = model.body("left_ankle_roll_link").id

# By hand: rotation over two instants, as a vector in the axes of the trunk and of the world.
off_trunk = off_world = 0.0
for k in range(1, len(q) - 1):
    local, matrix = np.zeros(3), np.zeros(9)
    mujoco.mju_subQuat(local, q[k + 1, 3:7], q[k - 1, 3:7])
    mujoco.mju_quat2Mat(matrix, q[k, 3:7])
    local /= 2.0 * step
    off_trunk = max(off_trunk, np.abs(v[k, 3:6] - local).max())
    off_world = max(off_world, np.abs(v[k, 3:6] - matrix.reshape(3, 3) @ local).max())
joints_off = np.abs(v[:, 6:] - np.gradient(q[:, 7:], step, axis=0)).max()
print(f"base rate off by {off_trunk:.2f} rad/s in the trunk's axes, {off_world:.2f} in the world's; "
      f"joint rates off by {joints_off:.1e}")
assert off_trunk > 3.5 and off_world < 0.25 and joints_off < 1e-5

# The stored rates of the bodies are what MuJoCo makes of that velocity, to the last digit.
worst = 0.0
for k in range(len(q)):
    data.qpos[:], data.qvel[:] = q[k], v[k]
    mujoco.mj_forward(model, data)
    twist = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, twist, 0)
    worst = max(worst, np.abs(twist[:3] - motion["body_ang_vel_w"][k, foot]).max())
    assert np.allclose(data.xpos[body], motion["body_pos_w"][k, foot], atol=1e-9)
print(f"body_ang_vel_w is MuJoCo's with the base turned so, within {worst:.1e} rad/s")
assert worst < 1e-9

true = np.gradient(motion["body_pos_w"][:, foot], step, axis=0)
stored = motion["body_lin_vel_w"][:, foot]
planted = np.linalg.norm(true[:, :2], axis=1) < 0.02
speeds = [float(np.linalg.norm(x[planted], axis=1).mean()) for x in (true, stored)]
print(f"planted foot ({planted.sum()} instants): {speeds[0]:.3f} m/s, stored {speeds[1]:.3f}; "
      f"largest difference {np.abs(true - stored).max():.2f}")
assert speeds[0] < 0.02 and speeds[1] > 0.5
PY
