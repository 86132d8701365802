#!/usr/bin/env bash
# Version:  pyquaternion 0.9.9
# Does:     Quaternion.yaw_pitch_roll, "intrinsic Tait-Bryan angles following the z-y'-x'' convention", gives those of x-y'-z'':
#           the rotation is Rx(roll) Ry(pitch) Rz(yaw), not Rz(yaw) Ry(pitch) Rx(roll). The docstring says both. One angle
#           at a time is right. (Open as issue 72, "misleading docstring".)
# Guess:    yaw first, about the vertical, then pitch and roll, as everywhere where the three have these names.
# Means:    a trunk that leans forward by 20 degrees reads as rolled as soon as the robot has turned: heading and lean
#           mix, and walking in a circle looks like falling in turns. A yaw of zero does not mean that it
#           faces forward. Take SciPy's as_euler("ZYX").
# Seen:     heading 90, lean (pitch) 20, roll 0 degrees: yaw 90, pitch 0, roll -20; heading 45: yaw 46.8, pitch 14.0, roll
#           -14.4; built again by z-y'-x'' up to 88 degrees away in 1000 postures of up to 60 degrees each
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pyquaternion==0.9.9 numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" - <<'PY'
import numpy as np
from pyquaternion import Quaternion
from scipy.spatial.transform import Rotation


def read(rotation):
    """Yaw, pitch and roll [degrees] of pyquaternion."""
    return np.degrees(Quaternion(rotation.as_quat(scalar_first=True)).yaw_pitch_roll)


for angles in ((30.0, 0.0, 0.0), (0.0, 20.0, 0.0), (0.0, 0.0, 10.0), (45.0, 20.0, 0.0), (90.0, 20.0, 0.0)):
    own = read(Rotation.from_euler("ZYX", angles, degrees=True))
    print(f"yaw, pitch, roll {angles}: read {own.round(1)}")
    assert np.allclose(own, angles, atol=1e-9) == (np.count_nonzero(angles) == 1)

draw = np.random.default_rng(0)
worst = 0.0
for _ in range(1000):
    posture = Rotation.from_euler("ZYX", draw.uniform(-60.0, 60.0, size=3), degrees=True)
    yaw, pitch, roll = read(posture)
    documented = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True)
    other = Rotation.from_euler("XYZ", [roll, pitch, yaw], degrees=True)
    assert (other.inv() * posture).magnitude() < 1e-7
    worst = max(worst, np.degrees((documented.inv() * posture).magnitude()))
print(f"built again by z-y'-x'': up to {worst:.0f} degrees away; by x-y'-z'': 0")
assert worst > 60.0
PY
