#!/usr/bin/env bash
# Version:  drake 1.51.1 against mujoco 4.0.0
# Does:     an MJCF <motor> with gear 100 and control range -1..1 pushes its joint with up to 100 N·m in
#           MuJoCo. Drake reads an effort limit of 1 for it, while the actuator acts on the joint one to
#           one, so that the joint gets 1 N·m; the gear is kept only for the rotor's inertia.
# Guess:    the limit is that of the joint, 100 N·m, or the gear stands between the limit and the joint.
# Means:    humanoids of the Gym and dm_control kind (controls -1..1, gears 20 to 300) collapse in Drake, or
#           an optimiser that takes effort_limit for the joint's finds no gait. Multiply the limit by the
#           gear after reading, and check one knee by hand.
# Seen:     MuJoCo 100 N·m at the joint; Drake effort limit 1.0, torque felt 1.0 for a command of 60
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np
from pydrake.all import JointActuatorIndex, MultibodyPlant, Parser, Simulator

ROBOT = """<mujoco model="leg"><worldbody><body name="leg">
<joint name="hip" type="hinge" axis="0 1 0" range="-90 90"/>
<geom type="sphere" size=".1" mass="1" pos="0 0 -.3"/></body></worldbody>
<actuator><motor joint="hip" gear="100" ctrllimited="true" ctrlrange="-1 1"/></actuator></mujoco>"""
model = mujoco.MjModel.from_xml_string(ROBOT)
data = mujoco.MjData(model)
data.ctrl[0] = 5.0  # beyond the range: MuJoCo clips it to 1
mujoco.mj_forward(model, data)
plant = MultibodyPlant(0.001)
Parser(plant).AddModelsFromString(ROBOT, "xml")
plant.Finalize()
actuator = plant.get_joint_actuator(JointActuatorIndex(0))
simulator = Simulator(plant)
context = simulator.get_mutable_context()
plant.get_actuation_input_port().FixValue(context, [60.0])
simulator.AdvanceTo(plant.time_step())  # from rest, hanging: the rate is the torque's impulse / inertia
inertia = plant.CalcMassMatrix(context)[0, 0]
net = plant.GetVelocities(context)[0] * inertia / plant.time_step()
factor = plant.MakeActuationMatrix()[0, 0]
print("MuJoCo: largest torque at the joint", data.qfrc_actuator[0])
print("Drake: effort limit", actuator.effort_limit(), "gear", actuator.default_gear_ratio(),
      "joint torque per actuation", factor, "torque felt for 60:", net)
assert np.isclose(data.qfrc_actuator[0], 100.0)
assert np.isclose(actuator.effort_limit(), 1.0) and np.isclose(factor, 1.0) and np.isclose(net, 1.0, atol=1e-3)
PY
