#!/usr/bin/env bash
# Version:  pin 4.1.0 (Pinocchio)
# Does:     pinocchio.graph (new in 4) builds a robot from bodies and joints, from any of its bodies as root. A joint has a
#           pose in both of its bodies. Frames of the built model respect both; the inertia of each body, except
#           the root, is left in the axes of the joint, without the pose of the joint in the body. Total mass is
#           right, and so is every placement and velocity. Nothing is said.
# Guess:    as its documentation says: a body keeps its frame in the model, so that its inertia remains valid if a joint is
#           reversed; a robot weighs alike from whichever body it is built.
# Means:    the feature is there to re-root a leg at the foot. From the foot, each limb has its centre of mass in another
#           place than from the trunk: torques, mass matrix and centre of mass are those of another robot, while
#           pictures and feet coincide. Only joints in the origins of their bodies, and the root, are read well; compare the
#           centre of mass from two roots. No report was found.
# Seen:     trunk, thigh of 5 kg and shin of 3 kg, bent by 0.4 and 0.9 rad: frames in one place to 1e-15 from all three roots.
#           Frames in the middle of the limbs, as CAD has them: centre of mass off by 0.088, 0.028 and 0.109 m from trunk,
#           thigh and shin; frames in the upper joints, as URDF has them: off by 0, 0.056 and 0.109 m
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin
from pinocchio import graph

BODIES = {  # mass [kg], centre of mass in the body's own axes [m]
    "trunk": (10.0, np.array([0.0, 0.02, 0.15])),
    "thigh": (5.0, np.array([0.03, 0.0, 0.02])),
    "shin": (3.0, np.array([0.01, 0.0, -0.03])),
}
BEND = {"hip": 0.4, "knee": -0.9}


def place(*xyz):
    return pin.SE3(np.eye(3), np.array(xyz))


def turn(angle):
    return pin.SE3(pin.exp3(np.array([0.0, angle, 0.0])), np.zeros(3))


def built(root, to_thigh, to_shin):
    """Centre of mass and the points of interest in the axes of the trunk, of the model that is built from `root` [m]."""
    parts = graph.ModelGraph()
    for name, (mass, centre) in BODIES.items():
        parts.addBody(name, pin.Inertia(mass, centre, np.diag([0.03, 0.04, 0.02])))
    hinge = graph.JointRevolute(np.array([0.0, 1.0, 0.0]))
    parts.addJoint("hip", hinge, "trunk", place(0.0, 0.0, -0.1), "thigh", to_thigh)
    parts.addJoint("knee", hinge, "thigh", place(0.0, 0.0, -0.2), "shin", to_shin)
    upright, info = graph.buildModelWithBuildInfo(parts, "trunk", place(0, 0, 0), graph.JointFreeFlyer(), "root")
    model, other = graph.buildModelWithBuildInfo(parts, root, place(0, 0, 0), graph.JointFreeFlyer(), "root")
    q = pin.neutral(upright)
    for joint, angle in BEND.items():
        q[upright.joints[upright.getJointId(joint)].idx_q] = angle
    q = graph.createConverter(upright, model, info, other).convertConfigurationVector(q)
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    frames = {name: data.oMf[model.getFrameId(name)] for name in BODIES}
    points = [frames["trunk"].actInv(frames[name].act(np.zeros(3))) for name in BODIES]
    assert np.isclose(pin.computeTotalMass(model), 18.0)
    return frames["trunk"].actInv(pin.centerOfMass(model, data, q)), np.array(points)


def by_hand(to_thigh, to_shin):
    thigh = place(0.0, 0.0, -0.1) * turn(BEND["hip"]) * to_thigh
    shin = thigh * place(0.0, 0.0, -0.2) * turn(BEND["knee"]) * to_shin
    where = dict(trunk=place(0, 0, 0), thigh=thigh, shin=shin)
    centre = sum(mass * where[name].act(one) for name, (mass, one) in BODIES.items()) / 18.0
    return centre, np.array([where[name].translation for name in BODIES])


# The frame of a limb in its middle, as a CAD program writes it, and in its upper joint, as URDF has it.
for title, to_thigh, to_shin in (("middle", place(0, 0, -0.2), place(0, 0, -0.25)), ("upper joint", place(0, 0, 0), place(0, 0, 0))):
    right, points = by_hand(to_thigh, to_shin)
    for root in BODIES:
        centre, found = built(root, to_thigh, to_shin)
        off = np.linalg.norm(centre - right)
        print(f"frames in the {title}, from the {root}: centre of mass off by {off:.4f} m, frames by {abs(found - points).max():.0e} m")
        assert np.allclose(found, points, atol=1e-12)
        assert (off < 1e-12) == (title == "upper joint" and root == "trunk") and (off < 1e-12 or off > 0.02)
PY
