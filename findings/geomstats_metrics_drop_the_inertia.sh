#!/usr/bin/env bash
# Version:  geomstats 2.8.0, numpy 1.26.4, scipy 1.13.1
# Does:     InvariantMetric takes "metric_mat_at_identity: Matrix that defines the metric at identity" and drops it where it is not diagonal: lengths
#           and geodesics on SO(3) are then those of the identity, and twice that. A diagonal one counts double. On vectors (point_type "vector")
#           lengths and geodesics are those of the identity for every matrix, diagonal or not. Nothing is said.
# Guess:    the square of a speed is w' G w, and the geodesics of the left metric with G an inertia are the free rotations of that body, as
#           the documentation's reference on mechanics has it.
# Means:    flips, tumbling and swings of a trunk whose inertia has products, planned as geodesics, are those of a ball, and distances
#           between turns weigh all axes alike. Turn to the principal axes first, halve the lengths, and take matrices. No report was found.
# Seen:     w = (0.3, 1, -0.5), square of the speed for the identity 1.340, a diagonal and a full inertia 2.840 and 2.505: as matrices 2.680, 5.680 and
#           2.680, as vectors 1.340 each. Geodesic of 1 s against the free rotation: full inertia off by 0.025 rad, to 1e-4 the turn of a
#           ball; diagonal right as matrices (1e-4), off by 0.277 as vectors
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check geomstats==2.8.0 numpy==1.26.4 scipy==1.13.1
cd "$work"
GEOMSTATS_BACKEND=numpy "$work/env/bin/python" -W ignore - > out 2>&1 <<'PY' || { tail -20 out; exit 1; }
import numpy as np
from geomstats.geometry.invariant_metric import InvariantMetric
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

VELOCITY = np.array([0.3, 1.0, -0.5])
INERTIAS = {
    "identity": np.eye(3),
    "diagonal": np.diag([1.0, 2.0, 3.0]),
    "full": np.array([[1.0, 0.2, 0.1], [0.2, 2.0, 0.3], [0.1, 0.3, 2.5]]),
}


def hat(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def free(inertia):
    """Turn of one second from rest in the identity, by Euler's equations."""

    def rates(_, y):
        turn, w = y[:9].reshape(3, 3), y[9:]
        return np.r_[(turn @ hat(w)).ravel(), np.linalg.solve(inertia, np.cross(inertia @ w, w))]

    return solve_ivp(rates, (0, 1), np.r_[np.eye(3).ravel(), VELOCITY], rtol=1e-11, atol=1e-11).y[:9, -1].reshape(3, 3)


def apart(a, b):
    return Rotation.from_matrix(a @ b.T).magnitude()


ball = Rotation.from_rotvec(VELOCITY).as_matrix()
for words, inertia in INERTIAS.items():
    right = VELOCITY @ inertia @ VELOCITY
    for kind, velocity, start in (("matrix", hat(VELOCITY), np.eye(3)), ("vector", VELOCITY, np.zeros(3))):
        space = SpecialOrthogonal(3, point_type=kind, equip=False)
        space.equip_with_metric(InvariantMetric, metric_mat_at_identity=inertia, left=True)
        square = float(space.metric.squared_norm(velocity, start))
        end = space.metric.exp(velocity, start)
        end = end if kind == "matrix" else Rotation.from_rotvec(end).as_matrix()
        off, from_ball = apart(end, free(inertia)), apart(end, ball)
        print(f"SEEN {words}, {kind}: square of the speed {square:.3f} of {right:.3f}; geodesic off the free rotation by {off:.4f} rad, off a ball's by {from_ball:.4f}")
        assert abs(square - (VELOCITY @ VELOCITY * (2 if kind == "matrix" else 1) if words == "full" or kind == "vector" else 2 * right)) < 1e-6
        if words == "identity" or (words, kind) == ("diagonal", "matrix"):
            assert off < 2e-4
        else:
            assert off > 0.02 and from_ball < 2e-4
PY
grep SEEN out
