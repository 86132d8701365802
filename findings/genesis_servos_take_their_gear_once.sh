#!/usr/bin/env bash
# Version:  genesis-world 1.4.5 (torch 2.14.1, on the CPU in double precision), mujoco 4.0.0 to compare
# Does:     of an MJCF actuator with a gear, Genesis multiplies kp and kv of a position servo by the gear once, MuJoCo twice (the servo
#           sees the joint through the gear and pulls through it), and leaves forcerange as it is, where MuJoCo
#           multiplies it. The springref of a joint is left out: its spring pulls to the zero of the joint. No warning; that a
#           file has tendons or dynamics of actuators is warned about. ctrlrange of a motor is taken through the gear.
# Guess:    one file, one servo; the reader says that it follows MuJoCo's general actuator.
# Means:    a knee behind a gear of 10 is ten times too soft and too lightly damped, its motor gives a tenth of its torque, and a
#           leg held up by a spring hangs. Gains and limits belong to the joint in Genesis: set them with set_dofs_kp, set_dofs_kv
#           and set_dofs_force_range, and springs by moving ref.
# Seen:     gear 10, kp 2, kv 0.1: 20 N·m/rad and 1 N·m·s/rad for 200 and 10; forcerange 0.5: 0.5 for 5 N·m; spring of
#           10 N·m/rad that rests at 30 degrees: 0 for 5.24 N·m
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check genesis-world==1.4.5 torch==2.14.1 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" -W ignore - 2>/dev/null <<'PY'
from pathlib import Path

import genesis as gs
import mujoco
import numpy as np

SHIN = '<geom type="capsule" size=".05" fromto="0 0 0 0 0 -.4" mass="2"/>'
TEXT = f"""<mujoco><option timestep=".001"/><worldbody>
<body pos="0 0 1"><joint name="servo" axis="0 1 0" armature=".05"/>{SHIN}</body>
<body pos="0 1 1"><joint name="motor" axis="0 1 0" armature=".05"/>{SHIN}</body>
<body pos="0 2 1"><joint name="spring" axis="0 1 0" armature=".05" stiffness="10" springref="30"/>{SHIN}</body></worldbody>
<actuator><position joint="servo" gear="10" kp="2" kv=".1"/><motor joint="motor" gear="10" forcerange="-.5 .5"/></actuator></mujoco>"""
Path("legs.xml").write_text(TEXT)
gs.init(backend=gs.cpu, precision="64", logging_level="error")
scene = gs.Scene(show_viewer=False, sim_options=gs.options.SimOptions(dt=1e-3, gravity=(0.0, 0.0, -9.81)))
robot = scene.add_entity(gs.morphs.MJCF(file="legs.xml"))
scene.build()
model = mujoco.MjModel.from_xml_string(TEXT)
data = mujoco.MjData(model)


def acting():
    mujoco.mj_forward(model, data)
    return data.qfrc_actuator + data.qfrc_passive


rest = acting().copy()
data.qpos[0] = 0.01
stiffness = -(acting() - rest)[0] / 0.01
data.qpos[:], data.qvel[0] = 0.0, 0.01
lag = -(acting() - rest)[0] / 0.01
data.qvel[:], data.ctrl[1] = 0.0, 10.0
most = acting()[1]
bias = [each.numpy()[0].item() for each in robot.get_dofs_act_bias()]
limit = robot.get_dofs_force_range()[1].numpy()[1].item()
robot.set_dofs_position(np.zeros(3))
scene.step()
torque = robot.get_dofs_force().numpy()
print(f"servo: {-bias[1]:.1f} N·m/rad and {-bias[2]:.2f} N·m·s/rad for {stiffness:.1f} and {lag:.2f}; motor: {limit} N·m for {most}")
print(f"spring at 0 that rests at 30 degrees: {torque[2]:.3f} for {rest[2]:.3f} N·m")
assert np.allclose([stiffness, lag, most], [200.0, 10.0, 5.0]) and np.isclose(rest[2], 10 * np.radians(30))
assert np.allclose([-bias[1], -bias[2], limit], [20.0, 1.0, 0.5]) and abs(torque[2]) < 1e-9
PY
