#!/usr/bin/env bash
# Version:  pin 4.1.0, mujoco 4.0.0
# Does:     a floating trunk that the MJCF file draws at a place p and turned by R is read with a joint
#           placed at p - R p: for the same coordinates, which both libraries take for the pose of the
#           trunk in the world, the whole robot stands that much elsewhere. Its orientation, masses and
#           mass matrix are right, and so is everything where the trunk is drawn upright or at the
#           origin. Nothing says so.
# Guess:    how a floating body is drawn is its starting pose and no more, as in MuJoCo.
# Means:    a robot drawn lying, leaning or looking to the side has its feet in the air or in the ground, and
#           contact points that no motion puts right. Draw it upright, or set jointPlacements[1] to the
#           identity after reading.
# Seen:     drawn 1 m high and rolled by 30 degrees: at coordinates 0 the trunk is at (0, 0.5, 0.134); drawn at
#           (1, 2, 0.8) and yawed by 90 degrees: at (3, 1, 0); upright, at the origin, or with the placement
#           reset: (0, 0, 0)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

ROBOT = """<mujoco><worldbody><body name="trunk" pos="{}" euler="{}"><freejoint/>
<geom type="box" size=".1 .2 .3" mass="20"/><body name="leg" pos="0 0 -.3">
<joint name="hip" axis="0 1 0"/><geom type="capsule" size=".05 .2" mass="4" pos="0 0 -.2"/>
</body></body></worldbody></mujoco>"""


def trunks(pos, euler):
    """Place of the trunk at coordinates 0 by MuJoCo, by Pinocchio and with the joint's placement reset."""
    Path("robot.xml").write_text(ROBOT.format(pos, euler))
    theirs = mujoco.MjModel.from_xml_path("robot.xml")
    data = mujoco.MjData(theirs)
    data.qpos[:] = [0, 0, 0, 1, 0, 0, 0, 0]
    mujoco.mj_forward(theirs, data)
    ours = pin.buildModelFromMJCF("robot.xml")
    ours = ours[0] if isinstance(ours, tuple) else ours
    theirs_full = np.zeros((theirs.nv, theirs.nv))
    mujoco.mj_fullM(theirs, data, theirs_full)
    upper = np.triu(pin.crba(ours, ours.createData(), pin.neutral(ours)))
    assert np.allclose(upper, np.triu(theirs_full))
    places = [data.body("trunk").xpos.copy()]
    for placement in (ours.jointPlacements[1].copy(), pin.SE3.Identity()):
        ours.jointPlacements[1] = placement
        own = ours.createData()
        pin.framesForwardKinematics(ours, own, pin.neutral(ours))
        pose = own.oMf[ours.getFrameId("trunk")]
        assert np.allclose(pose.rotation, data.body("trunk").xmat.reshape(3, 3))
        places.append(pose.translation.copy())
    return places


seen = {}
for pos, euler in (("0 0 1", "0 0 0"), ("0 0 1", "30 0 0"), ("1 2 0.8", "0 0 90"), ("0 0 0", "30 20 0")):
    seen[euler] = trunks(pos, euler)
    mine, theirs, reset = (place.round(3) + 0.0 for place in seen[euler])
    print(f"drawn at {pos}, turned {euler}: MuJoCo {mine}, Pinocchio {theirs}, reset {reset}")
for mine, _, reset in seen.values():
    assert np.allclose(mine, 0) and np.allclose(reset, 0, atol=1e-12)
assert np.allclose(seen["0 0 0"][1], 0) and np.allclose(seen["30 20 0"][1], 0)
assert np.allclose(seen["30 0 0"][1], [0, 0.5, 1 - np.cos(np.pi / 6)])
assert np.allclose(seen["0 0 90"][1], [3, 1, 0])
PY
