#!/usr/bin/env bash
# Version:  geomstats 2.8.0, numpy 1.26.4, scipy 1.13.1
# Does:     jacobian_translation(point, left=False) of SE(3) in vectors, "the differential of the right translation from the identity", has the
#           rotation vector of the point where the place belongs: its lower left block is minus the cross matrix of the turn. The metric
#           with left=False is made of it, so that it changes when all poses are moved on the right. left=True is right.
# Guess:    the differential that the docstring names, which finite differences give, and an InvariantMetric that is invariant.
# Means:    spatial velocities (right translation) of a trunk or foot and lengths of motions in them depend on where the walk
#           began; two robots on one path at two places have two efforts. Take left=True, or build the block of the place. No report was found.
# Seen:     block against finite differences: right to 1e-9 for left, off by 1.0 for right, and equal to the cross matrix of the turn; square of one
#           velocity before and after one right translation 0.289 and 0.976, by hand 0.651 twice; left 0.345 twice
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check geomstats==2.8.0 numpy==1.26.4 scipy==1.13.1
cd "$work"
GEOMSTATS_BACKEND=numpy "$work/env/bin/python" -W ignore - > out 2>&1 <<'PY' || { tail -20 out; exit 1; }
import numpy as np
from geomstats.geometry.invariant_metric import InvariantMetric
from geomstats.geometry.special_euclidean import SpecialEuclidean
from scipy.spatial.transform import Rotation

STEP = 1e-6
POSE, MOVE = np.r_[0.3, -0.5, 0.8, 1.0, 0.4, -0.2], np.r_[0.5, 0.2, -0.3, -0.4, 0.6, 0.9]  # rotation vector, place
RATE = np.array([0.1, 0.3, -0.2, 0.4, 0.1, 0.2])


def matrix(pose):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = Rotation.from_rotvec(pose[:3]).as_matrix(), pose[3:]
    return result


def hat(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def slope(f, at, along):
    return (f(at + STEP * along) - f(at - STEP * along)) / (2 * STEP)


for left in (True, False):
    space = SpecialEuclidean(3, point_type="vector", equip=False)
    space.equip_with_metric(InvariantMetric, left=left)

    def move(pose, by):
        moved = space.compose(by, pose) if left else space.compose(pose, by)
        product = matrix(by) @ matrix(pose) if left else matrix(pose) @ matrix(by)
        assert np.allclose(matrix(moved), product)
        return moved

    told = space.jacobian_translation(POSE, left=left)
    right = np.array([slope(lambda d: move(d, POSE), np.zeros(6), axis) for axis in np.eye(6)]).T
    squares = [float(space.metric.squared_norm(RATE, POSE)), float(space.metric.squared_norm(slope(lambda x: move(x, MOVE), POSE, RATE), move(POSE, MOVE)))]
    by_hand = []
    for point, rate in ((POSE, RATE), (move(POSE, MOVE), slope(lambda x: move(x, MOVE), POSE, RATE))):
        change, inverse = slope(matrix, point, rate), np.linalg.inv(matrix(point))
        twist = inverse @ change if left else change @ inverse
        by_hand.append(twist[2, 1] ** 2 + twist[0, 2] ** 2 + twist[1, 0] ** 2 + twist[:3, 3] @ twist[:3, 3])
    off = abs(told - right).max()
    print(f"SEEN {'left' if left else 'right'}: differential off by {off:.1e}; square of the velocity {squares[0]:.3f}, after the move {squares[1]:.3f}, "
          f"by hand {by_hand[0]:.3f} and {by_hand[1]:.3f}")
    assert abs(by_hand[0] - by_hand[1]) < 1e-6
    if left:
        assert off < 1e-6 and np.allclose(squares, by_hand, atol=1e-6)
    else:
        assert np.allclose(told[3:, :3], -hat(POSE[:3])) and np.allclose(right[3:, :3], -hat(POSE[3:]), atol=1e-6)
        assert squares[1] > 3 * squares[0] and off > 1
PY
grep SEEN out
