#!/usr/bin/env bash
# Version:  pin 4.1.0
# Does:     appendModel joins two models and keeps damping, dry friction, rotor inertia and limits of
#           the joints of both, but the armature of every joint of the result is zero, also that of
#           the model that was appended to.
# Guess:    armature is kept like everything else about a joint; buildReducedModel keeps it.
# Means:    a humanoid put together from legs and trunk loses its reflected motor inertia. A leg's
#           mass matrix changes by the whole armature, without a word.
# Seen:     armature [0.1 0.2] + [0.1 0.2] -> [0. 0. 0. 0.]; damping [1. 2. 1. 2.]
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/python" - <<'PY'
import numpy as np
import pinocchio as pin


def leg(prefix):
    model, joint = pin.Model(), 0
    for k in range(2):
        place = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.3 * k]))
        joint = model.addJoint(joint, pin.JointModelRY(), place, f"{prefix}{k}")
        model.addJointFrame(joint)
        model.appendBodyToJoint(joint, pin.Inertia.FromSphere(1.0, 0.1), pin.SE3.Identity())
    model.armature = np.array([0.1, 0.2])
    model.damping = np.array([1.0, 2.0])
    return model


both = pin.appendModel(leg("left"), leg("right"), 0, pin.SE3.Identity())
reduced = pin.buildReducedModel(leg("left"), [1], np.zeros(2))
print("armature after appendModel:", both.armature, " damping:", both.damping)
print("armature after buildReducedModel:", reduced.armature)
mass = pin.crba(both, both.createData(), np.zeros(4))
alone = pin.crba(leg("left"), leg("left").createData(), np.zeros(2))
print("first entry of the mass matrix: alone", alone[0, 0], "joined", mass[0, 0])
assert not both.armature.any() and np.allclose(both.damping, [1, 2, 1, 2])
assert np.allclose(reduced.armature, [0.2])
assert np.isclose(alone[0, 0] - mass[0, 0], 0.1)
PY
