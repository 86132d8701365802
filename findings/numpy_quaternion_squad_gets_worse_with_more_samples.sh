#!/usr/bin/env bash
# Version:  numpy-quaternion 2024.0.13, scipy 1.17.1 to compare
# Does:     squad, "typically the best way to interpolate rotation timeseries", "the analog of a cubic spline", takes as
#           speed at a sample the mean of the speeds before and after, however long the two intervals are. Between
#           samples that are 10 and 40 ms apart in turn its angle is six times, and its speed three times, as far off
#           as between samples 50 ms apart that are every second one of the same. Values and speeds are continuous,
#           as it says. (Issue 41 of quaternionic, whose squad is made alike, asks where its formula for uneven
#           times comes from.)
# Guess:    more samples of a smooth motion make a cubic better; SciPy's RotationSpline does.
# Means:    sensors that drop a sample, two streams that are merged and solvers with steps of their own give uneven times.
#           The speed of a swinging thigh between them is off by 5 % of its largest, and the error falls with
#           the square of the step only. Take RotationSpline, or resample evenly first.
# Seen:     0.5 sin(2 pi t) rad about one axis: 50 ms apart off by 0.00025 rad and 0.051 rad/s; 10 and 40 ms in turn
#           0.00147 rad and 0.147 rad/s; RotationSpline 0.000040 and 0.0000089 rad
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check numpy-quaternion==2024.0.13 numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
import quaternion
from scipy.spatial.transform import Rotation, RotationSpline

AXIS = np.array([0.0, 1.0, 0.0])
between, h = np.linspace(0.1, 0.9, 801), 1e-5


def angle(t):
    return 0.5 * np.sin(2 * np.pi * t)


def off(times):
    """Largest error of angle and speed of squad, and of the angle of RotationSpline."""
    samples = quaternion.from_rotation_vector(np.outer(angle(times), AXIS))

    def turned(t):
        return quaternion.as_rotation_vector(quaternion.squad(samples, times, t)) @ AXIS

    speed = (turned(between + h) - turned(between - h)) / (2 * h)
    spline = RotationSpline(times, Rotation.from_rotvec(np.outer(angle(times), AXIS)))
    return (
        np.max(abs(turned(between) - angle(between))),
        np.max(abs(speed - np.pi * np.cos(2 * np.pi * between))),
        np.max(abs(spline(between).as_rotvec() @ AXIS - angle(between))),
    )


uneven = np.concatenate([[0.0], np.cumsum(np.tile([0.01, 0.04], 20))])
seen = {"50 ms": off(uneven[::2]), "10 and 40 ms": off(uneven)}
for name, errors in seen.items():
    print("{}: squad {:.5f} rad and {:.3f} rad/s off, RotationSpline {:.7f} rad off".format(name, *errors))
coarse, fine = seen.values()
assert 5 < fine[0] / coarse[0] < 7 and 2.5 < fine[1] / coarse[1] < 3.5 and fine[2] < 0.3 * coarse[2]
assert abs(fine[0] - 0.00147) < 2e-5 and abs(coarse[0] - 0.00025) < 1e-5
PY
