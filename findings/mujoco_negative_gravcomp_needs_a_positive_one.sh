#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     gravcomp = -1 on a body of a tree does nothing as long as no body of the model has a positive
#           gravcomp. With 0.5 on any other body the -1 counts in full: the body weighs double.
# Guess:    a factor acts for its own body whatever the others have, or a negative one is refused.
# Means:    a load that is imitated by a negative compensation (a cheap way to try a payload) appears
#           and vanishes with an attribute elsewhere in the file. Add the mass to the body instead.
# Seen:     hip torque of compensation 0 for (-1, 0) and -3.924 for (-1, 0.5), where -6.867 is that of
#           (0, 0.5) and 2.943 the weight's moment of the first body
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

LEG = """<mujoco><worldbody><body gravcomp="{}"><joint axis="0 1 0"/>
<geom size=".1" mass="1" pos=".3 0 0"/><body pos=".5 0 0" gravcomp="{}"><joint axis="0 1 0"/>
<geom size=".1" mass="2" pos=".2 0 0"/></body></body></worldbody></mujoco>"""


def hip(thigh, shank):
    model = mujoco.MjModel.from_xml_string(LEG.format(thigh, shank))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return float(data.qfrc_gravcomp[0])


found = {pair: hip(*pair) for pair in ((0.0, 0.5), (-1.0, 0.0), (-1.0, 0.5), (1.0, 0.0))}
for (thigh, shank), torque in found.items():
    print(f"gravcomp of thigh {thigh}, of shank {shank}: {torque:.3f} N·m at the hip")
assert found[-1.0, 0.0] == 0.0 and np.isclose(found[1.0, 0.0], -9.81 * 0.3)
assert np.isclose(found[-1.0, 0.5], found[0.0, 0.5] + 9.81 * 0.3)
PY
