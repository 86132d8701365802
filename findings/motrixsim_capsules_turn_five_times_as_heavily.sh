#!/usr/bin/env bash
# Version:  motrixsim 0.10.1 (with motrixsim-core 0.10.1), mujoco 4.0.0 and trimesh 5.2.0 to compare
# Does:     a body whose inertia follows from its shapes has the mass that MuJoCo gives it, and, where the shape is a capsule,
#           other moments: 0.9 m r² about its length, which is a solid cylinder's and a ball's of the whole mass
#           together, and five to six times the right one across it for limbs of usual proportions. Cylinder, ball,
#           ellipsoid and box are right, and so is <inertial>. Attributes it cannot read are warned of; of this nothing is said.
# Guess:    an engine that reads another's format gives its most usual limb the moments that the format asks for.
# Means:    humanoids of MuJoCo, dm_control and Gymnasium are made of capsules: their legs swing as slowly as if they were
#           twice as long, while masses and gravity torques compare well. A gait or a policy tuned there is for that
#           robot. Write <inertial>, from MuJoCo's numbers, before such a file is read. No report was found.
# Seen:     radius 50 mm, 300 mm between the caps, 2 kg: 0.1195, 0.1195, 0.0045 kg·m² for 0.0239, 0.0239, 0.0024 (MuJoCo, and the
#           mesh by trimesh); 30 mm and 400 mm: 0.1968 for 0.0328; a leg of two
#           such capsules released: hip -2.5, knee -13.7 for 2.1 and -38.0 rad/s²; with cylinders and with <inertial> alike
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check motrixsim==0.10.1 motrixsim-core==0.10.1 mujoco==4.0.0 \
  trimesh==5.2.0 scipy==1.17.1 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import motrixsim
import mujoco
import numpy as np
import trimesh

BODY = """<mujoco><worldbody><body name="thigh"><joint name="hip" axis="0 1 0"/><geom type="{}" size="{}" mass="2"/>
</body></worldbody></mujoco>"""


def moments(text):
    Path("body.xml").write_text(text)
    model = motrixsim.load_model("body.xml")
    link = model.links[0]
    mine = np.asarray(link.get_inertia_override(motrixsim.SceneData(model)))
    theirs = mujoco.MjModel.from_xml_string(text)
    assert abs(link.mass - theirs.body_mass[1]) < 1e-6
    return mine[:3], theirs.body_inertia[1]


for kind, size in (("box", ".05 .1 .2"), ("sphere", ".05"), ("ellipsoid", ".05 .15 .1"), ("cylinder", ".05 .15")):
    mine, theirs = moments(BODY.format(kind, size))
    print(f"{kind}: {mine.round(4)} MotrixSim, {theirs.round(4)} MuJoCo")
    assert np.allclose(mine, theirs, rtol=1e-5), kind
for radius, half in ((0.05, 0.15), (0.03, 0.2)):
    mine, theirs = moments(BODY.format("capsule", f"{radius} {half}"))
    mesh = trimesh.creation.capsule(2 * half, radius, count=[128, 128])
    by_mesh = mesh.moment_inertia.diagonal() * 2 / mesh.mass
    print(f"capsule: {mine.round(4)} MotrixSim, {theirs.round(4)} MuJoCo, {by_mesh.round(4)} trimesh")
    assert np.allclose(theirs, by_mesh, rtol=5e-3)
    assert np.allclose(mine[2], 0.9 * 2 * radius**2, rtol=1e-4)
    assert 4.9 < mine[0] / theirs[0] < 6.1 and mine[2] > 1.8 * theirs[2]

LEG = """<mujoco><option timestep="0.0001"/><worldbody><body name="thigh"><joint name="hip" axis="0 1 0"/>{}
<body name="shin" pos="0 0 -0.4"><joint name="knee" axis="0 1 0"/>{}</body></body></worldbody></mujoco>"""


def falls(geom):
    text = LEG.format(geom, geom)
    Path("leg.xml").write_text(text)
    start = np.array([0.3, 0.9])
    ours = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(ours)
    data.qpos = start
    mujoco.mj_step(ours, data)
    model = motrixsim.load_model("leg.xml")
    scene = motrixsim.SceneData(model)
    scene.set_dof_pos(start.astype(np.float32), model)
    model.step(scene)
    return np.asarray(scene.dof_vel, float) / 1e-4, data.qvel / 1e-4


at = 'pos="0.02 0 -0.2" mass="2" contype="0" conaffinity="0"'
inertial = '<inertial pos="0.02 0 -0.2" mass="2" diaginertia="0.0239 0.0239 0.0024"/>'
for name, geom, same in (("capsule", f'<geom type="capsule" size="0.05 0.15" {at}/>', False),
                         ("cylinder", f'<geom type="cylinder" size="0.05 0.15" {at}/>', True),
                         ("<inertial>", inertial + f'<geom type="capsule" size="0.05 0.15" {at}/>', True)):
    mine, theirs = falls(geom)
    print(f"leg of {name}: {mine.round(2)} rad/s² MotrixSim, {theirs.round(2)} MuJoCo")
    assert np.allclose(mine, theirs, rtol=0.01, atol=0.05) == same, name
    if not same:
        assert abs(mine[1]) < 0.6 * abs(theirs[1])
PY
