#!/usr/bin/env bash
# Version:  icub-models 3.2.0 and example-robot-data 6.0.0, pin 4.1.0
# Does:     in three of the fifteen iCub files (iCubLisboa01 and iCubGenova03 of icub-models, icub.urdf of
#           example-robot-data) five links of the right leg, from hip to ankle, have the masses of the left ones
#           and moments of inertia of zero or of rounding dust; so has the pelvis. A fourth file, iCubNancy01,
#           gives both of its ankles, of 0.64 kg, a moment of 4.77 kg·m². Pinocchio reads all of them without
#           a word.
# Guess:    calibrated files of real robots, from their maker, have two legs alike, and moments that a body of
#           this size can have.
# Means:    the left leg turns about its own length as if it were twice to fourteen times as hard to turn as
#           the right one, and all torques of yaw and of swing differ between the sides of one gait. On
#           iCubNancy01 the yaw of either hip turns 4.8 kg·m² instead of 0.006.
#           Compare the principal moments of left and right links, and with mass times size squared, first.
# Seen:     left / right inertia at the hip's yaw, straight leg: 0.00329 / 0.00024 (Lisboa), 0.00534 / 0.00229
#           (Genova03), 0.00546 / 0.00241 kg·m² (example-robot-data); 0.00566 / 0.00565 (Genova04);
#           4.79 / 4.79 (Nancy)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/icub" icub-models==3.2.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/data" \
  example-robot-data==6.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

FILES = {path.parent.name: path for path in Path("icub").rglob("iCub*/model.urdf")}
(FILES["example-robot-data"],) = Path("data").rglob("icub_description/robots/icub.urdf")
LINKS = ("hip_1", "hip_2", "upper_leg", "lower_leg", "ankle_1")


def largest_moments(path):
    """Mass [kg] and largest principal moment [kg m2] of every link, from the XML alone."""
    found = {}
    for link in ET.parse(path).getroot().iter("link"):
        if (inertial := link.find("inertial")) is None:
            continue
        entry = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
        tensor = np.array([[entry["i" + "".join(sorted(a + b))] for a in "xyz"] for b in "xyz"])
        mass = float(inertial.find("mass").get("value"))
        found[link.get("name")] = mass, float(np.linalg.eigvalsh(tensor)[-1])
    return found


def yaw_inertia(path):
    """Diagonal of the mass matrix at the yaw of the left and of the right hip, legs straight [kg m2]."""
    model = pin.buildModelFromUrdf(str(path))
    matrix = pin.crba(model, model.createData(), pin.neutral(model))
    at = [model.joints[model.getJointId(f"{side}_hip_yaw")].idx_v for side in "lr"]
    return tuple(float(matrix[k, k]) for k in at)


assert len(FILES) == 15
without = set()
for name, path in sorted(FILES.items()):
    moments, (left, right) = largest_moments(path), yaw_inertia(path)
    pairs = [(moments["l_" + link], moments["r_" + link]) for link in LINKS]
    assert all(abs(a[0] - b[0]) < 0.02 * a[0] for a, b in pairs), "masses of the legs"
    if all(b[1] < 1e-9 < 1e-5 < a[1] for a, b in pairs) and moments["root_link"][1] == 0.0:
        without.add(name)
    worst = max((moment / mass) ** 0.5 for mass, moment in moments.values() if mass > 0.1)
    print(f"{name}: yaw of the hips {left:.5f} / {right:.5f} kg m2, largest radius of gyration {worst:.2f} m")
    if name in without:
        assert left > 2.0 * right
    else:
        assert abs(left - right) < 0.01 * left
    assert (worst > 2.0) == (name == "iCubNancy01")
print("right leg without inertia:", sorted(without))
assert without == {"iCubLisboa01", "iCubGenova03", "example-robot-data"}
assert yaw_inertia(FILES["iCubLisboa01"])[0] > 13.0 * yaw_inertia(FILES["iCubLisboa01"])[1]
assert all(abs(value - 4.794) < 1e-3 for value in yaw_inertia(FILES["iCubNancy01"]))
PY
