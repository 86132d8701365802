#!/usr/bin/env bash
# Version:  icub-models 3.2.0, pin 4.1.0
# Does:     iCubGazeboV2_5 and iCubGenova04 are one robot, for simulation and for the real one: the same 39 links,
#           masses and centres of mass to the last digit. In the Gazebo file 18 of the links have each diagonal
#           element of their tensor set to 0.01 kg·m², with the products of inertia left as they were: one
#           link of the hip (0.13 kg), one of the ankle (0.27 kg), wrists of 36 g, shoulders, elbows, neck. The
#           files do not say so.
# Guess:    files of one robot that agree in every mass have the same dynamics.
# Means:    a walk, a gain or a motor found on the simulated iCub is for a robot whose ankle is 3.3 (pitch) and
#           5.5 (roll) and whose hip's yaw is 2.7 times as hard to turn; no body of 0.27 kg of an ankle's size can
#           have 0.01 kg·m², which is that of a ring of 19 cm radius. Take the robot's file for design, and
#           look for tensors with three equal moments.
# Seen:     18 of 39 links with 0.01 on the diagonal, 62 (hand) to 5331 times (wrist) their smallest element in the
#           robot's file; inertia at hip yaw, ankle pitch, ankle roll 0.0154, 0.0139, 0.0120 (Gazebo) for
#           0.0057, 0.0042, 0.0022 kg·m²
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/icub" icub-models==3.2.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin


def links(path):
    """Mass, centre of mass and the six elements of the tensor of every link with an inertial."""
    found = {}
    for link in ET.parse(path).getroot().iter("link"):
        if (inertial := link.find("inertial")) is None:
            continue
        entry = inertial.find("inertia").attrib
        found[link.get("name")] = (
            float(inertial.find("mass").get("value")),
            inertial.find("origin").attrib,
            np.array([float(entry[key]) for key in ("ixx", "iyy", "izz")]),
            np.array([float(entry[key]) for key in ("ixy", "ixz", "iyz")]),
        )
    return found


def at_joints(path):
    model = pin.buildModelFromUrdf(str(path))
    matrix = pin.crba(model, model.createData(), pin.neutral(model))
    names = ("l_hip_yaw", "l_ankle_pitch", "l_ankle_roll")
    return np.array([matrix[k, k] for k in (model.joints[model.getJointId(name)].idx_v for name in names)])


(robot,) = Path("icub").rglob("iCubGenova04/model.urdf")
(gazebo,) = Path("icub").rglob("iCubGazeboV2_5/model.urdf")
real, simulated = links(robot), links(gazebo)
assert set(real) == set(simulated)
raised = {}
for name, (mass, origin, diagonal, products) in real.items():
    other = simulated[name]
    assert other[0] == mass and other[1] == origin and np.array_equal(other[3], products), name
    if not np.array_equal(other[2], diagonal):
        assert np.all(other[2] == 0.01) and np.all(diagonal < 0.01)
        raised[name] = 0.01 / float(diagonal.min())
assert len(raised) == 18 and len(real) == 39
print(f"{len(raised)} of {len(real)} links raised to 0.01 on the diagonal:")
print({name: round(times) for name, times in sorted(raised.items())})
before, after = at_joints(robot), at_joints(gazebo)
print("hip yaw, ankle pitch, ankle roll [kg m2]:", before.round(4), "(robot),", after.round(4), "(Gazebo)")

# What the two mass matrices differ by is what was added to the links: at the ankle's roll that is izz of one
# tensor, whose frame (rpy of a quarter turn about x, then z) lays its z axis along the joint.
added = 0.01 - real["l_ankle_2"][2][2]
assert abs((after - before)[2] - added) < 1e-9
assert np.allclose(after / before, [2.72, 3.31, 5.52], atol=0.01)
assert {"l_hip_3", "r_hip_3", "l_ankle_2", "r_ankle_2", "l_wrist_1"} <= set(raised)
radius = (0.01 / real["l_ankle_2"][0]) ** 0.5
print(f"radius of gyration of an ankle link: {radius:.3f} m")
assert radius > 0.19
PY
