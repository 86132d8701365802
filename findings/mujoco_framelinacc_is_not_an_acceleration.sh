#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     the sensor framelinacc ("linear acceleration in global coordinates") of a body that hangs at
#           rest reads (0, 0, 9.81), and zero of one that falls freely: gravity is subtracted, as for an
#           accelerometer. mj_objectAcceleration does the same. framelinvel differenced gives the truth.
# Guess:    an accelerometer feels gravity; a frame's acceleration in the world is d/dt of framelinvel.
# Means:    mass times this reading is the ground force, not the change of momentum: whoever adds gravity
#           once more, or tracks a trunk's acceleration with it, is 1 g off. Add the gravity vector to the
#           reading first.
# Seen:     at rest 9.81, falling 0.0; second difference of the height 0 and -9.81
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

ROBOT = """<mujoco><worldbody><body name="trunk" pos="0 0 2">{}
<geom type="box" size=".1 .1 .2" mass="3"/></body></worldbody>
<sensor><framelinacc objtype="body" objname="trunk"/><framelinvel objtype="body" objname="trunk"/>
</sensor></mujoco>"""
for state, joint, true in (("at rest", "", 0.0), ("falling", "<freejoint/>", -9.81)):
    model = mujoco.MjModel.from_xml_string(ROBOT.format(joint))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    reading, before = data.sensordata[:3].copy(), data.sensordata[3:].copy()
    motion = np.zeros(6)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_BODY, 1, motion, 0)
    mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    change = (data.sensordata[3:] - before) / model.opt.timestep
    print(f"{state}: framelinacc {reading}, mj_objectAcceleration {motion[3:]}, d/dt framelinvel {change}")
    assert np.allclose(change, [0.0, 0.0, true])
    assert np.allclose(reading, [0.0, 0.0, true + 9.81]) and np.allclose(motion[3:], reading)
PY
