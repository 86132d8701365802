#!/usr/bin/env bash
# Version:  pin-pink 4.4.0 with pin 4.1.0, and a leg of six hinges made in the script
# Does:     ManipulabilityTask is offered with two kinds of axes (LOCAL, WORLD) and with masks. Its Jacobian is the
#           gradient of its own compute_manipulability without a mask and with "orientation", and in LOCAL axes with
#           "position". With "position" in WORLD axes and with "planar_xy" in either it is another vector: the
#           formula that it cites is for axes of the world at the tip, which are refused. Nothing is said.
# Guess:    every combination that is not refused climbs the measure that it returns.
# Means:    a leg that is to keep away from a stretched knee is driven towards it in a quarter of all postures, at
#           the rate that was asked for. Use no mask, or LOCAL axes with "position", or difference the measure once.
# Seen:     of 100 postures the Jacobian points downhill in 25 (WORLD, position), 22 (LOCAL, planar_xy) and 26
#           (WORLD, planar_xy); it is the gradient to 1e-6 in the five other cases
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin-pink==4.4.0 pin==4.1.0
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
import pinocchio as pin
from pink import Configuration
from pink.tasks import ManipulabilityTask

leg = pin.Model()  # a leg of six hinges whose hip is beside the origin
parent, place = 0, np.array([0.05, 0.1, 0.9])
for name, kind, step in (
    ("hip_z", pin.JointModelRZ(), (0.02, 0.05, -0.05)),
    ("hip_x", pin.JointModelRX(), (0.01, 0.03, -0.05)),
    ("hip_y", pin.JointModelRY(), (0.0, 0.02, -0.4)),
    ("knee_y", pin.JointModelRY(), (0.03, 0.0, -0.4)),
    ("ankle_y", pin.JointModelRY(), (0.01, 0.01, -0.05)),
    ("ankle_x", pin.JointModelRX(), None),
):
    parent = leg.addJoint(parent, kind, pin.SE3(np.eye(3), place), name)
    place = np.array(step) if step else place
tip = "sole"
leg.addFrame(pin.Frame(tip, parent, pin.SE3(np.eye(3), np.array([0.05, 0.0, -0.06])), pin.OP_FRAME))
postures = np.random.default_rng(0).uniform(-1.0, 1.0, (100, leg.nq))


def at(q):
    return Configuration(leg, leg.createData(), q)


def own(q, axes, rows):  # the measure by hand: it is the task's own, too
    jacobian = pin.computeFrameJacobian(leg, leg.createData(), q, leg.getFrameId(tip), axes)[rows]
    return np.sqrt(np.linalg.det(jacobian @ jacobian.T))


ROWS = {None: slice(6), "position": slice(3), "orientation": slice(3, 6), "planar_xy": slice(2)}
downhill, error = {}, {}
for axes in (pin.LOCAL, pin.WORLD):
    for mask, rows in ROWS.items():
        task = ManipulabilityTask(tip, leg, reference_frame=axes, mask=mask, manipulability_rate=0.0)
        slopes = []
        for q in postures:
            assert np.isclose(task.compute_manipulability(at(q)), own(q, axes, rows), rtol=1e-9)
            steps = 1e-6 * np.eye(leg.nv)
            true = np.array([own(q + s, axes, rows) - own(q - s, axes, rows) for s in steps]) / 2e-6
            slopes.append((np.ravel(task.compute_jacobian(at(q))), true))
        downhill[axes.name, mask] = sum(bool(given @ true < -0.05 * np.linalg.norm(given) * np.linalg.norm(true)) for given, true in slopes)
        error[axes.name, mask] = max(np.linalg.norm(g - t) / np.linalg.norm(t) for g, t in slopes)
        print(f"{axes.name}, {mask}: downhill in {downhill[axes.name, mask]} of {len(slopes)},"
              f" largest relative error {error[axes.name, mask]:.1e}")
wrong = {("WORLD", "position"): 25, ("LOCAL", "planar_xy"): 22, ("WORLD", "planar_xy"): 26}
assert {case: count for case, count in downhill.items() if count} == wrong
assert all((error[case] > 1.0) == (case in wrong) for case in error)
assert all(error[case] < 1e-5 for case in error if case not in wrong)
PY
