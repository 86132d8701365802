#!/usr/bin/env bash
# Version:  drake 1.51.1, mujoco 4.0.0 to compare, dm-control 1.0.50 (its humanoid)
# Does:     where an MJCF body has several hinges, Drake's parser leaves the last one in its place and puts the others
#           into the origin of the parent body: the pos (and the turn) of the body is added behind them, to the last
#           hinge alone. A thigh placed beside the pelvis swings about the pelvis' middle. None of the warnings says
#           so. A body with one hinge is read well, and at angles of zero every body is in its place.
# Guess:    all hinges of a body turn about points of that body, as in MuJoCo; a parser that takes several of them
#           takes them as they are.
# Means:    hips, ankles and waists of MuJoCo's humanoids are two or three hinges of a body. Their legs look right in
#           the rest posture; the mass matrix is another robot's already there, and feet go elsewhere as the hips
#           turn. Give each hinge a body of its own before Drake reads the file.
# Seen:     a rod's inertia about the first of two hinges 1.318 for 0.118 kg·m²; its hip, which should stay, moves by 0.299 m;
#           humanoid: right foot off by 0.0299 m after 0.3 rad of hip_z, by 0.0000 after hip_y, the last one
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
pip="$work/env/bin/pip install --quiet --disable-pip-version-check"
$pip drake==1.51.1 mujoco==4.0.0
$pip --no-deps dm-control==1.0.50
"$work/env/bin/python" - 2>/dev/null <<'PY'
import importlib.util
import pathlib
import re

import mujoco
import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant


def read(text):
    model = mujoco.MjModel.from_xml_string(text)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "xml")
    plant.Finalize()
    return model, mujoco.MjData(model), plant, plant.CreateDefaultContext()


HINGES = '<joint name="flex" axis="0 1 0"/><joint name="abduct" axis="1 0 0"/>'
ROD = '<geom type="capsule" size=".05" fromto="0 0 0 0 0 -.4" mass="2"/>'
THIGH = f'<body name="thigh" pos="0 .3 1">{{}}{ROD}</body>'
inertia, moved = {}, {}
for name, joints in {"one": HINGES.split("/>")[0] + "/>", "two": HINGES}.items():
    text = f'<mujoco model="leg"><worldbody>{THIGH.format(joints)}</worldbody></mujoco>'
    model, data, plant, context = read(text)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, mass)
    inertia[name] = (plant.CalcMassMatrix(context)[0, 0], mass[0, 0])
    data.qpos[0] = 0.3
    mujoco.mj_forward(model, data)
    plant.GetJointByName("flex").set_angle(context, 0.3)
    place = plant.GetBodyByName("thigh").EvalPoseInWorld(context).translation()
    moved[name] = [float(np.linalg.norm(at - [0, 0.3, 1])) for at in (place, data.body("thigh").xpos)]
    print(f"{name} hinge(s): inertia about the first {inertia[name][0]:.4f} (MuJoCo {inertia[name][1]:.4f}),"
          f" the hip moves by {moved[name][0]:.4f} m (MuJoCo {moved[name][1]:.4f})")
assert np.isclose(*inertia["one"], rtol=1e-6) and max(moved["one"]) < 1e-9
# by hand: the hip is on both axes and stays; about the parent's origin, 1 m lower, it draws a chord
assert moved["two"][1] < 1e-9 and np.isclose(moved["two"][0], 2 * np.sin(0.15), atol=1e-6)
steiner = 2.0 * (0.8**2 - 0.2**2)  # the rod's middle is 0.2 m below the hip and 0.8 m above the origin
assert np.isclose(inertia["two"][0], inertia["two"][1] + steiner, rtol=1e-6)

path = pathlib.Path(importlib.util.find_spec("dm_control").submodule_search_locations[0], "suite/humanoid.xml")
text = re.sub(r'<include[^>]*>| material="[^"]*"', "", path.read_text())
model, data, plant, context = read(text)
frames = [plant.GetFrameByName(name) for name in ("pelvis", "right_foot")]
off = {}
for joint, angle in (("right_hip_x", 0.2), ("right_hip_z", 0.3), ("right_hip_y", -0.5)):
    data.joint(joint).qpos[:] = angle
    plant.GetJointByName(joint).set_angle(context, angle)
    mujoco.mj_kinematics(model, data)
    turn = data.body("pelvis").xmat.reshape(3, 3)
    foot = turn.T @ (data.body("right_foot").xpos - data.body("pelvis").xpos)
    off[joint] = float(np.linalg.norm(plant.CalcRelativeTransform(context, *frames).translation() - foot))
    data.joint(joint).qpos[:] = 0.0
    plant.GetJointByName(joint).set_angle(context, 0.0)
    print(f"humanoid, {joint} {angle}: right foot off by {off[joint]:.4f} m")
assert 0.02 < off["right_hip_x"] < 0.023 and 0.029 < off["right_hip_z"] < 0.031 and off["right_hip_y"] < 1e-6
PY
