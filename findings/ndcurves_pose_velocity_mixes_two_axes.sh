#!/usr/bin/env bash
# Version:  ndcurves 2.3.0, scipy 1.17.1 to compare
# Does:     SE3Curve.derivate(t, 1) is six numbers: the velocity of the origin along the axes of the world, and the angular
#           velocity about the axes of the moving body (that of SO3Linear). So it is for piecewise_SE3. What the axes are is
#           not said; "Evaluate the derivative of order N of curve at time t. Return as a vector 6" is all there is.
# Guess:    one velocity in one frame: LOCAL, WORLD or LOCAL_WORLD_ALIGNED, as Pinocchio has it, whose SE3 this class takes.
# Means:    read as any of the three, the reference of a foot or pelvis that turns is wrong, by as much as it is turned: a foot that is
#           toed out or pitched is told to turn about another axis. A foot that only pitches, from an upright stance, is right as
#           LOCAL_WORLD_ALIGNED, so that tests pass. Turn the last three by the rotation of the curve for LOCAL_WORLD_ALIGNED.
# Seen:     a toed-out foot in swing: told (1.500 0.050 0.125 0.473 -3.297 -0.172) m/s and rad/s; its last three in the axes of the
#           world are (1.797 -2.769 -0.473), its first three in those of the foot (1.086 -0.645 0.821)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check ndcurves==2.3.0 scipy==1.17.1 numpy==2.4.6
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
from ndcurves import SE3Curve, piecewise_SE3
from scipy.linalg import logm
from scipy.spatial.transform import Rotation


def pose(place, *angles):
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = Rotation.from_euler("ZYX", angles, degrees=True).as_matrix(), place
    return made


# a foot that is toed out rolls from its toes to its heel while it swings
lift, land, stand = pose([0.0, 0.1, 0.0], 30, 50, 0), pose([0.6, 0.12, 0.05], 20, -25, 10), pose([0.6, 0.12, 0.0], 20, 0, 0)
swing = SE3Curve(lift, land, 0.0, 0.4)
both = piecewise_SE3(swing)
both.append(stand, 0.5)


def velocities(curve, t, h=1e-6):
    """By finite differences of the poses: in the axes of the body, of the world at its origin, and of the world."""
    now = np.array(curve(t))
    step = np.real(logm(np.linalg.inv(np.array(curve(t - h))) @ np.array(curve(t + h)))) / (2 * h)
    local = np.concatenate([step[:3, 3], [step[2, 1], step[0, 2], step[1, 0]]])
    turned = np.kron(np.eye(2), now[:3, :3]) @ local
    return local, turned, np.concatenate([turned[:3] + np.cross(now[:3, 3], turned[3:]), turned[3:]])


for name, curve, t in (("swing", swing, 0.1), ("swing, piecewise", both, 0.1), ("to a stand, piecewise", both, 0.45)):
    told = np.ravel(curve.derivate(t, 1))
    local, aligned, world = velocities(curve, t)
    apart = [np.linalg.norm(told - each) for each in (local, aligned, world)]
    print(f"{name}: told {told.round(3)}, LOCAL {local.round(3)}, LOCAL_WORLD_ALIGNED {aligned.round(3)}, WORLD {world.round(3)}")
    assert np.allclose(told[:3], aligned[:3], atol=1e-6) and np.allclose(told[3:], local[3:], atol=1e-6)
    assert min(apart) > 0.1
    turned = np.concatenate([told[:3], np.array(curve(t))[:3, :3] @ told[3:]])
    assert np.allclose(turned, aligned, atol=1e-6)
straight = SE3Curve(pose([0, 0, 0], 0, 0, 0), pose([0.6, 0, 0], 0, 40, 0), 0.0, 0.4)  # one axis: all the same but the place
told, (_, aligned, _) = np.ravel(straight.derivate(0.2, 1)), velocities(straight, 0.2)
assert np.allclose(told, aligned, atol=1e-6)
PY
