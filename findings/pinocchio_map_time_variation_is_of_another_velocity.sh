#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     computeCentroidalMapTimeVariation, "the time derivative of the centroidal momentum matrix Ag", takes the
#           velocity of the centre of mass from data.vcom without computing it: that of whatever ran last on the same
#           data, and none in fresh data. The three rows of angular momentum are off by (wrong velocity) x (linear
#           rows). dccrba, which says the same of itself, computes it and is right. Times the rates of the state
#           itself both give the same vector in fresh data, so that this check passes. (The term came with pull
#           request 2094 after issue 2093, closed; that it is stale here is in no thread that was found.)
# Guess:    a function of model, q and v is a function of model, q and v; two of one description are equal.
# Means:    derivatives of angular momentum in a controller, or its product with any other velocity (a change of basis, a
#           Jacobian of a task), are those of another state; used twice on one data, even the bias dAg v is wrong.
#           Use dccrba, or call centerOfMass with q and v before.
# Seen:     sample humanoid, rates of about 1: angular rows, largest 34.9, off by 9.1 in fresh data, 28.7 after another
#           state, 1e-8 after centerOfMass of this one; dccrba 1e-8 always; bias dAg v off by 1e-8, 12.1 and 1e-8
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin

robot = pin.buildSampleModelHumanoid()
rng = np.random.default_rng(1)
q = pin.integrate(robot, pin.neutral(robot), 0.5 * rng.normal(size=robot.nv))
v, others, h = rng.normal(size=robot.nv), rng.normal(size=robot.nv), 1e-6


def matrix(time):
    return pin.computeCentroidalMap(robot, robot.createData(), pin.integrate(robot, q, time * v)).copy()


quotient = (matrix(h) - matrix(-h)) / (2 * h)
print("largest entry of the angular rows", f"{abs(quotient[3:]).max():.3g}")
used, told = robot.createData(), robot.createData()
pin.centerOfMass(robot, used, q, others)
pin.centerOfMass(robot, told, q, v)
off, bias = {}, {}
for name, function, data in (("fresh", pin.computeCentroidalMapTimeVariation, robot.createData()),
                             ("used", pin.computeCentroidalMapTimeVariation, used),
                             ("told", pin.computeCentroidalMapTimeVariation, told),
                             ("dccrba fresh", pin.dccrba, robot.createData()), ("dccrba used", pin.dccrba, used)):
    if name == "dccrba used":
        pin.centerOfMass(robot, used, q, others)
    difference = function(robot, data, q, v) - quotient
    off[name], bias[name] = abs(difference[3:]).max(), abs(difference @ v).max()
    print(f"{name:13} linear rows off by {abs(difference[:3]).max():.1g}, angular {off[name]:.3g}, bias {bias[name]:.3g}")
    assert abs(difference[:3]).max() < 1e-5
assert off["fresh"] > 1 and off["used"] > 1 and bias["used"] > 1
assert max(off["told"], off["dccrba fresh"], off["dccrba used"], bias["fresh"], bias["told"]) < 1e-5
PY
