#!/usr/bin/env bash
# Version:  example-robot-data 6.0.0 (romeo.urdf, romeo_small.urdf, romeo_laas_small.urdf), pin 4.1.0
# Does:     <inertial> of romeo.urdf and romeo_small.urdf puts the frame at the centre of mass, as URDF has it, and writes
#           beside it the tensor about the joint: what the mass adds by its distance counts twice. The thigh (4.34 kg)
#           has a radius of gyration of 176 mm, while with all its mass at hip and knee, 320 mm apart, it would be
#           160. With m d² taken off, shank and pelvis are within 3 % of those of the third file. That one
#           was taken to the centres of mass, with a slip: its pelvis (5.1 kg) has the moments -0.021, 0.052, 0.099, its
#           thighs -0.003, 0.040, 0.054 kg·m². All three load and simulate.
# Guess:    three files of one robot in one folder, mirrored, without a moment that breaks the triangle in the
#           legs (the first two), have inertias that one may use.
# Means:    the pelvis is nearly five times as hard to pitch as the robot's, a straight leg 10 % harder to swing, the shank
#           with the foot 16 %; the trunk's sway, motors and step times come out for another robot. The third file has
#           a pelvis that a turn about one axis leaves with less than no energy. Compare sqrt(moment / mass) with half
#           of the link's length: no test of signs, triangles or symmetry sees it in the first two.
# Seen:     radius of gyration of thigh and shank 175.7 and 145.1 mm, limits 160 and 145; middle moments of shank and
#           pelvis 0.0549 and 0.238, with m d² taken off 0.0157 and 0.0509, in the third file 0.0158 and 0.0521;
#           mass matrix, straight leg: hip pitch 1.469 for 1.330, knee 0.280 for 0.240 kg·m²
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" example-robot-data==6.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

(folder,) = Path("robots").rglob("romeo_description/urdf")


def tensors(name):
    """Of each link its mass, centre of mass and tensor, by the letter of the file; all rpy are 0."""
    found = {}
    for link in ET.parse(folder / name).getroot().iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        origin, tensor = inertial.find("origin"), inertial.find("inertia")
        assert not np.any(np.fromstring(origin.get("rpy"), sep=" "))
        xx, yy, zz, xy, xz, yz = (float(tensor.get("i" + key)) for key in ("xx", "yy", "zz", "xy", "xz", "yz"))
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        found[link.get("name")] = (
            float(inertial.find("mass").get("value")),
            np.fromstring(origin.get("xyz"), sep=" "),
            matrix,
        )
    return found


def shift(mass, centre):
    """What a mass at the centre has about the origin of the link [kg m^2]."""
    return mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))


small, full, third = (tensors(f"{name}.urdf") for name in ("romeo_small", "romeo", "romeo_laas_small"))
for name in ("LHipPitchLink", "LKneePitchLink", "body"):
    assert all(np.array_equal(np.asarray(a), np.asarray(b)) for a, b in zip(small[name], full[name]))
    mass, centre, tensor = small[name]
    moments = np.linalg.eigvalsh(tensor)
    off = np.linalg.eigvalsh(tensor - shift(mass, centre))
    other = np.linalg.eigvalsh(third[name.replace("Link", "_link")][2])
    print(name, f"{mass:.2f} kg: moments", moments.round(4), "less m d^2", off.round(4), "third file", other.round(4))
    assert moments[0] > 0 and moments[2] < moments[0] + moments[1]
    assert off[0] > 0 and off[2] < off[0] + off[1]
    if name != "LHipPitchLink":
        assert abs(off[1] / other[1] - 1) < 0.05 and moments[1] / other[1] > 3
assert np.allclose(np.linalg.eigvalsh(third["body"][2]), [-0.0213, 0.0521, 0.0990], atol=1e-4)
assert np.allclose(np.linalg.eigvalsh(third["LHipPitch_link"][2]), [-0.0027, 0.0395, 0.0540], atol=1e-4)

# No body whose mass lies between two points has more than with all of it at the points.
model = pin.buildModelFromUrdf(str(folder / "romeo_small.urdf"))
data = model.createData()
neutral = pin.neutral(model)
pin.forwardKinematics(model, data, neutral)
places = [data.oMi[model.getJointId(name)].translation for name in ("LHipPitch", "LKneePitch", "LAnklePitch")]
for name, top, bottom in (("LHipPitchLink", 0, 1), ("LKneePitchLink", 1, 2)):
    mass, _, tensor = small[name]
    radius = np.sqrt(np.linalg.eigvalsh(tensor)[2] / mass)
    limit = np.linalg.norm(places[top] - places[bottom]) / 2
    print(name, f"radius of gyration {1e3 * radius:.1f} mm, half of its length {1e3 * limit:.1f} mm")
    assert radius > 0.99 * limit
assert np.sqrt(np.linalg.eigvalsh(small["LHipPitchLink"][2])[2] / small["LHipPitchLink"][0]) > 0.175

# The same legs with thigh and shank about their centres of mass, and in the third file.
mended = model.copy()
for joint, name in (("LHipPitch", "LHipPitchLink"), ("LKneePitch", "LKneePitchLink")):
    mass, centre, tensor = small[name]
    index = model.getJointId(joint)
    assert np.allclose(model.inertias[index].inertia, tensor) and np.allclose(model.inertias[index].lever, centre)
    mended.inertias[index] = pin.Inertia(mass, centre, tensor - shift(mass, centre))


def felt(which, joint):
    matrix = pin.crba(which, which.createData(), pin.neutral(which))
    index = which.joints[which.getJointId(joint)].idx_v
    return matrix[index, index]


laas = pin.buildModelFromUrdf(str(folder / "romeo_laas_small.urdf"))
felt_by = {
    joint: np.array([felt(model, joint), felt(mended, joint), felt(laas, joint + "_joint")])
    for joint in ("LHipPitch", "LKneePitch")
}
for joint, values in felt_by.items():
    print(joint, "inertia of the straight leg [kg m^2]: as written, about the centres, third file:", values.round(4))
assert np.allclose(felt_by["LHipPitch"][:2], [1.4686, 1.3302], atol=1e-3)
assert np.allclose(felt_by["LKneePitch"][:2], [0.2797, 0.2404], atol=1e-3)
PY
