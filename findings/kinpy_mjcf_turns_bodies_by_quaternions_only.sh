#!/usr/bin/env bash
# Version:  kinpy 0.6.1, mujoco 4.0.0
# Does:     build_chain_from_mjcf applies the orientation of a body that is written as quat, and leaves out the ones
#           written as euler, axisangle, xyaxes or zaxis: the body is upright. The file is parsed with its
#           schema, so the attribute is known, and nothing is said.
# Guess:    MJCF has five ways to say how a body is turned; what is accepted is applied.
# Means:    a hip that is tilted in the file stands straight and all below it is elsewhere: knee and foot off by 9 and
#           14 cm here for a thigh of 0.4 m and a turn of 21 degrees. Write every orientation as quat before such
#           a file is read, and compare one foot with MuJoCo's.
# Seen:     thigh turned by euler "0.1 -0.2 0.3", the same turn as axisangle, xyaxes and quat: shin off by 0.0870, foot
#           by 0.1435 m with the first three, by less than 1e-12 with quat; another turn as zaxis: foot off by 0.2243
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check kinpy==0.6.1 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
import kinpy
import mujoco
import numpy as np

LEG = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <geom type="sphere" size="0.1"/>
      <body name="thigh" pos="0 0.1 -0.05" TURN>
        <joint name="hip" type="hinge" axis="0 1 0"/>
        <geom type="sphere" size="0.05"/>
        <body name="shin" pos="0 0 -0.4">
          <joint name="knee" type="hinge" axis="0 1 0"/>
          <geom type="sphere" size="0.05"/>
          <body name="foot" pos="0.02 0.03 -0.35">
            <joint name="ankle" type="hinge" axis="0 1 0"/>
            <geom type="sphere" size="0.05"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""
ANGLES = {"hip": 0.4, "knee": -0.9, "ankle": 0.3}


def about(axis, angle):
    matrix = np.eye(3)
    j, k = [(1, 2), (2, 0), (0, 1)]["xyz".index(axis)]
    matrix[j, j] = matrix[k, k] = np.cos(angle)
    matrix[j, k], matrix[k, j] = -np.sin(angle), np.sin(angle)
    return matrix


def by_hand(turn):
    """Shin and foot in the world, hip about y after the turn of the thigh."""
    thigh = turn @ about("y", ANGLES["hip"])
    shin = np.array([0, 0.1, 0.95]) + thigh @ [0, 0, -0.4]
    return {"shin": shin, "foot": shin + thigh @ about("y", ANGLES["knee"]) @ [0.02, 0.03, -0.35]}


def errors(text, turn):
    """How far kinpy and MuJoCo put shin and foot from where the formula does [m]."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    for name, angle in ANGLES.items():
        data.joint(name).qpos[0] = angle
    mujoco.mj_kinematics(model, data)
    places = kinpy.build_chain_from_mjcf(text).forward_kinematics(ANGLES)
    truth = by_hand(turn)
    assert all(np.allclose(data.body(name).xpos, place, atol=1e-6) for name, place in truth.items())
    return {name: float(np.linalg.norm(np.ravel(places[name].pos) - place)) for name, place in truth.items()}


turn = about("x", 0.1) @ about("y", -0.2) @ about("z", 0.3)  # MuJoCo's "xyz": about the body's own axes
flat, quat = turn.ravel(), np.zeros(4)
mujoco.mju_mat2Quat(quat, flat)
angle = 2.0 * np.arccos(quat[0])
axis = quat[1:] / np.linalg.norm(quat[1:])


def line(*numbers):
    return " ".join(repr(float(number)) for number in numbers)


tilt = np.array([0.3, 0.1, 0.9]) / np.linalg.norm([0.3, 0.1, 0.9])
around = np.cross([0, 0, 1], tilt) / np.linalg.norm(np.cross([0, 0, 1], tilt))
leaning, half = np.zeros(9), np.arccos(tilt[2]) / 2
mujoco.mju_quat2Mat(leaning, np.r_[np.cos(half), np.sin(half) * around])
ways = {
    f'quat="{line(*quat)}"': turn,
    'euler="0.1 -0.2 0.3"': turn,
    f'axisangle="{line(*axis, angle)}"': turn,
    f'xyaxes="{line(*turn[:, 0], *turn[:, 1])}"': turn,
    f'zaxis="{line(*tilt)}"': leaning.reshape(3, 3),
}
off = {}
for text, truth in ways.items():
    way = text.split("=")[0]
    off[way] = errors(LEG.replace("TURN", text), truth)
    print(f"{way}: shin off by {off[way]['shin']:.4f} m, foot by {off[way]['foot']:.4f} m")
assert max(off["quat"].values()) < 1e-12
for way in ("euler", "axisangle", "xyaxes"):
    assert abs(off[way]["shin"] - 0.0870) < 1e-3 and abs(off[way]["foot"] - 0.1435) < 1e-3, way
assert off["zaxis"]["foot"] > 0.1
PY
