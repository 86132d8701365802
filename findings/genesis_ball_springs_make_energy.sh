#!/usr/bin/env bash
# Version:  genesis-world 1.4.5 (torch 2.14.1, on the CPU in double precision), mujoco 4.0.0 to compare
# Does:     the spring of a ball joint (stiffness in MJCF) pulls with the three Euler angles of the joint, each times the stiffness,
#           as if they were a torque. Their sum is no torque of any energy: a thigh that hangs on such a spring
#           alone, without gravity, friction and damping, wins and loses energy from swing to swing.
#           Turned about one of the axes of its body it starts rightly. No warning.
#           (get_potential_energy takes half the stiffness times the squares of those angles, and its documentation
#           says that the sum with the kinetic energy is conserved by a passive model.)
# Guess:    the stiffness times the rotation vector, towards the place of rest, as in MuJoCo, whose files it reads.
# Means:    springy hips, toes, tails and exoskeletons feed a walk from nothing, or brake it, whatever the step. Replace a ball
#           with a spring by three hinges, or apply the torque yourself.
# Seen:     10 N·m/rad, 1.2 rad about (1, 2, 2): torque (-0.4, -8.7, -8.4) for (-4, -8, -8) N·m; of 7.3 J become between 6.9
#           and 23.1 J within 1.2 s, in MuJoCo 7.19 to 7.25; started about z 6.3 to 7.7 J
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

SPRING, ANGLE, STEP = 10.0, 1.2, 2e-4  # N·m/rad, rad, s
HIP = f"""<mujoco><option timestep="{STEP}" gravity="0 0 0"><flag energy="enable"/></option><worldbody>
<body name="thigh" pos="0 0 1"><joint name="hip" type="ball" stiffness="{SPRING}"/>
<geom type="box" size=".05 .1 .2" pos=".1 .05 -.2" mass="2"/></body></worldbody></mujoco>"""
Path("hip.xml").write_text(HIP)
gs.init(backend=gs.cpu, precision="64", logging_level="error")
scene = gs.Scene(show_viewer=False, sim_options=gs.options.SimOptions(dt=STEP, gravity=(0.0, 0.0, 0.0)))
leg = scene.add_entity(gs.morphs.MJCF(file="hip.xml"))
scene.build()
model = mujoco.MjModel.from_xml_string(HIP)
seen = {}
for name, axis in (("z", np.array([0.0, 0.0, 1.0])), ("(1, 2, 2)", np.array([1.0, 2.0, 2.0]) / 3.0)):
    start = np.r_[np.cos(ANGLE / 2), np.sin(ANGLE / 2) * axis]
    leg.set_qpos(start)
    data = mujoco.MjData(model)
    data.qpos[:] = start
    mujoco.mj_forward(model, data)
    assert np.allclose(data.qfrc_passive, -SPRING * ANGLE * axis)
    energy = []
    for step in range(6000):
        scene.step()
        mujoco.mj_step(model, data)
        if step == 0:
            torque = leg.get_mass_mat().numpy() @ leg.get_dofs_acc().numpy()
        energy.append((leg.get_total_energy().item(), data.energy.sum()))
    low, high = np.min(energy, axis=0), np.max(energy, axis=0)
    print(f"turned about {name}: torque {torque.round(2)} N·m for {(-SPRING * ANGLE * axis).round(2)}; energy from {low[0]:.2f} to"
          f" {high[0]:.2f} J, in MuJoCo from {low[1]:.2f} to {high[1]:.2f} J")
    seen[name] = np.abs(torque + SPRING * ANGLE * axis).max(), high[0] - low[0], high[1] - low[1]
assert seen["z"][0] < 1e-9 and max(torque_off for torque_off, _, _ in seen.values()) > 3.0
assert max(mine for _, _, mine in seen.values()) < 0.1
assert 1.2 < seen["z"][1] < 1.6 and 14.0 < seen["(1, 2, 2)"][1] < 18.0
PY
