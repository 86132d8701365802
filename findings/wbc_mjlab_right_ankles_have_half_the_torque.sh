#!/usr/bin/env bash
# Version:  wbc-mjlab 0.0.6 (its scenes of the Unitree G1 for MuJoCo, scene_g1.xml and scene_g1_23dof.xml), mujoco 4.0.0
# Does:     the motors of the left ankle, pitch and roll, take commands to ±50 N·m, those of the right ankle to ±25 N·m. The
#           joints themselves are limited to ±50 N·m on both sides, and all other pairs of joints, motors and bodies
#           are twins. Commands beyond are cut without a word.
# Guess:    left and right of one robot have one motor; 50 N·m on both sides, as the joints say.
# Means:    policies are checked in these scenes before they go to the robot: on the right foot alone the centre of
#           pressure gets only half as far to the toe, and a fall to the right looks like a fault of the policy.
#           Set ctrlrange of the two right motors to the actuatorfrcrange of their joints.
# Seen:     commanded 40 N·m on every ankle motor: left joints 40 and 40, right joints 25 and 25 N·m; robot of 33.3 kg on one
#           foot: ±25 N·m carry the centre of pressure 0.076 m to the front, ±50 N·m 0.153 m; the sole ends at 0.125 m
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/wbc" wbc-mjlab==0.0.6
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np

for name in ("scene_g1.xml", "scene_g1_23dof.xml"):
    model = mujoco.MjModel.from_xml_path(str(Path("wbc/wbc_mjlab/robots/g1/xmls", name).resolve()))
    data = mujoco.MjData(model)
    joints = ("left_ankle_pitch", "left_ankle_roll", "right_ankle_pitch", "right_ankle_roll")
    for each in joints:
        data.actuator(each).ctrl[:] = 40.0
    mujoco.mj_forward(model, data)
    torques = np.array([data.joint(f"{each}_joint").qfrc_actuator[0] for each in joints])
    limits = np.array([model.jnt_actfrcrange[model.joint(f"{each}_joint").id] for each in joints])
    print(f"{name}: 40 N·m commanded, {torques} N·m at {joints}")
    assert np.allclose(torques, [40, 40, 25, 25]) and np.allclose(limits, [-50, 50])
    # every other pair is one of twins
    other = {"left": "right"}
    unlike = []
    for i in range(model.nu):
        left = model.actuator(i).name
        if left.startswith("left"):
            a, b = model.actuator(left).ctrlrange, model.actuator(left.replace("left", "right")).ctrlrange
            unlike += [left] if not np.allclose(np.abs(a), np.abs(b)) else []
    for i in range(model.nbody):
        left = model.body(i).name
        if left.startswith("left"):
            right = left.replace("left", "right")
            assert np.isclose(model.body(left).mass, model.body(right).mass, rtol=0.01)
            assert np.allclose(model.body(left).inertia, model.body(right).inertia, rtol=0.01)
    assert unlike == ["left_ankle_pitch", "left_ankle_roll"]
    # standing on one foot: how far the centre of pressure gets, and how far the sole reaches
    weight = 9.81 * model.body_subtreemass[1]
    sole = [model.geom(g) for g in range(model.ngeom) if model.geom(g).bodyid == model.body("right_ankle_roll_link").id]
    toe = max(geom.pos[0] + geom.size[0] for geom in sole if geom.type == mujoco.mjtGeom.mjGEOM_SPHERE)
    reach = [model.actuator(f"{side}_ankle_pitch").ctrlrange[1] / weight for side in ("right", "left")]
    print(f"   {weight / 9.81:.1f} kg: centre of pressure to {reach[0]:.3f} m on the right, {reach[1]:.3f} m on the left; toe at {toe:.3f} m")
    assert reach[0] < 0.08 < toe < 0.15 < reach[1]
PY
