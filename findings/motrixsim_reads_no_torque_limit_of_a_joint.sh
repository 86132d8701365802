#!/usr/bin/env bash
# Version:  motrixsim 0.10.1 (with motrixsim-core 0.10.1), mujoco 4.0.0 to compare
# Does:     actuatorfrcrange, the torque limit of an MJCF joint, is read past: the joint gets all that its motors and servos
#           ask for. MotrixSim warns of other attributes that it does not know (actuatorgravcomp of the same joint, for
#           one), of this not. forcerange and ctrlrange of the motor count.
# Guess:    a reader that lists what it leaves out has read the rest.
# Means:    Menagerie's G1 writes the limits of its motors as actuatorfrcrange and leaves the servos without
#           forcerange: here its ankles give whatever the balance asks for, and a step that no robot can take
#           looks easy. Copy the range to forcerange, divided by the gear. No report was found.
# Seen:     15 N·m asked of a joint of 4: 15.0 N·m for 4.0; by forcerange or ctrlrange 4.0 for both; servo of kp 500
#           told to turn by 0.1 rad: 50.0 N·m for 4.0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check motrixsim==0.10.1 motrixsim-core==0.10.1 mujoco==4.0.0 \
  numpy==2.4.6
cd "$work"
cat > run.py <<'PY'
from pathlib import Path

import motrixsim
import mujoco
import numpy as np

ANKLE = """<mujoco><option timestep="0.0001" gravity="0 0 0"/><worldbody><body name="foot">
<joint name="ankle" axis="0 1 0" {}/><inertial pos="0 0 0" mass="1" diaginertia="0.08 0.08 0.08"/>
<geom type="box" size=".1 .05 .02" contype="0" conaffinity="0"/></body></worldbody><actuator>{}</actuator></mujoco>"""


def torques(joint, motor, command, rate):
    """Torque on the ankle in MotrixSim and in MuJoCo."""
    text = ANKLE.format(joint, motor)
    Path("ankle.xml").write_text(text)
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    data.qvel, data.ctrl = rate, command
    mujoco.mj_forward(theirs, data)
    model = motrixsim.load_model("ankle.xml")
    scene = motrixsim.SceneData(model)
    scene.set_dof_vel(np.array([rate], np.float32))
    scene.actuator_ctrls = np.array([command], np.float32)
    model.step(scene)
    return 0.08 * (float(scene.dof_vel[0]) - rate) / 1e-4, data.qacc[0] * 0.08


for told, joint, motor, command, rate, expected in (
    ("actuatorfrcrange 4", 'actuatorfrcrange="-4 4"', '<motor joint="ankle"/>', 15.0, 0.0, (15.0, 4.0)),
    ("forcerange 4", "", '<motor joint="ankle" forcerange="-4 4"/>', 15.0, 0.0, (4.0, 4.0)),
    ("ctrlrange 4", "", '<motor joint="ankle" ctrlrange="-4 4"/>', 15.0, 0.0, (4.0, 4.0)),
    ("servo, actuatorfrcrange 4", 'actuatorfrcrange="-4 4"', '<position joint="ankle" kp="500"/>', 0.1, 0.0, (50.0, 4.0)),
    ("actuatorgravcomp", 'actuatorgravcomp="true"', '<motor joint="ankle"/>', 3.0, 0.0, (3.0, 3.0)),
):
    print(f"ASKED {told}", flush=True)
    found = torques(joint, motor, command, rate)
    print(f"{told}: {found[0]:.2f} N·m in MotrixSim, {found[1]:.2f} in MuJoCo", flush=True)
    assert np.allclose(found, expected, atol=0.03), told
PY
"$work/env/bin/python" run.py > out 2>&1 || { cat out; exit 1; }
grep -a "in MotrixSim" out
# what it says it leaves out: an attribute of a joint, but not the one above
grep -qa "actuatorgravcomp" <(grep -a "joint@" out) || { echo "no warning of actuatorgravcomp"; exit 1; }
if grep -aE "@actuatorfrcrange" out; then echo "now it warns"; exit 1; fi
