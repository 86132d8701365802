#!/usr/bin/env bash
# Version:  example-robot-data 6.0.0 (human.urdf; talos_reduced.urdf and talos_reduced_corrected.urdf), pin 4.1.0
# Does:     the centres of mass of the person's limbs were copied from one side to the other, digit by digit, not mirrored:
#           both thighs have theirs 14 mm to the right of the hip, inside the left leg and outside the right one, both
#           clavicles 54 mm to the right of the breastbone, and no limb has its mirror image. Places, axes and masses
#           are mirrored. The hips may turn at 12 rad/s on the left and 6 on the right, the foot roll at 2 and 6,
#           the wrist give 185 and 100 N·m. The arms of Talos are copied likewise, from the second link to the sixth, in
#           the corrected file, too; talos_full_v2.urdf has mirrored them.
# Guess:    a person's model is its own mirror image, or as unlike as a person is.
# Means:    on one leg the hip holds the body by 61 N·m on the left and 59 on the right; a walk optimised for half a
#           stride and mirrored is none of this body's, and one for a whole stride limps. Talos holds its straight
#           arms at the second joint by 0.12 and 0.04 N·m. Mirror the centres before use.
# Seen:     thighs, shanks, feet, clavicles, upper and lower arms and hands off their mirror images by 28, 6, 10, 108, 14, 8,
#           28 mm; hip on one leg 61.4 and 58.8 N·m; hanging legs 1.4 N·m to the right both; Talos' forearm off by 42 mm
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" example-robot-data==6.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

(file,) = Path("robots").rglob("human_description/robots/human.urdf")
root = ET.parse(file).getroot()
model = pin.buildModelFromUrdf(str(file))
data = model.createData()
MIRROR = np.diag([1.0, 1.0, -1.0])  # x is ahead, y up, z to the right

centres, joints = {}, {}
for link in root.iter("link"):
    inertial = link.find("inertial")
    if inertial is not None:
        origin = inertial.find("origin")
        centres[link.get("name")] = np.array([float(x) for x in origin.get("xyz").split()])
for joint in root.iter("joint"):
    limit = joint.find("limit")
    if limit is not None:
        joints[joint.get("name")] = float(limit.get("effort")), float(limit.get("velocity"))

limbs = [name[5:] for name in centres if name.startswith("left_")]
assert set(limbs) == {"upperleg", "lowerleg", "foot", "clavicle", "upperarm", "lowerarm", "hand"}
for limb in limbs:
    left, right = centres["left_" + limb], centres["right_" + limb]
    apart = np.linalg.norm(MIRROR @ left - right)
    print(limb, "left", left, "right", right, f"off its mirror image by {1e3 * apart:.1f} mm")
    assert np.array_equal(left, right) and np.isclose(apart, 2 * abs(left[2]))
assert np.isclose(centres["left_upperleg"][2], 0.014) and centres["left_clavicle"][2] > 0.054

unlike = {}
for name, limits in joints.items():
    if name.startswith("left_") and limits != joints["right_" + name[5:]]:
        unlike[name[5:]] = limits, joints["right_" + name[5:]]
        print(name, "effort, velocity", limits, "right", joints["right_" + name[5:]])
assert unlike == {
    "hip_X": ((120.0, 12.0), (120.0, 6.0)),
    "hip_Y": ((60.0, 12.0), (60.0, 6.0)),
    "ankle_X": ((20.0, 2.0), (20.0, 6.0)),
    "wrist_Z": ((185.0, 25.0), (100.0, 25.0)),
}

# Joints are mirrored: places and axes (an axis is mirrored with the other sign).
q = pin.neutral(model)
pin.forwardKinematics(model, data, q)
pin.computeJointJacobians(model, data, q)
for name in joints:
    if name.startswith("left_"):
        left, right = (data.oMi[model.getJointId(side + name[4:])].translation for side in ("left", "right"))
        assert np.allclose(MIRROR @ left, right, atol=1e-6)
        one, other = (data.J[:, model.joints[model.getJointId(side + name[4:])].idx_v] for side in ("left", "right"))
        assert np.allclose(-MIRROR @ one[3:], other[3:], atol=1e-6)

# On one leg: the weight of all else about the hip of the leg that stands [N m].
held = {}
for side in ("left", "right"):
    leg = set(model.subtrees[model.getJointId(side + "_hip_Z")])
    hip = data.oMi[model.getJointId(side + "_hip_X")].translation[2]
    rest = [joint for joint in range(model.njoints) if joint not in leg]
    lever = sum(model.inertias[j].mass * (data.oMi[j].act(model.inertias[j].lever)[2] - hip) for j in rest)
    held[side] = 9.81 * abs(lever)
print("hip of the leg that stands:", held)
assert np.isclose(held["left"], 61.44, atol=0.05) and np.isclose(held["right"], 58.76, atol=0.05)

model.gravity.linear = np.array([0.0, -9.81, 0.0])
torque = pin.computeGeneralizedGravity(model, data, q)
hang = [torque[model.joints[model.getJointId(side + "_hip_X")].idx_v] for side in ("left", "right")]
print("hanging legs, about the axes x and -x [N m]:", np.round(hang, 3))
assert np.allclose(hang, [-1.416, 1.416], atol=2e-3)  # of mirrored legs both would have one sign


def arms(name):
    """The centres of mass of both arms of Talos, joint by joint, in the axes of the trunk from each joint."""
    (path,) = Path("robots").rglob(f"talos_data/robots/{name}.urdf")
    robot = pin.buildModelFromUrdf(str(path))
    state = robot.createData()
    pin.forwardKinematics(robot, state, pin.neutral(robot))
    sides = []
    for side in ("left", "right"):
        indices = [robot.getJointId(f"arm_{side}_{number}_joint") for number in range(1, 8)]
        sides.append(np.array([state.oMi[i].rotation @ robot.inertias[i].lever for i in indices]))
    weight = pin.computeGeneralizedGravity(robot, state, pin.neutral(robot))
    second = [weight[robot.joints[robot.getJointId(f"arm_{side}_2_joint")].idx_v] for side in ("left", "right")]
    return *sides, np.array(second)


for name in ("talos_reduced", "talos_reduced_corrected", "talos_full_v2"):
    left, right, second = arms(name)
    copied = np.linalg.norm(left - right, axis=1) < 1e-6
    apart = 1e3 * np.linalg.norm(left * [1, -1, 1] - right, axis=1)
    print(name, "copied:", copied, "off mirror images [mm]:", apart.round(1), "second joint [N m]:", second.round(4))
    if name == "talos_full_v2":
        assert not copied.any() and apart[:6].max() < 0.1 and np.isclose(*np.abs(second), atol=1e-3)
    else:
        assert list(copied) == [False, True, True, True, True, True, False] and 42 < apart[3] < 43
        assert np.allclose(np.abs(second), [0.1182, 0.0357], atol=1e-3)
PY
