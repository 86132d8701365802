#!/usr/bin/env bash
# Version:  gymnasium 1.4.0 (Humanoid-v5, HumanoidStandup-v5) and dm_control 1.0.50 (suite), mujoco 4.0.0
# Does:     Humanoid's left knee has a spring of 1 N·m/rad and its right knee none; the left hip pitch has
#           an armature of 0.010, the right one 0.008 kg·m². In HumanoidStandup and dm_control's
#           humanoid the left hip bends to 120 degrees, the right one to 110. All else is a mirror image.
# Guess:    the best known humanoid of learning is symmetric; papers on symmetric policies assume it.
# Means:    a mirrored state and action do not give a mirrored motion here, so a loss or augmentation by
#           mirroring is biased, and a gait cannot be built from one step and its mirror image. Compare
#           left and right in the compiled model before you assume it.
# Seen:     released from a mirror-symmetric pose without torque, the knees differ by 45 degrees after
#           1 s; with the left leg's numbers given to the right one by 0.0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  gymnasium==1.4.0 dm_control==1.0.50
cd "$work"
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

FILES = {
    "Humanoid": "robots/gymnasium/envs/mujoco/assets/humanoid.xml",
    "HumanoidStandup": "robots/gymnasium/envs/mujoco/assets/humanoidstandup.xml",
    "dm_control": "robots/dm_control/suite/humanoid.xml",
}


def differences(model):
    """What left and right joints of one name do not share."""
    found = {}
    for k in range(model.njnt):
        name = model.joint(k).name
        if not name.startswith("left_"):
            continue
        other, dof = model.joint(name.replace("left_", "right_")).id, model.jnt_dofadr
        if "hip" in name or "knee" in name:
            pair = np.degrees(model.jnt_range[[k, other]])
            if not np.allclose(*pair):
                found[name, "range"] = [float(x) for x in pair[:, 0].round(1)]
        stiffness = model.jnt_stiffness.reshape(model.njnt, -1)[[k, other], 0]
        if stiffness[0] != stiffness[1]:
            found[name, "stiffness"] = stiffness.tolist()
        armature = model.dof_armature[[dof[k], dof[other]]]
        if armature[0] != armature[1]:
            found[name, "armature"] = armature.tolist()
    return found


def knee_difference(model):
    """Hang the robot in the air by its trunk, knees bent alike, and let go of the joints for 1 s."""
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    data.qpos[2] = 3.0
    knees = [model.joint(side + "_knee").qposadr[0] for side in ("left", "right")]
    data.qpos[knees] = -1.5
    while data.time < 1.0:
        mujoco.mj_step(model, data)
    return float(np.degrees(data.qpos[knees[0]] - data.qpos[knees[1]]))


models = {name: mujoco.MjModel.from_xml_path(file) for name, file in FILES.items()}
found = {name: differences(model) for name, model in models.items()}
for name in found:
    print(name, found[name])
assert found["Humanoid"] == {
    ("left_hip_y", "armature"): [0.01, 0.008],
    ("left_knee", "stiffness"): [1.0, 0.0],
}
for name in ("HumanoidStandup", "dm_control"):
    assert found[name]["left_hip_y", "range"] == [-120.0, -110.0]

model = models["Humanoid"]
apart = knee_difference(model)
left, right = (model.joint(side + "_knee").id for side in ("left", "right"))
model.jnt_stiffness[right] = model.jnt_stiffness[left]
model.dof_armature[model.joint("right_hip_y").dofadr] = 0.01
alike = knee_difference(model)
print(f"knees apart after 1 s: {apart:.1f} degrees; with equal legs {alike:.1f}")
assert abs(apart) > 5.0 and abs(alike) < 0.1
PY
