#!/usr/bin/env bash
# Version:  pybullet 3.2.7 against mujoco 4.0.0
# Does:     loadMJCF takes the joint range "-20 20" for radians unless the file says angle="degree",
#           which is the format's default, and ignores mass and density of every geom: each weighs
#           1000 kg/m³. A range without limited="true" is no limit.
# Guess:    the reader of another engine's format knows its unit and reads its masses, or warns.
# Means:    an ankle of 20 degrees turns more than three times round, and a foot of 3 kg weighs 0.8 kg:
#           gaits found so walk another robot. Compare masses and limits with MuJoCo's before use, or
#           write a URDF from MuJoCo's numbers.
# Seen:     limits (-20, 20) and mass 0.8 in PyBullet; (-0.349, 0.349) and 3.0 in MuJoCo
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np
import pybullet

ROBOT = """<mujoco model="r">{}<worldbody><body name="shank" pos="0 0 1">
<geom type="sphere" size=".1"/><body name="foot" pos="0 0 -.4">
<joint name="ankle" type="hinge" axis="0 1 0" range="-20 20" {}/>
<geom type="box" size=".1 .05 .02" {}/></body></body></worldbody></mujoco>"""
CASES = (  # head, attribute of the joint, attribute of the foot, limits that PyBullet reads
    ("", 'limited="true"', 'mass="3"', [-20.0, 20.0]),
    ('<compiler angle="degree"/>', 'limited="true"', 'density="500"', np.radians([-20, 20])),
    ("", "", "", [1.0, 0.0]),  # upper below lower: no limit
)
volume = 8 * 0.1 * 0.05 * 0.02
pybullet.connect(pybullet.DIRECT)
for number, (head, limited, weight, wanted) in enumerate(CASES):
    text = ROBOT.format(head, limited, weight)
    model = mujoco.MjModel.from_xml_string(text)
    path = Path.cwd() / f"robot{number}.xml"
    path.write_text(text)
    robot = pybullet.loadMJCF(str(path))[0]
    infos = {pybullet.getJointInfo(robot, k)[1]: k for k in range(pybullet.getNumJoints(robot))}
    limits = np.array(pybullet.getJointInfo(robot, infos[b"ankle"])[8:10])
    mass = sum(pybullet.getDynamicsInfo(robot, k)[0] for k in infos.values())
    own, weighs = model.jnt_range[0], model.body("foot").mass[0]
    print("\nfile:", head, limited, weight)
    print(f"PyBullet {limits.round(3)}, {mass:.3f} kg; MuJoCo {own.round(3)}, {weighs:.3f} kg")
    assert np.isclose(mass, 1000 * volume) and np.allclose(limits, wanted)
    assert np.allclose(own, np.radians([-20, 20]))
assert np.isclose(model.body("foot").mass[0], mass)  # without an attribute both weigh alike
PY
