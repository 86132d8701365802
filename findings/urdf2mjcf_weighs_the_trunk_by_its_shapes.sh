#!/usr/bin/env bash
# Version:  urdf2mjcf 0.2.39, mujoco 4.0.0
# Does:     the <inertial> of the root link is not written, so MuJoCo weighs the trunk by its shapes
#           as if they were water, the visual and the collision shape each: 30 kg become 16 kg, with
#           a centre of mass of its own. All other links keep their masses. Damping and friction of
#           joints are left out too. It warns of off-diagonal inertias, not of this.
# Guess:    a converter keeps the heaviest body of the robot.
# Means:    a walk, or a policy, for the MJCF is one for another robot; compare the total mass of a
#           converted file with that of the URDF.
# Seen:     trunk 16.0 kg for 30 kg, leg 5.0 for 5; damping 0.0 for 0.7, friction 0.0 for 0.3
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check urdf2mjcf==0.2.39 mujoco==4.0.0
cd "$work"
cat > robot.urdf <<'XML'
<robot name="robot">
  <link name="trunk">
    <inertial><origin xyz="0 0 0.3"/><mass value="30"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="0.9" iyz="0" izz="0.5"/></inertial>
    <visual><geometry><box size="0.2 0.2 0.2"/></geometry></visual>
    <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>
  </link>
  <joint name="hip" type="revolute">
    <parent link="trunk"/><child link="leg"/><origin xyz="0 0.1 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="100" velocity="10"/>
    <dynamics damping="0.7" friction="0.3"/>
  </joint>
  <link name="leg">
    <inertial><origin xyz="0 0 -0.3"/><mass value="5"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><box size="0.1 0.1 0.6"/></geometry></visual>
    <collision><geometry><box size="0.1 0.1 0.6"/></geometry></collision>
  </link>
</robot>
XML
"$work/env/bin/urdf2mjcf" robot.urdf --output robot.mjcf 2>&1 | tail -5
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path("robot.mjcf")
trunk, leg = (float(model.body(name).mass[0]) for name in ("trunk", "leg"))
hip = int(model.joint("hip").dofadr[0])
damping, friction = float(model.dof_damping[hip]), float(model.dof_frictionloss[hip])
print(f"trunk {trunk} kg for 30 kg, leg {leg} for 5; damping {damping} for 0.7, friction {friction} for 0.3")
print("centre of mass of the trunk:", model.body("trunk").ipos, "for (0, 0, 0.3)")
water = 2 * 1000.0 * 0.2**3
assert np.isclose(trunk, water) and np.isclose(leg, 5.0)
assert np.allclose(model.body("trunk").ipos, 0.0)
assert damping == 0.0 and friction == 0.0
PY
