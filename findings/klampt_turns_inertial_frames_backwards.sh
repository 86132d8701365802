#!/usr/bin/env bash
# Version:  Klampt 0.10.1.post1
# Does:     where the <inertial> of a URDF link is turned (rpy), Klampt turns the moments of inertia the
#           other way round: R' I R instead of R I R'. Mass and centre of mass are right, and so is every
#           link whose tensor is written in its own axes.
# Guess:    the frame that a tensor is written in is no matter of opinion; a reader that takes rpy turns by it.
# Means:    exporters that write principal moments with their rotation give Klampt another shin for each
#           link; with one turn about a joint's axis nothing shows, with three the knee's own inertia is
#           wrong. Write the tensor in the axes of the link before such a file is read.
# Seen:     moments 0.30, 0.20, 0.12 turned by rpy (0.3, 0.5, 0.4): inertia about the knee 0.2005 kg·m²
#           and product xz 0.0756 for (by hand) 0.2110 and -0.0748; without rpy 0.2000 and 0
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

MOMENTS = np.diag([0.30, 0.20, 0.12])
FILE = """<robot name="leg"><link name="thigh"/><link name="shin"><inertial>
<origin xyz="0 0 0" rpy="{}"/><mass value="4"/>
<inertia ixx="0.30" ixy="0" ixz="0" iyy="0.20" iyz="0" izz="0.12"/></inertial></link>
<joint name="knee" type="revolute"><parent link="thigh"/><child link="shin"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint></robot>"""


def by_hand(roll, pitch, yaw):
    def about(axis, angle):
        turn, (a, b) = np.eye(3), [k for k in range(3) if k != axis]
        sign = -1 if axis == 1 else 1
        turn[a, a] = turn[b, b] = np.cos(angle)
        turn[b, a], turn[a, b] = sign * np.sin(angle), -sign * np.sin(angle)
        return turn

    frame = about(2, yaw) @ about(1, pitch) @ about(0, roll)
    return frame @ MOMENTS @ frame.T, frame.T @ MOMENTS @ frame


for rpy in ((0.0, 0.0, 0.0), (0.3, 0.5, 0.4)):
    name = f"leg{rpy[0]}.urdf"
    Path(name).write_text(FILE.format(" ".join(map(str, rpy))))
    world = klampt.WorldModel()
    assert world.readFile(name)
    robot = world.robot(0)
    shin = robot.link("shin")
    read = np.reshape(shin.getMass().inertia, (3, 3))
    knee = robot.getMassMatrix()[shin.getIndex()][shin.getIndex()]
    right, backwards = by_hand(*rpy)
    print(f"rpy {rpy}: about the knee {knee:.4f} (by hand {right[1, 1]:.4f}), "
          f"product xz {read[0, 2]:.4f} (by hand {right[0, 2]:.4f})")
    assert np.isclose(shin.getMass().mass, 4) and np.isclose(knee, read[1, 1])
    assert np.allclose(read, backwards)
    assert np.allclose(read, right) == (rpy == (0.0, 0.0, 0.0))
PY
