#!/usr/bin/env bash
# Version:  scikit-kinematics 0.10.4, scipy 1.17.1 to compare (0.12.0, for Python 3.12 and later, gives the same angles)
# Does:     quat.quat2seq and rotmat.sequence give the angles of four sequences, in the "same sequences as in the rotation matrices".
#           Beyond a right angle only rotmat.sequence for Fick (and nautical, which is the same) is right. quat2seq folds its first
#           and last angle into 90 degrees either way: a yaw of 100 comes back as 80. For Euler it has the supplement of the
#           first angle, so that it is wrong for every rotation. rotmat.sequence has the first two of Helmholtz in the other
#           order, and for Euler gives (0, 0, something) where the middle angle comes out negative. Nothing is said.
# Guess:    angles of one name are one triple, and the matrices of the three, multiplied, are the rotation.
# Means:    a trunk that turns round, a foot that is lifted past the horizontal or a shoulder comes back as another pose, by a smooth
#           curve that turns at 90 degrees as if the person did. Below 60 degrees Fick and Helmholtz of quat2seq are right.
#           Take Rotation.as_euler.
# Seen:     of 400 random rotations quat2seq is wrong for 75 % (Fick), 73 % (Helmholtz) and 100 % (Euler), rotmat.sequence for 0, 100 and
#           88 %; (100, 20, 30) degrees come back as (80, 20, 30) from all of quat2seq, 20 degrees off
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check scikit-kinematics==0.10.4 scipy==1.17.1 numpy==2.4.6
cd "$work"
env/bin/python -W ignore - <<'PY'
import numpy as np
from scipy.spatial.transform import Rotation
from skinematics import quat, rotmat

SEQUENCES = {"Fick": "ZYX", "nautical": "ZYX", "Helmholtz": "YZX", "Euler": "ZXZ"}
random = np.random.default_rng(0)
rotations = Rotation.random(400, rng=random)
small = rotations.magnitude() < np.radians(80)
WAYS = {
    "quat.quat2seq": lambda turn, name: quat.quat2seq(turn.as_quat(scalar_first=True), seq=name).ravel(),
    "rotmat.sequence": lambda turn, name: np.degrees(rotmat.sequence(turn.as_matrix(), to=name)),
}


def off(turn, name, angles):
    """By how much the three matrices, multiplied, miss the rotation (degrees)."""
    made = Rotation.from_euler(SEQUENCES[name], np.nan_to_num(angles), degrees=True)
    return np.degrees((made.inv() * turn).magnitude())


wrong = {}
for way, angles in WAYS.items():
    for name, axes in SEQUENCES.items():
        misses = np.array([off(turn, name, angles(turn, name)) for turn in rotations]) > 1e-3
        wrong[way, name] = misses.mean(), misses[small].mean()
        turn = Rotation.from_euler(axes, [100, 20, 30], degrees=True)
        seen = angles(turn, name)
        print(f"{way}, {name}: wrong for {misses.mean():.0%} of random rotations, {misses[small].mean():.0%} of small ones;"
              f" (100, 20, 30) is {seen.round(1)}, off by {off(turn, name, seen):.0f} degrees")
for name in ("Fick", "nautical"):
    assert wrong["rotmat.sequence", name] == (0, 0)
for name in ("Fick", "nautical", "Helmholtz"):
    assert 0.6 < wrong["quat.quat2seq", name][0] < 0.9 and wrong["quat.quat2seq", name][1] < 0.05
assert wrong["quat.quat2seq", "Euler"] == (1, 1) and min(wrong["rotmat.sequence", "Helmholtz"]) > 0.9
assert wrong["rotmat.sequence", "Euler"][0] > 0.7
PY
