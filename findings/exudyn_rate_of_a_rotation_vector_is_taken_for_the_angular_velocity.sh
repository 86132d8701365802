#!/usr/bin/env bash
# Version:  exudyn 1.13.6, scipy 1.17.1 to compare
# Does:     RotationVector2G and RotationVector2GLocal, said to give the derivative of the angular velocity (global, local)
#           over the rate of the rotation vector, return the rotation matrix and the identity, whatever the vector: true at a
#           vector of zero or for a rate along it. The same functions for RotXYZ angles (RotXYZ2G, RotXYZ2GLocal) are
#           right, and so is the rotation matrix of the vector. No report was found.
# Guess:    G times the rate is the angular velocity of the body, for each of the parametrisations.
# Means:    a thigh or a trunk given by a rotation vector that turns while it swings has its angular velocity off by a tenth, and
#           energy, spin and fitted rates with it; at small angles, where code is tried, nothing shows.
#           Difference the rotation matrices, or use RotXYZ.
# Seen:     vector (0.2, 0.9, -0.5) rad, rate (1, 2, -1.5) rad/s: local angular velocity (1, 2, -1.5) by G, (1.073, 2.135, -1.229)
#           by differences, 11.6 % apart; at a hundredth of the vector 0.12 %; RotXYZ equal to 1e-7
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check exudyn==1.13.6 numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" -W ignore - <<'PY'
import exudyn.rigidBodyUtilities as rigid
import numpy as np
from scipy.spatial.transform import Rotation


def speeds(turn, at, rate, h=1e-6):
    """Angular velocity in world and in body axes from matrices a moment before and after."""
    before, after = np.array(turn(at - h * rate)), np.array(turn(at + h * rate))
    world = Rotation.from_matrix(after @ before.T).as_rotvec() / (2 * h)
    return world, np.array(turn(at)).T @ world


at, rate = np.array([0.2, 0.9, -0.5]), np.array([1.0, 2.0, -1.5])
assert np.allclose(rigid.RotationVector2RotationMatrix(at), Rotation.from_rotvec(at).as_matrix(), atol=1e-12)
off = {}
for name, turn, world, local in (
    ("rotation vector", rigid.RotationVector2RotationMatrix, rigid.RotationVector2G, rigid.RotationVector2GLocal),
    ("RotXYZ", rigid.RotXYZ2RotationMatrix, rigid.RotXYZ2G, rigid.RotXYZ2GLocal),
):
    for scale in (1.0, 0.01):
        true = speeds(turn, scale * at, rate)
        given = np.array(world(scale * at)) @ rate, np.array(local(scale * at)) @ rate
        off[name, scale] = [np.linalg.norm(g - t) / np.linalg.norm(t) for g, t in zip(given, true, strict=True)]
        print(f"{name} {scale * at}: local {np.round(given[1], 4)}, by differences {np.round(true[1], 4)};"
              f" off by {100 * off[name, scale][0]:.3f} % (world), {100 * off[name, scale][1]:.3f} % (local)")
assert min(off["rotation vector", 1.0]) > 0.11 and max(off["rotation vector", 0.01]) < 0.01
assert max(off["RotXYZ", 1.0] + off["RotXYZ", 0.01]) < 1e-7
PY
