#!/usr/bin/env bash
# Version:  truerig 0.1.1, mujoco 4.0.0
# Does:     the converter reads an MJCF robot, writes it and prints a fidelity report of what was lost. The armature,
#           damping and dry friction of all joints, the actuators, the place of a hinge in its body (pos) and that
#           of the root are lost, and the report says "verdict: PASS errors=0 warnings=0"; with --strict it ends
#           with 0. Only another command, simcheck, which compares two simulations, sees a difference.
# Guess:    a report of everything that changed names the inertia that is gone.
# Means:    a light foot keeps a sixth of its inertia at the ankle here, and a leg whose hinge stands 3 cm up the shin
#           bends 3 cm lower: another robot with a certificate. Compare the mass matrix, and the foot of a bent
#           leg, with MuJoCo's own reading.
# Seen:     inertia at the ankle 0.0060 kg·m² for 0.0360 (armature 0.030 in the file, 0 after); damping 0 for 0.5,
#           frictionloss 0 for 0.3, actuators 0 for 2; foot of the knee bent by 1.2 rad off by 34 mm; with hinges in
#           the origins of their bodies and without the rest: all to 1e-8
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check truerig==0.1.1 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np

LEG = """<mujoco model="leg">
  <compiler angle="radian"/>
  <worldbody>
    <body name="thigh" pos="0 0 1">
      <inertial pos="0 0 -0.2" mass="5" diaginertia="0.08 0.08 0.01"/>
      <body name="shin" pos="0 0 -0.4">
        <joint name="knee" axis="0 1 0" PLACE REST/>
        <inertial pos="0 0 -0.15" mass="2" diaginertia="0.02 0.02 0.003"/>
        <body name="foot" pos="0 0 -0.4">
          <joint name="ankle" axis="0 1 0" REST/>
          <inertial pos="0.03 0 -0.03" mass="1" diaginertia="0.0012 0.0042 0.0045"/>
        </body>
      </body>
    </body>
  </worldbody>
  MOTORS
</mujoco>"""
MOTORS = '<actuator><motor joint="knee" gear="60"/><motor joint="ankle" gear="30"/></actuator>'


def convert(name, place="", rest="", motors=""):
    """The model as MuJoCo reads it before and after, and the report."""
    text = LEG.replace("PLACE", place).replace("REST", rest).replace("MOTORS", motors)
    Path(name + ".xml").write_text(text)
    command = [Path(sys.executable).with_name("truerig"), "convert", name + ".xml", name + "_after.xml"]
    done = subprocess.run([*command, "--report", "text", "--strict"], capture_output=True, text=True)
    models = [mujoco.MjModel.from_xml_path(name + end) for end in (".xml", "_after.xml")]
    return models, done.stdout, done.returncode


def state(model):
    """Mass matrix [kg m2] and place of the foot from the root [m], knee at 1.2 and ankle at 0.3 rad."""
    data, matrix = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    data.joint("knee").qpos[0], data.joint("ankle").qpos[0] = 1.2, 0.3
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, matrix)
    return matrix, data.body("foot").xpos - data.body("thigh").xpos


(before, after), report, code = convert("plain")
for a, b in zip(state(before), state(after), strict=True):
    assert np.allclose(a, b, atol=1e-8)

(before, after), report, code = convert("rotors", "", 'armature="0.03" damping="0.5" frictionloss="0.3"', MOTORS)
matrices = state(before)[0], state(after)[0]
print(*[line.strip() for line in report.splitlines() if "verdict" in line], "exit", code)
print(f"inertia at the ankle {matrices[0][1, 1]:.4f} before, {matrices[1][1, 1]:.4f} kg m2 after")
print(f"damping {after.dof_damping.max()}, friction {after.dof_frictionloss.max()}, actuators {after.nu}")
assert "verdict: PASS" in report and "errors=0  warnings=0" in report and code == 0
assert not any(word in report for word in ("armature", "damping", "friction of", "frictionloss", "actuator"))
# By hand: the foot about the ankle is its own moment and its mass times the distance squared.
assert abs(matrices[1][1, 1] - (0.0042 + 0.03**2 + 0.03**2)) < 1e-8
assert np.allclose(matrices[0] - matrices[1], 0.03 * np.eye(2), atol=1e-8)
assert (before.nu, after.nu) == (2, 0)
assert before.dof_armature.min() == 0.03 and after.dof_armature.max() == 0.0
assert not after.dof_damping.any() and not after.dof_frictionloss.any()

(before, after), report, code = convert("moved", 'pos="0 0 0.03"')
feet = state(before)[1], state(after)[1]
print(*[line.strip() for line in report.splitlines() if "verdict" in line], "exit", code)
off = float(np.linalg.norm(feet[0] - feet[1]))
print(f"hinge 3 cm up the shin: foot at {feet[0].round(4)} before, {feet[1].round(4)} after, {1e3 * off:.1f} mm apart")
assert "verdict: PASS" in report and code == 0
# By hand: a turn by a about a point that lies d away moves everything below by 2 d sin(a / 2).
assert abs(off - 2 * 0.03 * np.sin(0.6)) < 1e-8
PY
