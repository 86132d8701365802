#!/usr/bin/env bash
# Version:  adam-robotics 0.5.0, mujoco 4.0.0
# Does:     KinDynComputations.from_mujoco_model adds the place of a hinge in its body (pos) to the
#           offset of the body, where it stays: the shin hangs lower by it. The angle at
#           which the file is drawn (ref) is taken as turned by that much. Nothing says either.
# Guess:    pos is where the body turns and ref how its angle is counted; at the drawn posture
#           bodies are where the file puts them.
# Means:    legs are longer than the robot's, and masses lie elsewhere; files whose hinges are in the
#           origins of their bodies, with ref 0, are read well.
# Seen:     ankle 0.850 m below the hip (MuJoCo 0.800) with a knee of pos 0.05 m; with ref 20 degrees the
#           shin is 0.257 m behind the hip at the drawn posture (MuJoCo 0.137); without both equal to 1e-12
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check adam-robotics==0.5.0 mujoco==4.0.0
cd "$work"
cat > leg.py <<'PY'
def leg(knee="", hip="", tilt="0"):
    return f"""
<mujoco model="leg">
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.1 0.15 0.2" mass="30"/>
      <body name="thigh" euler="0 {tilt} 0">
        <joint name="hip" axis="0 1 0" {hip}/>
        <geom type="box" size="0.05 0.05 0.2" pos="0 0 -0.2" mass="5"/>
        <body name="shin" pos="0 0 -0.4">
          <joint name="knee" axis="0 1 0" {knee}/>
          <geom type="box" size="0.04 0.04 0.2" pos="0 0 -0.2" mass="3"/>
          <body name="foot" pos="0 0 -0.4">
            <joint name="ankle" axis="0 1 0"/>
            <geom type="box" size="0.1 0.05 0.02" mass="1"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""
PY
"$work/env/bin/python" 2>/dev/null <<'PY'
import mujoco
import numpy as np
from adam.numpy import KinDynComputations
from leg import leg


def places(text, body):
    """Return where a body is beside the trunk at the drawn posture: as read, and in MuJoCo."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    robot = KinDynComputations.from_mujoco_model(model)
    pose = robot.forward_kinematics(body, np.eye(4), model.qpos0[7:])
    return np.asarray(pose)[:3, 3], data.body(body).xpos - data.body("trunk").xpos


read, right = places(leg(), "foot")
print(f"plain: foot at {read} (MuJoCo {right})")
assert np.allclose(read, right, atol=1e-12)
read, right = places(leg(knee='pos="0 0 -0.05"'), "foot")
print(f"knee with pos: foot at z = {read[2]:.3f} m (MuJoCo {right[2]:.3f})")
assert np.isclose(read[2], -0.85) and np.isclose(right[2], -0.8)
read, right = places(leg(hip='ref="20"', tilt="20"), "shin")
print(f"hip with ref: shin at x = {read[0]:.3f} m (MuJoCo {right[0]:.3f})")
assert np.isclose(right[0], -0.4 * np.sin(np.radians(20)))
assert np.isclose(read[0], -0.4 * np.sin(np.radians(40)))
PY
