#!/usr/bin/env bash
# Version:  mjcf-urdf-simple-converter 0.7.3, mujoco 4.0.0, pin 4.1.0
# Does:     of an MJCF body with three hinges at three places the third is written at its place less the places of both
#           before it, where it should be less that of the second: the leg hangs lower by the first one's place.
#           A hinge without a range gets a range of 0 to 0, so the URDF locks it, and every joint may give
#           100 N·m. The zero of a knee drawn bent (ref) is moved to the drawn posture, its range is not.
# Guess:    kinematics are what this converter promises; a hinge that turns freely becomes "continuous", or says so.
# Means:    a humanoid whose hip is one body with three hinges, MuJoCo's usual way, gets longer legs or limbs
#           elsewhere; with two hinges of a body, or with all places 0, it is right. A reader that keeps limits
#           never turns the hip's yaw. Compare the feet of both files in a bent posture.
# Seen:     hinges at 0.05, 0.03 and -0.02 m up: shin 0.55 m below the trunk for 0.50; with two of them 0.50; yaw 0 to 0
#           for no range; 100 N·m for 300 (actuatorfrcrange), for 80 (gear 10 times 8) and for no limit;
#           knee of ref -0.5 rad and range -2 to 0, drawn straight: straight at 0 for -0.5, still -2 to 0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mjcf-urdf-simple-converter==0.7.3 \
  mujoco==4.0.0 pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
from mjcf_urdf_simple_converter import convert

ROBOT = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk">
      <geom type="box" size="0.1 0.1 0.2" mass="10"/>
      <body name="thigh" pos="0 0.1 -0.1">
        {yaw}
        <joint name="roll" axis="1 0 0" pos="0 0 0.03" range="-1 1" actuatorfrcrange="-300 300"/>
        <joint name="pitch" axis="0 1 0" pos="0 0 -0.02" range="-1 2"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="3"/>
        <body name="shin" pos="0 0 -0.4">
          <joint name="knee" axis="0 1 0" range="-2 0" {ref}/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03" mass="2"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="knee" gear="10" forcerange="-8 8"/></actuator>
</mujoco>"""
YAW = '<joint name="yaw" axis="0 0 1" pos="0 0 {place}"/>'


def shins(text, angles):
    """Where the shin is from the trunk in MuJoCo and in the converted file, and that file's limits."""
    Path("robot.xml").write_text(text)
    convert("robot.xml", "robot.urdf")
    model = mujoco.MjModel.from_xml_path("robot.xml")
    data = mujoco.MjData(model)
    robot = pin.buildModelFromUrdf("robot.urdf")
    state = robot.createData()
    q = pin.neutral(robot)
    for name, angle in angles.items():
        data.qpos[model.joint(name).qposadr[0]] = angle
        q[robot.joints[robot.getJointId(name)].idx_q] = angle
    mujoco.mj_kinematics(model, data)
    pin.framesForwardKinematics(robot, state, q)
    limits = {}
    for joint in ET.parse("robot.urdf").getroot().iter("joint"):
        if joint.find("limit") is not None:
            limits[joint.get("name")] = [float(joint.find("limit").get(key)) for key in ("lower", "upper", "effort")]
    trunk, shin = (state.oMf[robot.getFrameId(name)] for name in ("trunk", "shin"))
    back = data.body("trunk").xmat.reshape(3, 3).T @ data.body("shin").xmat.reshape(3, 3)
    return (
        data.body("shin").xpos - data.body("trunk").xpos,
        shin.translation - trunk.translation,
        back,
        shin.rotation,
        limits,
    )


straight = dict.fromkeys(("roll", "pitch", "knee"), 0.0)
bent = {"roll": 0.4, "pitch": 0.5, "knee": -0.7}
for label, yaw, pose, apart in (
    ("two hinges", "", bent, 0.0),
    ("three hinges, the first in the origin", YAW.format(place=0), {"yaw": 0.3, **bent}, 0.0),
    ("three hinges at three places, straight", YAW.format(place=0.05), {"yaw": 0.0, **straight}, 0.05),
    ("three hinges at three places, bent", YAW.format(place=0.05), {"yaw": 0.3, **bent}, 0.05),
):
    right, found, turned, turn, limits = shins(ROBOT.format(yaw=yaw, ref=""), pose)
    print(f"{label}: shin at {right.round(4)} in MuJoCo, {found.round(4)} in the URDF")
    assert np.isclose(np.linalg.norm(right - found), apart, atol=1e-6) and np.allclose(turned, turn, atol=1e-6)
print("limits:", limits)
assert limits == {"yaw": [0, 0, 100], "roll": [-1, 1, 100], "pitch": [-1, 2, 100], "knee": [-2, 0, 100]}

right, found, turned, turn, limits = shins(ROBOT.format(yaw="", ref='ref="-0.5"'), {**straight, "knee": -0.5})
angle = np.arccos(np.clip((np.trace(turn.T @ turned) - 1) / 2, -1, 1))
print(f"knee drawn straight with ref -0.5, at -0.5: turned by {angle:.3f} rad against MuJoCo; range {limits['knee'][:2]}")
assert np.isclose(angle, 0.5) and limits["knee"][:2] == [-2, 0] and np.allclose(turned, np.eye(3))
PY
