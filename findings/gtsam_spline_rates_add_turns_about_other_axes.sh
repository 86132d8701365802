#!/usr/bin/env bash
# Version:  gtsam 4.3.0
# Does:     sampleTrajectoryDerivative of CumulativeSplineTrajectoryRot3 and ...Pose3 adds the increments between control points,
#           each times the slope of its basis function, as if all had the same axes. The curve itself is their product,
#           so its velocity is a sum of increments that are carried along by the ones after them. The result is no velocity
#           of the curve in body axes, world axes or those of a control point: even its length is another. Turns
#           about one axis, and the first interval, are right. The curve is right, and so is the second derivative, as
#           the derivative of this sum.
# Guess:    the derivative of a trajectory on SO(3) is its angular velocity, in one frame or another.
# Means:    a gyroscope or foot velocity that is fitted with it pulls the trajectory to another motion, by a tenth to
#           more than half where control points are 0.5 to 1 rad apart and little where they are close. Take differences:
#           Logmap(T(t).between(T(t + h))) / h. (The splines came with pull request 2689; no report was found.)
# Seen:     control points of random turns of about 1.4 rad, five instants: first interval right to 1e-6; later
#           7.10 for 6.79 rad/s, in body axes off by 3.6 rad/s; of poses 4.59 for 4.13 rad/s; equal to the plain sum to
#           1e-9; about one axis right to 1e-6
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import gtsam
import numpy as np

WINDOW = 0.0, 2.0


def spline(cls, points):
    made = cls(4.0, False)
    for point in points:
        made.addControlPoint(point)
    return made


def velocity(curve, t, group, h=1e-5):
    """Body velocity of the curve by differences of the curve."""
    here, on, back = (curve.sampleTrajectory(at, *WINDOW) for at in (t, t + h, t - h))
    return (group.Logmap(here.between(on)) - group.Logmap(here.between(back))) / (2 * h)


worst = 0.0
for cls, group, n in ((gtsam.CumulativeSplineTrajectoryRot3, gtsam.Rot3, 3),
                      (gtsam.CumulativeSplineTrajectoryPose3, gtsam.Pose3, 6)):
    rng = np.random.default_rng(0)
    points = [group.Expmap(0.8 * rng.normal(size=n)) for _ in range(8)]
    curve = spline(cls, points)
    one = np.eye(n)[0]
    for t in (0.3, 0.6, 0.9, 1.2, 1.6):
        said, true = curve.sampleTrajectoryDerivative(t, *WINDOW), velocity(curve, t, group)
        # slopes of the basis: one turn about one axis at one control point after the other
        total = np.zeros(n)
        for k in range(1, 8):
            single = spline(cls, [group.Expmap(0.5 * one * (i >= k)) for i in range(8)])
            slope = single.sampleTrajectoryDerivative(t, *WINDOW)
            assert np.allclose(slope, velocity(single, t, group), atol=1e-6)  # about one axis it is right
            total += slope[0] / 0.5 * group.Logmap(points[k - 1].between(points[k]))
        lengths = np.linalg.norm(said[:3]), np.linalg.norm(true[:3])
        print(f"{group.__name__} t {t}: said {said.round(3)}, body {true.round(3)}, turning {lengths[0]:.3f} and {lengths[1]:.3f} rad/s")
        assert np.allclose(said, total, atol=1e-9)
        if t == 0.3:
            assert np.allclose(said, true, atol=1e-6)
        worst = max(worst, abs(lengths[0] - lengths[1]))
        if t > 0.6:
            assert np.linalg.norm(said - true) > 0.1 * np.linalg.norm(true)
print(f"lengths of the angular velocities apart by up to {worst:.3f} rad/s")
assert worst > 0.2
PY
