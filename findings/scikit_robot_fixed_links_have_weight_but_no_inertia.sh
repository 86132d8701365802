#!/usr/bin/env bash
# Version:  scikit-robot 0.4.7
# Does:     torque_vector(calc_statics_p=False) counts the weight of a link behind a fixed joint, but
#           not what it takes to accelerate its mass: 2 kg on a bracket of 0.5 m need 0.5 N·m at
#           1 rad/s², and the answer is 0.000. The same 2 kg as a part of the moving link give 0.500.
#           Gravity is right in both.
# Guess:    a fixed joint changes nothing but names.
# Means:    feet, hands, batteries and sensors hang on fixed joints in most URDFs; torques of a motion
#           computed so are too small where the motors are largest. Merge fixed joints first.
# Seen:     acceleration 0.000 and 0.500 N·m, gravity 9.810 and 9.810 N·m, for bracket and one piece
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check scikit-robot==0.4.7
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
from skrobot.models.urdf import RobotModelFromURDF

TINY = 1e-9  # kg, kg·m²: a link cannot be without mass
INERTIAL = (
    '<inertial><origin xyz="{x} 0 0"/><mass value="{m}"/><inertia ixx="{i}" ixy="0" ixz="0" '
    'iyy="{i}" iyz="0" izz="{i}"/></inertial>'
)


def inertial(x, mass):
    return INERTIAL.format(x=x, m=mass, i=TINY)


def robot(arm, hand):
    """A level arm that turns about y, with a bracket fixed at 0.5 m."""
    text = f"""<robot name="robot">
      <link name="base">{inertial(0, 1.0)}</link>
      <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/>
        <origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="100" velocity="10"/></joint>
      <link name="arm">{arm}</link>
      <joint name="bracket" type="fixed"><parent link="arm"/><child link="hand"/>
        <origin xyz="0.5 0 0"/></joint>
      <link name="hand">{hand}</link>
      <joint name="finger" type="revolute"><parent link="hand"/><child link="finger"/>
        <origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="100" velocity="10"/></joint>
      <link name="finger">{inertial(0, TINY)}</link>
    </robot>"""
    with open("arm.urdf", "w") as file:
        file.write(text)
    return RobotModelFromURDF(urdf_file="arm.urdf")


def torque(one, acceleration):
    step = 0.01  # s; the differences are exact for constant acceleration
    near = np.array([0.5 * acceleration * step**2, 0.0])
    return float(
        one.torque_vector(
            calc_statics_p=False, dt=step, av=np.zeros(2), av_prev=near, av_next=near,
            gravity=np.array([0.0, 0.0, -9.81]),
        )[0]
    )


seen = {}
for name, parts in (
    ("bracket", (inertial(0, TINY), inertial(0, 2.0))),
    ("one piece", (inertial(0.5, 2.0), inertial(0, TINY))),
):
    one = robot(*parts)
    still = torque(one, 0.0)
    seen[name] = torque(one, 1.0) - still, abs(still)
    print(f"{name}: acceleration {seen[name][0]:.3f} N·m of 0.500, gravity {seen[name][1]:.3f} of 9.810")
assert np.allclose(seen["one piece"], (0.5, 9.81), atol=1e-6)
assert np.allclose(seen["bracket"], (0.0, 9.81), atol=1e-6)
PY
