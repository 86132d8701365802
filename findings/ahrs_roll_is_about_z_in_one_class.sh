#!/usr/bin/env bash
# Version:  AHRS 0.4.0, scipy 1.17.1 to compare
# Does:     Quaternion(rpy=...) and QuaternionArray take roll, pitch and yaw about x, y and z. DCM(rpy=...), "array with
#           roll->pitch->yaw angles", turns by the first about z and by the last about x. DCM.to_rpy gives the angles
#           of the transpose, so it inverts neither of the two; DCM.log is the logarithm of the transpose, and
#           said to be the inverse of the exponential map.
# Guess:    one package has one meaning of roll, pitch and yaw, and to_rpy gives the angles that rpy took.
# Means:    a thigh or trunk from an inertial sensor that bends forward by 40 degrees bends by another angle as soon as
#           it passes through a DCM; angles about one axis alone come back with the sign turned, which looks like
#           a convention. Convert with Quaternion only.
# Seen:     roll 10, pitch -20, yaw 30 degrees: the two rotations are 22.9 degrees apart; DCM(rpy).to_rpy() gives
#           (-33.8, 11.8, -19.0) degrees; DCM of a turn of +40 degrees about y has to_rpy pitch -40
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check AHRS==0.4.0 scipy==1.17.1
"$work/env/bin/python" - <<'PY'
import numpy as np
from ahrs import DCM, Quaternion
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

angles = np.radians([10.0, -20.0, 30.0])
by_quaternion = Quaternion(rpy=angles).to_DCM()
by_matrix = np.asarray(DCM(rpy=angles))
zyx = Rotation.from_euler("ZYX", angles[::-1]).as_matrix()  # yaw, then pitch, then roll, about the axes of the body
swapped = Rotation.from_euler("ZYX", angles).as_matrix()
apart = np.degrees(Rotation.from_matrix(by_quaternion.T @ by_matrix).magnitude())
back = np.degrees(DCM(rpy=angles).to_rpy())
back_from_quaternion = np.degrees(DCM(by_quaternion).to_rpy())
pitch = np.degrees(DCM(y=np.radians(40.0)).to_rpy())
turn = DCM(by_quaternion)
print(f"two rotations of the same angles are {apart:.2f} degrees apart")
print(f"to_rpy: {back.round(2)} of DCM(rpy=(10, -20, 30)), {back_from_quaternion.round(2)} of the quaternion's matrix")
print(f"to_rpy of +40 degrees about y: {pitch.round(2)}; Quaternion.to_angles of its own: "
      f"{np.degrees(Quaternion(rpy=angles).to_angles()).round(2)}")
assert np.allclose(by_quaternion, zyx) and np.allclose(by_matrix, swapped)
assert np.allclose(Quaternion(rpy=angles).to_angles(), angles)
of_transpose = Rotation.from_matrix(by_quaternion.T).as_euler("ZYX", degrees=True)[::-1]
print(f"angles of the transpose: {of_transpose.round(2)}; expm(log) is the transpose:", np.allclose(expm(turn.log), turn.T))
assert np.allclose(back_from_quaternion, of_transpose)
assert np.allclose(pitch, [0, -40, 0]) and apart > 20 and np.abs(back - [10, -20, 30]).max() > 40
assert np.allclose(expm(turn.log), turn.T) and not np.allclose(expm(turn.log), turn, atol=0.1)
PY
