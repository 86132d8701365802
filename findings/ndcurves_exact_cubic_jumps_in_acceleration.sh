#!/usr/bin/env bash
# Version:  ndcurves 2.3.0, scipy 1.17.1 to compare
# Does:     exact_cubic is "the unique set of cubic splines" through given points at given times whose "acceleration is continuous".
#           So it is at even times. At uneven ones place and velocity are continuous, and the acceleration jumps at every point
#           inside. The continuity condition of its header has the squares of two neighbouring intervals the wrong way round,
#           a difference that vanishes where they are equal. Nothing is said.
# Guess:    what its header says. SciPy's cubic splines through the same points, natural, clamped or not-a-knot, have it.
# Means:    the way of a centre of mass through points at the times of a gait (double support is shorter than swing) passes them all
#           and swings wildly between: accelerations of a hundred g for one of a fifth. A milder case looks smooth in place and speed
#           and has steps in its torques. Take SciPy's CubicSpline and make its pieces polynomials of ndcurves.
# Seen:     a centre of mass over two steps, intervals 0.1, 0.4, 0.1 and 0.4 s: jump 979 m/s², largest acceleration 931 m/s² (natural
#           spline: 0 and 2); even times: jump 3e-11 m/s², 18 m/s²
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check ndcurves==2.3.0 scipy==1.17.1 numpy==2.4.6
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
from ndcurves import exact_cubic
from scipy.interpolate import CubicSpline

# centre of mass at the ends of double and of single supports: ahead, to the side, up
PLACES = np.array([[0.0, 0.08, 0.38, 0.46, 0.76], [0.0, 0.02, 0.03, 0.0, -0.03], [0.86, 0.85, 0.87, 0.85, 0.86]])
EVEN, GAIT = np.linspace(0, 1.0, 5), np.array([0.0, 0.1, 0.5, 0.6, 1.0])


def jumps(curve, times):
    """Largest jump of place, velocity and acceleration at the points inside."""
    return [max(np.abs(curve(t + 1e-12, k) - curve(t - 1e-12, k)).max() for t in times[1:-1]) for k in range(3)]


for name, times in (("even", EVEN), ("gait", GAIT)):
    made = exact_cubic(PLACES, times[:, None])

    def curve(t, k):
        return np.ravel(made.derivate(t, k) if k else made(t))

    assert all(np.allclose(curve(t, 0), place, atol=1e-9) for t, place in zip(times, PLACES.T))
    seen = jumps(curve, times)
    within = np.linspace(times[0], times[-1], 2001)
    natural = CubicSpline(times, PLACES.T, bc_type="natural")
    largest = np.abs([curve(t, 2) for t in within]).max(), np.abs(natural(within, 2)).max()
    print(f"{name} times: acceleration up to {largest[0]:.0f} m/s² (SciPy's natural spline {largest[1]:.0f}),"
          f" jumps {seen[0]:.0e} m, {seen[1]:.0e} m/s, {seen[2]:.3g} m/s²")
    assert max(seen[:2]) < 1e-8 and (seen[2] > 500 if name == "gait" else seen[2] < 1e-6)
    for kind in ("natural", "clamped", "not-a-knot"):
        assert jumps(CubicSpline(times, PLACES.T, bc_type=kind), times)[2] < 1e-6
PY
