#!/usr/bin/env bash
# Version:  placo 0.10.2 (pin 3.8.0)
# Does:     torques_from_acceleration_with_fixed_frame finds the joint torques as if the base did not
#           accelerate, whichever frame is held. A trunk of 30 kg on an ankle, the foot held, 1 rad/s²
#           at the ankle: 0.01 N·m, where the pendulum needs m l² + I = 20.2 N·m. With the trunk held
#           the answer is right, and the torques of gravity are right with any frame.
# Guess:    the frame that is held does not move, so the base follows from it and the joints.
# Means:    the torques of a stance leg computed so miss all inertia of what it carries; motors sized
#           by them are too small. Solve for the base's acceleration, or use placo's DynamicsSolver.
# Seen:     foot held 0.010 N·m of 20.200; trunk held 0.010 of 0.010
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check placo==0.10.2
cd "$work"
cat > robot.urdf <<'XML'
<robot name="pendulum">
  <link name="trunk"><inertial><mass value="30"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="ankle" type="revolute"><parent link="trunk"/><child link="foot"/>
    <origin xyz="0 0 -0.8"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="100" velocity="10"/></joint>
  <link name="foot"><inertial><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
</robot>
XML
"$work/env/bin/python" - <<'PY'
import numpy as np
import placo

robot = placo.RobotWrapper("robot.urdf", placo.Flags.ignore_collisions)
robot.update_kinematics()
joints = np.array([1.0])  # rad/s² at the ankle, all at rest and upright: gravity has no moment
told = {
    name: float(robot.torques_from_acceleration_with_fixed_frame(joints, name)[0])
    for name in ("foot", "trunk")
}
mass, height, inertia, foot = 30.0, 0.8, 1.0, 0.01
right = {"foot": mass * height**2 + inertia, "trunk": foot}
# The same from placo's own mass matrix, with the base that keeps the held frame at rest.
matrix, torque = robot.mass_matrix(), {}
for name in told:
    jacobian = robot.frame_jacobian(name, "local")
    base = -np.linalg.solve(jacobian[:, :6], jacobian[:, 6:] @ joints)
    force = matrix @ np.concatenate([base, joints]) + robot.non_linear_effects()
    wrench = np.linalg.solve(jacobian[:, :6].T, force[:6])
    torque[name] = float((force - jacobian.T @ wrench)[6])
    print(f"{name} held: placo {told[name]:.3f} N·m, mass matrix {torque[name]:.3f}, by hand {right[name]:.3f}")
    assert abs(torque[name] - right[name]) < 1e-9
assert abs(told["trunk"] - foot) < 1e-9
assert abs(told["foot"] - foot) < 1e-9
PY
