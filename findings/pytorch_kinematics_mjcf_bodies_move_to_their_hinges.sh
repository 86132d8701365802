#!/usr/bin/env bash
# Version:  pytorch-kinematics 0.10.0 (torch 2.14.1), mujoco 3.3.7 to compare (with MuJoCo 4 joints are refused)
# Does:     of an MJCF body whose joint does not sit in its origin, build_chain_from_mjcf puts the origin into the joint: the body and
#           all below it stand off by `pos` of the joint, at zero angles already, and turn about the wrong place. `ref`, the angle at
#           which the file draws the joint, is left out. Joints in the origin without ref are right.
# Guess:    frames where MuJoCo, which reads the file for it, has them; several joints in a body are refused in words.
# Means:    feet, Jacobians and inverse kinematics of legs whose knees are written with a place are off by centimetres. Compare one
#           forward_kinematics with MuJoCo's xpos at a bent posture, or hand it a URDF.
# Seen:     hip 0.2 m above the origin of its thigh: thigh and shin 0.2 m too high at zero and 0.2 m off bent; ref 0.5: the
#           shin as at 0.5 rad where it should be at 0, 0.2 m off
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pytorch-kinematics==0.10.0 torch==2.14.1 mujoco==3.3.7
cd "$work"
"$work/env/bin/python" -W ignore - 2>/dev/null <<'PY'
import mujoco
import numpy as np
import pytorch_kinematics
import torch

torch.set_default_dtype(torch.float64)
ROD = '<geom type="capsule" size=".05" fromto="0 0 0 0 0 -.4" mass="2"/>'
LEG = f"""<mujoco><compiler angle="radian"/><worldbody><body name="thigh" pos=".02 .1 1" euler=".1 .2 .3">
<joint name="hip" axis="0 1 0" {{}}/>{ROD}<body name="shin" pos=".01 .02 -.4"><joint name="knee" axis="0 .6 .8"/>{ROD}</body>
</body></worldbody></mujoco>"""
off = {}
for name, hip in (("in the origin", ""), ("above it", 'pos="0 0 .2"'), ("drawn at 0.5 rad", 'ref=".5"')):
    model = mujoco.MjModel.from_xml_string(LEG.format(hip))
    data = mujoco.MjData(model)
    chain = pytorch_kinematics.build_chain_from_mjcf(LEG.format(hip)).to(dtype=torch.float64)
    assert chain.get_joint_parameter_names() == ["hip", "knee"]
    off[name] = []
    for angles in (np.zeros(2), np.array([0.5, 0.3])):
        data.qpos[:] = angles
        mujoco.mj_forward(model, data)
        frames = chain.forward_kinematics(torch.tensor(angles))
        off[name].append(np.linalg.norm(frames["shin"].get_matrix()[0, :3, 3].numpy() - data.body("shin").xpos))
    print(f"hip {name}: shin {off[name][0]:.3f} m off at zero, {off[name][1]:.3f} m off bent")
assert max(off["in the origin"]) < 1e-6
assert np.isclose(off["above it"][0], 0.2, atol=1e-6) and min(off["drawn at 0.5 rad"]) > 0.18
PY
