#!/usr/bin/env bash
# Version:  liecasadi 0.0.7 with casadi 3.8.2, scipy 1.17.1 to compare
# Does:     SO3.from_matrix (and SE3.from_matrix, DualQuaternion.from_matrix with it) gives a half turn the quaternion
#           (0, 0, 0, 0), whose matrix is the unit matrix: turned by 180 degrees becomes not turned. Of turns about
#           one axis some come out as nan, where rounding makes the radicand of a zero component negative. And
#           SO3.log takes the quaternion as it is: the same rotation with the other sign has 2 pi less its angle, and
#           so has a product of three turns of 3.0, 3.0 and 0.5 rad, which is 0.217 rad. Nothing is said.
# Guess:    from_matrix(R).as_matrix() is R; the logarithm of a rotation is one vector, of at most pi.
# Means:    frames of mirrored legs and of feet are half turns to their twins more often than not: the twin loses its
#           turn, and kinematics go on with a foot that points the other way. "-" between two orientations, the usual
#           residual of an orientation task, may ask for a whole turn less the error. Make the quaternion elsewhere, and
#           turn its sign to w >= 0 before log.
# Seen:     diag(1, -1, -1), diag(-1, -1, 1) and the half turn about x = y: quaternion 0, matrix the unit matrix; nan for 156
#           of 3003 turns about x, y or z; 0.2 rad about y: log 0.2 and, with the sign turned, -6.083
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check liecasadi==0.0.7 casadi==3.8.2 scipy==1.17.1
cd "$work"
"$work/env/bin/python" - <<'PY'
import casadi as cs
import numpy as np
from liecasadi import SE3, SO3
from scipy.spatial.transform import Rotation

halves = {"about x": np.diag([1.0, -1.0, -1.0]), "about z": np.diag([-1.0, -1.0, 1.0]),
          "about x = y": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])}
for name, half in halves.items():
    assert np.isclose(Rotation.from_matrix(half).magnitude(), np.pi)
    read = SO3.from_matrix(cs.DM(half))
    pose = np.eye(4)
    pose[:3, :3] = half
    print("half turn", name, "quaternion", read.as_quat().coeffs(), "matrix", np.array(read.as_matrix()).tolist())
    assert np.array_equal(np.array(read.as_matrix()), np.eye(3))
    assert np.array_equal(np.array(SE3.from_matrix(cs.DM(pose)).as_matrix()), np.eye(4))

turns = [Rotation.from_rotvec(angle * axis) for angle in np.linspace(-3.0, 3.0, 1001) for axis in np.eye(3)]
read = [np.array(SO3.from_matrix(cs.DM(turn.as_matrix())).as_matrix()) for turn in turns]
lost = [bool(np.isnan(one).any()) for one in read]
print("nan for", sum(lost), "of", len(lost), "turns about one axis")
assert 10 < sum(lost) < len(lost) / 2
assert all(np.allclose(one, turn.as_matrix()) for one, turn, nan in zip(read, turns, lost) if not nan)

quaternion = Rotation.from_rotvec([0.0, 0.2, 0.0]).as_quat()
logs = [float(SO3(cs.DM(sign * quaternion)).log().vec[1]) for sign in (1.0, -1.0)]
product = float((SO3.qz(3.0) * SO3.qz(3.0) * SO3.qz(0.5)).log().vec[2])
print("log of one rotation:", np.round(logs, 4), "; of 3.0, 3.0 and 0.5 rad about z:", round(product, 4),
      "for", round(6.5 - 2 * np.pi, 4))
assert np.isclose(logs[0], 0.2) and np.isclose(logs[1], 0.2 - 2 * np.pi)
assert np.isclose(product, 6.5 - 4 * np.pi)
PY
