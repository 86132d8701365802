#!/usr/bin/env bash
# Version:  casadi 3.8.2, scipy 1.17.1 to compare
# Does:     interpolant(..., "bspline", ...) is exactly 0 outside its grid, and so is its derivative: one rounding
#           step past the last sample, 0.6000000000000001 for 0.6, a knee of 1.2 rad is at 0 rad. Nothing is said.
#           "linear" goes on along its last line, and SciPy's spline through the same samples goes on.
# Guess:    a smooth table goes on, holds its end, or refuses; that the value of the last sample is found
#           within rounding of the last sample.
# Means:    times made as k * dt pass the end of a step by rounding (6 * 0.1 > 0.6), and the reference there is a
#           jump to 0 with a feed-forward rate of 0. In an optimisation over ground heights a foot beyond the
#           edge of the map stands on 0 with no slope to bring it back. Give the table a margin of samples on both
#           sides, or clip its argument with fmin and fmax.
# Seen:     at 0.6: 1.2 rad, 6.04 rad/s; at 6 * 0.1: 0 rad, 0 rad/s; at -1e-18: 0; linear and SciPy 1.2;
#           height map of a ramp of 0.3 m: 0.3 at its edge, 0 at 1e-9 m beyond
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2 scipy==1.17.1
"$work/env/bin/python" - <<'PY'
import casadi
import numpy as np
from scipy.interpolate import make_interp_spline

times = np.linspace(0.0, 0.6, 13)
knee = 1.2 + 0.4 * np.sin(2 * np.pi * times / 0.6) - 3.0 * times * (0.6 - times)
spline = casadi.interpolant("knee", "bspline", [times], knee)
line = casadi.interpolant("line", "linear", [times], knee)
scipy = make_interp_spline(times, knee, k=3)
t = casadi.MX.sym("t")
rate = casadi.Function("rate", [t], [casadi.jacobian(spline(t), t)])
late = 6 * 0.1
assert 0.0 < late - times[-1] < 2e-16
for at in (float(times[-1]), late, 0.0, -1e-18):
    print(
        f"t {at!r:20}: spline {float(spline(at)):.6f} rad, {float(rate(at)):.6f} rad/s; "
        f"linear {float(line(at)):.6f}; SciPy {float(scipy(at)):.6f} rad, {float(scipy(at, 1)):.6f} rad/s"
    )
inside = np.linspace(0.0, 0.6, 101)[1:-1]
assert np.abs(np.array(spline(inside)).ravel() - scipy(inside)).max() < 1e-12  # the same spline
for end, beyond in ((times[-1], late), (times[0], -1e-18)):
    assert abs(float(spline(end)) - 1.2) < 1e-12 and abs(float(rate(end)) - float(scipy(end, 1))) < 1e-9
    assert float(spline(beyond)) == 0.0 and float(rate(beyond)) == 0.0
    assert abs(float(line(beyond)) - 1.2) < 1e-9 and abs(float(scipy(beyond)) - 1.2) < 1e-9

grid = [np.linspace(0.0, 2.0, 9), np.linspace(-1.0, 1.0, 9)]
heights = (0.15 * grid[0][:, None] * np.ones(9)).ravel(order="F")
ground = casadi.interpolant("ground", "bspline", grid, heights)
edge, beyond = float(ground([2.0, 0.2])), float(ground([2.0 + 1e-9, 0.2]))
print(f"ramp: {edge:.6f} m at its edge, {beyond:.6f} m 1e-9 m beyond")
assert abs(edge - 0.3) < 1e-9 and beyond == 0.0
PY
