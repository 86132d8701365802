#!/usr/bin/env bash
# Version:  urdf2casadi 1.2.0 with casadi 3.8.2, pin 4.1.0, iCubGenova04 of icub-models 3.2.0
# Does:     get_inertia_matrix_crba and get_inverse_dynamics_rnea take each tensor as if it were written in the axes of
#           its link: the rpy of <inertial> is read past, while its xyz counts. Gravity torques are right to the last
#           digit. Of the 39 links of this iCub 19 have tensors in turned axes.
# Guess:    expressions whose gravity agrees with another library to 1e-14 have read the masses and tensors.
# Means:    an optimiser in CasADi gets smooth, exact derivatives of another robot: its feet are half as hard again to
#           roll, its hips 11 % harder to yaw, its knees 3 % easier to bend. Nothing at rest shows it. Turn the
#           tensors into the axes of the links before such a file is read, and compare the mass matrix.
# Seen:     left leg of six joints, bent: inertia 0.4129, 0.3929, 0.0506, 0.0793, 0.0043, 0.0033 kg·m² from hip pitch to
#           ankle roll for 0.4199, 0.3906, 0.0457, 0.0819, 0.0042, 0.0022; ankle roll 51 % more;
#           gravity to 1e-12 N·m; from the same file with its tensors turned into the axes of the links all to 1e-10
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2 pin==4.1.0 urdf_parser_py==0.0.4
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps urdf2casadi==1.2.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/icub" icub-models==3.2.0
cd "$work"
"$work/env/bin/python" -W ignore - 2>errors.txt <<'PY' || { tail -n 3 errors.txt; exit 1; }
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
from urdf2casadi.urdfparser import URDFparser

ANGLES = {
    "l_hip_pitch": 0.5,
    "l_hip_roll": 0.1,
    "l_hip_yaw": -0.2,
    "l_knee": -0.9,
    "l_ankle_pitch": -0.4,
    "l_ankle_roll": 0.1,
}
DOWN = [0.0, 0.0, -9.81]


def turn_tensors(source, target):
    """Write the robot with each tensor in the axes of its link; say how many changed."""
    tree, changed = ET.parse(source), 0
    for inertial in tree.getroot().iter("inertial"):
        origin, entry = inertial.find("origin"), inertial.find("inertia").attrib
        tensor = np.array([[float(entry["i" + "".join(sorted(a + b))]) for a in "xyz"] for b in "xyz"])
        rotation = pin.rpy.rpyToMatrix(*map(float, origin.get("rpy").split()))
        turned = rotation @ tensor @ rotation.T
        changed += not np.allclose(turned, tensor, rtol=0.01, atol=0.0)
        for j, a in enumerate("xyz"):
            for k, b in enumerate("xyz"):
                if j <= k:
                    entry["i" + a + b] = f"{turned[j, k]:.17g}"
        origin.set("rpy", "0 0 0")
    tree.write(target)
    return changed, len(list(tree.getroot().iter("inertial")))


def by_casadi(file):
    parser, q = URDFparser(), np.array(list(ANGLES.values()))
    parser.from_file(str(file))
    chain = "root_link", "l_sole"
    motion = parser.get_inverse_dynamics_rnea(*chain, gravity=DOWN)(q, 0.0 * q, 0.0 * q + 1.0)
    mass = np.array(parser.get_inertia_matrix_crba(*chain)(q))
    return mass, np.array(parser.get_gravity_rnea(*chain, DOWN)(q)).ravel(), np.array(motion).ravel()


def by_pinocchio(file):
    model = pin.buildModelFromUrdf(str(file))
    joints = [model.joints[model.getJointId(name)] for name in ANGLES]
    q, acceleration, at = pin.neutral(model), np.zeros(model.nv), [joint.idx_v for joint in joints]
    for joint, angle in zip(joints, ANGLES.values(), strict=True):
        q[joint.idx_q] = angle
    acceleration[at] = 1.0
    data = model.createData()
    gravity = pin.computeGeneralizedGravity(model, data, q)[at]
    motion = pin.rnea(model, data, q, 0.0 * acceleration, acceleration)[at]
    full = pin.crba(model, model.createData(), q)
    return (np.triu(full) + np.triu(full, 1).T)[np.ix_(at, at)], gravity, motion


(file,) = Path("icub").rglob("iCubGenova04/model.urdf")
changed, links = turn_tensors(file, "turned.urdf")
print(f"{changed} of {links} links have a tensor in turned axes")
truth = by_pinocchio(file)
assert all(np.allclose(a, b, atol=1e-12) for a, b in zip(truth, by_pinocchio("turned.urdf"), strict=True))
mass, gravity, motion = by_casadi(file)
ratio = mass.diagonal() / truth[0].diagonal()
print("inertia of the joints", mass.diagonal().round(4), "for", truth[0].diagonal().round(4))
print("ratio", ratio.round(3), "gravity off by", np.abs(gravity - truth[1]).max())
print("torques of 1 rad/s2 at each joint", motion.round(3), "for", truth[2].round(3))
assert np.allclose(gravity, truth[1], atol=1e-12)
assert np.allclose(ratio, [0.983, 1.006, 1.108, 0.969, 1.038, 1.512], atol=2e-3)
assert not np.allclose(motion, truth[2], atol=1e-4)
assert all(np.allclose(a, b, atol=1e-10) for a, b in zip(by_casadi("turned.urdf"), truth, strict=True))
assert (changed, links) == (19, 39)
PY
