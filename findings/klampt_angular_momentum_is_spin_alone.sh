#!/usr/bin/env bash
# Version:  Klampt 0.10.1.post1
# Does:     RobotModel.getAngularMomentum adds up the spin of the links, each about its own centre of mass,
#           and leaves out what they carry by moving: neither about the robot's centre of mass nor about
#           the origin is it the robot's angular momentum. Kinetic energy and the total inertia, which
#           has the distances in it, are right.
# Guess:    the angular momentum of a robot is the one that is conserved in flight, about its centre of mass.
# Means:    a swing leg seems to carry a small part of what the trunk must take up; a motion balanced by
#           it turns the robot. Sum mass x place x velocity over the links and add it.
# Seen:     leg of 2 kg, 0.4 m below a hip of 10 kg, at 1 rad/s: 0.010 kg·m²/s, which is the spin of the leg;
#           by hand 0.277 about the centre of mass, 0.330 about the hip
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check klampt==0.10.1.post1
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import klampt
import numpy as np

TRUNK, LEG, DROP, SPIN = 10.0, 2.0, 0.4, 0.01
Path("leg.urdf").write_text("""<robot name="walker"><link name="trunk"><inertial><mass value="10"/>
<inertia ixx="0.3" ixy="0" ixz="0" iyy="0.3" iyz="0" izz="0.3"/></inertial></link>
<link name="leg"><inertial><origin xyz="0 0 -0.4"/><mass value="2"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="hip" type="revolute"><parent link="trunk"/><child link="leg"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="9" velocity="9"/></joint></robot>""")
world = klampt.WorldModel()
assert world.readFile("leg.urdf")
robot = world.robot(0)
rate = np.zeros(robot.numLinks())
rate[robot.link("leg").getIndex()] = 1.0
robot.setConfig([0.0] * robot.numLinks())
robot.setVelocity(rate.tolist())

momentum = np.array(robot.getAngularMomentum())
about_com = TRUNK * LEG / (TRUNK + LEG) * DROP**2 + SPIN
about_hip = LEG * DROP**2 + SPIN
print("angular momentum", momentum.round(4), f"by hand {about_com:.4f} and {about_hip:.4f} kg·m²/s")
print("kinetic energy", round(robot.getKineticEnergy(), 4), "J")
assert np.isclose(robot.getKineticEnergy(), about_hip / 2)
assert np.isclose(robot.getTotalInertia()[1][1], 0.3 + about_com)
assert np.allclose(momentum, [0, SPIN, 0])
assert np.isclose(about_com, 0.27667, atol=1e-5) and np.isclose(about_hip, 0.33)
PY
