#!/usr/bin/env bash
# Version:  exudyn 1.13.6 with numpy 2.4.6
# Does:     TExpSE3 and TExpSE3Inv of exudyn.lieGroupBasics, the tangent operator of the exponential of SE(3) and its inverse,
#           square a skew matrix entry by entry (** 2) where the matrix product is meant, and one coefficient of the
#           inverse lacks an angle. The operator is off by 0.001 of 1 at half a radian and 0.3 at 3, the inverse by
#           hundreds at 0.05 rad. Below 0.01 rad both are right, and TExpSO3, its inverse and ExpSE3 everywhere.
# Guess:    TExpSE3Inv(x) TExpSE3(x) is the unit matrix, as the names say.
# Means:    an integrator on SE(3) that takes these steps to wrong velocities of trunk and foot, and steps of 0.05 rad,
#           which one would call small, worst of all. A test at x = 0, or of a motion without turning, passes.
#           Invert a series, or differentiate ExpSE3. No report was found.
# Seen:     random screws of 0.005, 0.05, 0.5, 2 and 3 rad: product less the unit matrix 4e-10, 270, 2.6, 0.092 and 0.61; TExpSE3
#           against difference quotients of ExpSE3 5e-10, 2e-7, 0.0009, 0.007 and 0.33; of rotations alone 1e-9
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check exudyn==1.13.6 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
from exudyn.lieGroupBasics import ExpSE3, TExpSE3, TExpSE3Inv, TExpSO3, TExpSO3Inv

h = 1e-6


def twist(pose, slope):
    """Velocity in the frame of the body, linear part first, of a pose that changes by slope."""
    S = np.linalg.inv(pose) @ slope
    return np.array([*S[:3, 3], S[2, 1], S[0, 2], S[1, 0]])


def operator(x):
    columns = [(ExpSE3(x + h * e) - ExpSE3(x - h * e)) / (2 * h) for e in np.eye(6)]
    return np.array([twist(ExpSE3(x), column) for column in columns]).T


rng = np.random.default_rng(1)
off = {}
for angle in (0.005, 0.05, 0.5, 2.0, 3.0):
    x = rng.normal(size=6)
    x[3:] *= angle / np.linalg.norm(x[3:])
    true = operator(x)
    assert np.allclose(true[:3, :3], TExpSO3(x[3:]), atol=1e-7)
    assert np.allclose(TExpSO3Inv(x[3:]) @ TExpSO3(x[3:]), np.eye(3), atol=1e-9)
    off[angle] = abs(TExpSE3(x) - true).max(), abs(TExpSE3Inv(x) @ TExpSE3(x) - np.eye(6)).max()
    exact = abs(TExpSE3Inv(x) @ true - np.eye(6)).max()
    print(f"{angle} rad: TExpSE3 off by {off[angle][0]:.2g} of {abs(true).max():.2g}; inverse times it, less 1, {off[angle][1]:.2g},"
          f" times the true one {exact:.2g}")
assert max(off[0.005]) < 1e-6
assert off[0.5][0] > 5e-4 and off[3.0][0] > 0.1
assert off[0.05][1] > 100 and off[0.5][1] > 1 and off[2.0][1] > 0.05
PY
