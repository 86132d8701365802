#!/usr/bin/env bash
# Version:  pybullet 3.2.7
# Does:     loadURDF of a file that was written anew under the same name gives the robot that was read
#           first, also after resetSimulation.
# Guess:    a file is read when it is loaded, at the latest after the simulation was emptied.
# Means:    a loop that writes one design after another to the same name and simulates each compares
#           the first design with itself. Give each file its own name, or switch the memory off with
#           setPhysicsEngineParameter(enableFileCaching=0).
# Seen:     masses written 1, 2, 3; masses read 1, 1 (after a reset), 3 (memory off)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import pybullet

URDF = """<robot name="r"><link name="foot"><inertial><origin xyz="0 0 0"/><mass value="{}"/>
<inertia ixx=".2" ixy="0" ixz="0" iyy=".3" iyz="0" izz=".25"/></inertial></link></robot>"""
path = Path.cwd() / "foot.urdf"


def mass_read(written):
    path.write_text(URDF.format(written))
    return pybullet.getDynamicsInfo(pybullet.loadURDF(str(path)), -1)[0]


pybullet.connect(pybullet.DIRECT)
read = [mass_read(1)]
pybullet.resetSimulation()
read.append(mass_read(2))
pybullet.setPhysicsEngineParameter(enableFileCaching=0)
read.append(mass_read(3))
print("masses written [1, 2, 3], read", read)
assert read == [1.0, 1.0, 3.0]
PY
