#!/usr/bin/env bash
# Version:  drake 1.51.1
# Does:     beyond its end time a trajectory holds its last value, but its derivative stays the rate that
#           it had there: a cubic spline that ends at 1 rad with 2 rad/s is at 1 rad and 2 rad/s for ever.
#           So do B-splines and Bezier curves; a PiecewisePose reports rest.
# Guess:    value and derivative belong together: both at rest, or both going on.
# Means:    a foot that lands 50 ms late asks for the reference beyond the end of the step. The position
#           stands still while the feed-forward rate runs on: gain times rate is a torque that nobody
#           planned. Clamp or extend the reference yourself, both at once.
# Seen:     0.5 s late: value 1.0, its difference quotient 0, derivative 2.0 (spline), 1.8 (Bezier
#           curve and B-spline); pose 0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1
"$work/env/bin/python" - <<'PY'
import numpy as np
from pydrake.all import (
    BezierCurve,
    BsplineBasis,
    BsplineTrajectory,
    PiecewisePolynomial,
    PiecewisePose,
    RigidTransform,
)

times = np.linspace(0.0, 1.0, 6)
curves = {
    "cubic spline": PiecewisePolynomial.CubicShapePreserving(times, (times**2)[None]),
    "B-spline": BsplineTrajectory(BsplineBasis(4, 6), [np.array([[0.2 * k]]) for k in range(6)]),
    "Bezier curve": BezierCurve(0.0, 1.0, np.array([[0.0, 0.0, 0.4, 1.0]])),
}
late = 1.5
for name, curve in curves.items():
    value, end = curve.value(late).item(), curve.value(1.0).item()
    quotient = (curve.value(late + 1e-3).item() - curve.value(late - 1e-3).item()) / 2e-3
    rate, last = curve.EvalDerivative(late).item(), curve.EvalDerivative(1.0).item()
    made = curve.MakeDerivative().value(late).item()
    print(f"{name}: value {value:.3f}, difference quotient {quotient}, derivative {rate:.3f}")
    assert np.isclose(value, end) and np.isclose(end, 1.0) and quotient == 0.0
    assert np.isclose(rate, last) and np.isclose(made, last) and rate > 1.0
pose = PiecewisePose.MakeLinear([0.0, 1.0], [RigidTransform(), RigidTransform([1.0, 0.0, 0.0])])
print("pose:", pose.value(late)[:3, 3], "velocity", pose.GetVelocity(late)[3:])
assert not pose.GetVelocity(late).any() and pose.GetVelocity(0.5)[3] > 0.9
PY
