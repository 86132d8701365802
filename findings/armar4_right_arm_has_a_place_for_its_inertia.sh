#!/usr/bin/env bash
# Version:  armar 1.1.0 (armar4.urdf and its three variants with fixed hands, fingers or legs), pin 4.1.0
# Does:     the tensor of the third link of the right arm (0.51 kg) is 0, 0.0575321 and 0.0195, lengths of a centre of mass in
#           the place of moments: the left one has its centre at 0.0575318 m. The centre beside it is the left's, not
#           mirrored, so it lies on the far side of the shoulder from the elbow, 115 mm off its mirror image. Two
#           other links of that shoulder are 33 and 12 % heavier than on the left.
# Guess:    nobody takes a length for a moment of inertia, and readers refuse a body that has none about one axis.
# Means:    0.51 kg are spread over 336 mm, in a link of 100 mm, and the right arm needs other torques to hang and to swing.
#           Trunk and arms of a walk that is mirrored after half a stride are those of no robot. Compare
#           sqrt(moment / mass) with the link, and the two arms, before use.
# Seen:     moments 0, 0.0195, 0.0575 for 0.0005, 0.0011, 0.0011 kg·m² on the left; masses 0.58 and 0.52 kg left, 0.77 and
#           0.58 right; inertia at the first joint of the arms 0.446 and 0.509 kg·m², weight at the second 0.33 and
#           0.44 N·m; elbows, wrists and their links mirrored within 8 mm
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" armar==1.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

files = sorted(path for path in Path("robots/").rglob("armar4*.urdf"))
assert len(files) == 4
names = [f"arm{{}}_{part}" for part in ("sho1", "sho2", "sho3", "sho4", "elb1", "elb2", "wri1", "wri2")]


def inertial(root, link):
    """Mass, centre of mass and the six numbers of the tensor, by the letter of the file."""
    (found,) = (element.find("inertial") for element in root.iter("link") if element.get("name") == link)
    assert not np.any([float(x) for x in found.find("origin").get("rpy").split()])
    centre = np.array([float(x) for x in found.find("origin").get("xyz").split()])
    tensor = found.find("inertia")
    numbers = [float(tensor.get("i" + key)) for key in ("xx", "yy", "zz", "xy", "xz", "yz")]
    return float(found.find("mass").get("value")), centre, numbers


for file in files:
    root = ET.parse(file).getroot()
    pair = ("arml_sho3", "armr_sho3") if file.stem == "armar4" else ("arm_sho3_r0", "arm_sho3_r1")
    left, right = (inertial(root, name) for name in pair)
    print(file.name, "left", left, "right", right)
    assert left[0] == right[0] == 0.51 and np.array_equal(left[1], right[1])
    assert right[2] == [0, 0.0575321, 0.0195, 0, 0, 0] and left[2] == [0.00109943, 0.000491725, 0.00106067, 0, 0, 0]

(file,) = (path for path in files if path.stem == "armar4")
model = pin.buildModelFromUrdf(str(file))
data = model.createData()
q = pin.neutral(model)
pin.forwardKinematics(model, data, q)
weight = pin.computeGeneralizedGravity(model, data, q)
matrix = pin.crba(model, data, q)
seen = {}
for name in names:
    pair = [model.getJointId(name.format(side) + "_joint") for side in "lr"]
    columns = [model.joints[index].idx_v for index in pair]
    masses = [model.inertias[index].mass for index in pair]
    centres = [data.oMi[index].act(model.inertias[index].lever) for index in pair]
    apart = np.linalg.norm(centres[0] * [-1, 1, 1] - centres[1])  # x is to the side
    seen[name[6:]] = masses, 1e3 * apart, np.abs(weight[columns]), matrix[columns, columns]
    weights, inertias = seen[name[6:]][2:]
    print(f"{name[6:]}: masses {masses}, off by {1e3 * apart:.1f} mm, weight {weights.round(3)}, inertia {inertias.round(4)}")
moments = np.linalg.eigvalsh(model.inertias[model.getJointId("armr_sho3_joint")].inertia)
radius = np.sqrt(moments[2] / 0.51)
print("moments", moments.round(4), f"radius of gyration {1e3 * radius:.0f} mm")
assert np.allclose(moments, [0, 0.0195, 0.0575321], atol=1e-9) and moments[2] > 2 * moments[1] and 0.335 < radius < 0.337
for side, sign in (("l", 1), ("r", -1)):
    shoulder, elbow = (data.oMi[model.getJointId(f"arm{side}_sho{number}_joint")] for number in (3, 4))
    lever = shoulder.rotation @ model.inertias[model.getJointId(f"arm{side}_sho3_joint")].lever
    way = elbow.translation - shoulder.translation
    along = lever @ way / np.linalg.norm(way)
    print(f"arm{side}: next joint {1e3 * np.linalg.norm(way):.0f} mm away, centre of mass {1e3 * along:.0f} mm that way")
    assert sign * along > 0.05
assert seen["sho1"][0] == [0.58, 0.77] and seen["sho2"][0] == [0.52, 0.58]
assert 115 < seen["sho3"][1] < 116 and max(seen[name][1] for name in ("sho4", "elb1", "elb2", "wri1", "wri2")) < 8.5
assert np.allclose(seen["sho1"][3], [0.4458, 0.5085], atol=1e-3)
assert np.allclose(seen["sho2"][2], [0.3303, 0.4437], atol=1e-3)
PY
