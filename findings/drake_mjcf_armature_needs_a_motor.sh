#!/usr/bin/env bash
# Version:  drake 1.51.1 against mujoco 4.0.0
# Does:     the armature of an MJCF joint enters Drake's mass matrix only if the joint has a <motor> or
#           <position> actuator. Without one, or with <general>, it is gone; damping of the same joint
#           stays. MuJoCo, whose format it is, always has it.
# Guess:    armature is a property of the joint, as the format says; what cannot be read is warned of,
#           as stiffness and frictionloss are.
# Means:    a humanoid saved by MuJoCo (which writes every actuator as <general>) loses the rotors of
#           all its joints in Drake: for an ankle that is most of the inertia.
# Seen:     0.594 kg·m² with <motor> (both); 0.094 (Drake) against 0.594 (MuJoCo) with <general> or none
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - 2>/dev/null <<'PY'
from pathlib import Path

import mujoco
import numpy as np
from pydrake.all import MultibodyPlant, Parser

ROBOT = """<mujoco model="leg"><worldbody><body name="leg">
<joint name="hip" type="hinge" axis="0 1 0" armature="0.5" damping="0.2"/>
<geom type="sphere" size=".1" mass="1" pos="0 0 -.3"/></body></worldbody>
<actuator>{}</actuator></mujoco>"""


def mass_matrices(actuator):
    text = ROBOT.format(actuator)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    own = np.zeros((1, 1))
    mujoco.mj_fullM(model, data, own)
    Path("leg.xml").write_text(text)
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels("leg.xml")
    plant.Finalize()
    return own[0, 0], plant.CalcMassMatrix(plant.CreateDefaultContext())[0, 0]


found = {}
for actuator in ('<motor joint="hip"/>', '<position joint="hip" kp="10"/>',
                 '<general joint="hip" gainprm="1"/>', ""):
    found[actuator] = mass_matrices(actuator)
    print(f"{actuator or 'no actuator'}: MuJoCo {found[actuator][0]:.3f}, Drake {found[actuator][1]:.3f}")
assert all(np.isclose(own, 0.594) for own, _ in found.values())
assert np.allclose([drake for _, drake in found.values()], [0.594, 0.594, 0.094, 0.094])
PY
