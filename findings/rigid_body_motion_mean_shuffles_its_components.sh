#!/usr/bin/env bash
# Version:  rigid-body-motion 0.9.3 with numpy-quaternion 2024.0.13, numpy 2.4.6
# Does:     qmean, the mean of orientations, computes the eigenvectors of the mean outer product and sorts by eigenvalue,
#           but takes the first column of their matrix, whichever that is, with its four components put in the order
#           of the eigenvalues. What comes out has length 1 and looks like a quaternion. It is another turn, even
#           for the mean of one orientation.
# Guess:    the mean of a hundred almost equal orientations is almost that orientation.
# Means:    the mean posture of a pelvis, the alignment of an inertial sensor on a shank, the neutral of a
#           standing trial: all are off by up to half a turn, and joint angles against them are another
#           joint's. Take Rotation.mean of SciPy.
# Seen:     a trunk at 60, 20 and 10 degrees of roll, pitch and yaw, a hundred times with 0.5 or 5 degrees of scatter: mean 33 or
#           70 degrees away; the eigenvector itself and SciPy's mean within 1e-12 of each other, 0.05 and 0.6 degrees away
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check rigid-body-motion==0.9.3 numpy-quaternion==2024.0.13 \
  numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
import rigid_body_motion as rbm
from scipy.spatial.transform import Rotation

draw = np.random.default_rng(0)
trunk = Rotation.from_euler("ZYX", [10.0, 20.0, 60.0], degrees=True)
for spread in (0.5, 5.0):
    samples = trunk * Rotation.from_rotvec(draw.normal(scale=spread, size=(100, 3)), degrees=True)
    quaternions = samples.as_quat(scalar_first=True)
    own = rbm.qmean(quaternions, axis=0)
    right = samples.mean()
    # By hand: the eigenvector of the largest eigenvalue, and what is taken.
    values, vectors = np.linalg.eig(np.mean(quaternions[:, :, None] * quaternions[:, None, :], axis=0))
    eigenvector, shuffled = vectors[:, values.argmax()], vectors[values.argsort()[::-1], 0]
    off, off_eigenvector, off_shuffled = (
        np.degrees((Rotation.from_quat(np.real(q), scalar_first=True).inv() * right).magnitude())
        for q in (own, eigenvector, shuffled))
    print(f"spread {spread} degrees: qmean {off:.1f} degrees from SciPy's mean, eigenvector {off_eigenvector:.1e}, the trunk "
          f"{np.degrees((right.inv() * trunk).magnitude()):.2f}; "
          f"length {np.linalg.norm(own):.6f}")
    assert abs(np.linalg.norm(own) - 1) < 1e-9 and np.isclose(off, off_shuffled)
    assert off_eigenvector < 1e-4 and off > 20.0
    assert np.degrees((right.inv() * trunk).magnitude()) < 0.3 * spread
PY
