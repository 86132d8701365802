#!/usr/bin/env bash
# Version:  drake 1.51.1
# Does:     MultibodyPlant.CalcNonConservativePower counts the damper of a LinearSpringDamper, and leaves out the damping
#           of joints and what motors do: 0 W where a joint takes 2.8 W. The motion and the energies count all
#           of them. (Known: issue 12942 of Drake, open.)
# Guess:    the power by which the sum of kinetic and potential energy changes, as its interface says for every System.
# Means:    a check of an integration, or of a gait's energy, by this number blames the integrator for what the joints
#           take; a passive walker loses nothing. Add - damping * rate^2 and torque * rate of every joint.
# Seen:     pendulum at 2 rad/s with joint damping 0.7 N·m·s/rad: told 0 W, energy falls at 2.8 W; with a motor of 3 N·m:
#           told 0 W, energy rises at 3.2 W; with a damper element alone: told -0.819 W, energy falls at 0.819 W
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1
"$work/env/bin/python" - 2>/dev/null <<'PY'
import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import LinearSpringDamper

PENDULUM = """<robot name="pendulum"><link name="shank"><inertial><mass value="2"/><origin xyz="0 0 -.2"/>
<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><parent link="world"/><child link="shank"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="9"/><dynamics damping="{damping}"/></joint>
<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="knee">
<hardwareInterface>EffortJointInterface</hardwareInterface></joint><actuator name="m"/></transmission></robot>"""


def powers(damping=0.0, torque=0.0, damper=0.0):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(PENDULUM.format(damping=damping), "urdf")
    shank = plant.GetBodyByName("shank")
    if damper:
        plant.AddForceElement(LinearSpringDamper(plant.world_body(), [0.3, 0, 0], shank, [0, 0, -0.4], 0.2, 100.0, damper))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.get_actuation_input_port().FixValue(context, [torque])
    q, v = np.array([0.3]), np.array([2.0])

    def energy(q, v):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        return plant.CalcKineticEnergy(context) + plant.CalcPotentialEnergy(context)

    energy(q, v)
    told = plant.CalcNonConservativePower(context)
    acceleration = plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()
    step = 1e-6
    change = energy(q + step * v, v + step * acceleration) - energy(q - step * v, v - step * acceleration)
    return told, change / (2 * step)


joint, motor, element = powers(damping=0.7), powers(damping=0.7, torque=3.0), powers(damper=5.0)
for name, (told, true) in {"joint damping": joint, "with a motor": motor, "damper element": element}.items():
    print(f"{name}: told {told:.4f} W, the energy changes at {true:.4f} W")
assert np.isclose(joint[1], -0.7 * 2.0**2, atol=1e-5) and np.isclose(motor[1], 3.0 * 2.0 - 2.8, atol=1e-5)
assert joint[0] == 0.0 and motor[0] == 0.0
assert np.isclose(*element, atol=1e-5) and element[0] < -0.5
PY
