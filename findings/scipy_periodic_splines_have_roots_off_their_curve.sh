#!/usr/bin/env bash
# Version:  scipy 1.17.1 (numpy 2.4.6)
# Does:     CubicSpline(..., bc_type="periodic") is evaluated periodically, and its roots() and solve(), with no further
#           argument or with extrapolate="periodic", also return roots of the first and the last polynomial
#           carried on beyond the period, where the curve is not. The documentation says that "periodic" works the same
#           as False there (roots within the period), and that the spline's own setting, "periodic", is the default.
#           Both are taken for True. The derivative's roots are of the same kind; extrapolate=False is right.
# Guess:    what roots() returns is a zero of the spline that it was asked of.
# Means:    a gait cycle is such a spline: instants of largest knee flexion, of zero speed of the swing foot or of a
#           touchdown that are read from it include some before and after the stride, at which neither the
#           spline nor its derivative is zero, and len(roots) counts steps that are not taken. Pass extrapolate=False.
# Seen:     knee of 0.5 + 0.4 sin rad: crossing 0.6 at 0.040 and 0.460 of a stride, and also at -0.410 and 1.370, where the
#           spline is 0.286 and 0.792 rad; speed zero at 0.25 and 0.75, and also at -0.226 and 1.226, where it is 0.4 rad
#           a stride
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import numpy as np
from scipy.interpolate import CubicSpline

stride = np.linspace(0.0, 1.0, 21)
knee = CubicSpline(stride, 0.5 + 0.4 * np.sin(2 * np.pi * stride), bc_type="periodic")
assert knee.extrapolate == "periodic" and np.isclose(knee(1.3), knee(0.3), atol=1e-12)
by_hand = np.arcsin(0.25) / (2 * np.pi)
by_hand = np.array([by_hand, 0.5 - by_hand])


def seen(curve, roots, level):
    for time in roots:
        print(f"  at {time:.3f} of a stride the curve is {curve(time):.3f}")
    inside = (roots >= 0) & (roots <= 1)
    assert np.allclose(curve(roots[inside]), level, atol=1e-9)
    return roots[inside], roots[~inside]


for extrapolate in (None, "periodic"):
    print(f"knee at 0.6, extrapolate={extrapolate!r}")
    inside, beyond = seen(knee, knee.solve(0.6, extrapolate=extrapolate), 0.6)
    assert np.allclose(inside, by_hand, atol=1e-4) and np.allclose(beyond, [-0.410, 1.040, 1.370], atol=2e-3)
    assert np.allclose(knee(beyond[[0, 2]]), [0.286, 0.792], atol=2e-3)  # by chance the second is nearly one
    print(f"speed zero, extrapolate={extrapolate!r}")
    inside, beyond = seen(knee.derivative(), knee.derivative().roots(extrapolate=extrapolate), 0.0)
    assert np.allclose(inside, [0.25, 0.75], atol=1e-6) and len(beyond) == 2
    assert np.min(abs(knee.derivative()(beyond))) > 0.3
only = knee.solve(0.6, extrapolate=False)
print("extrapolate=False:", np.round(only, 3))
assert np.allclose(only, by_hand, atol=1e-4)
PY
