#!/usr/bin/env bash
# Version:  roboticstoolbox-python 1.5.0 against pin 4.1.0
# Does:     a revolute URDF joint about the unit axis "0 0.6 0.8" is taken for one about another line:
#           the link beyond it ends 0.27 m away from where it is, without a warning. Axes along x, y
#           or z, however the joint's frame is turned, are right.
# Guess:    any unit axis of a URDF is read; the format has had them from the first day.
# Means:    the hips of G1, GR2 and R1 are tilted by 10 to 30 degrees: their legs stand elsewhere. Turn
#           the frame by rpy until the axis is x, y or z before such a file is given to this library.
# Seen:     (-0.181, 0.276, -0.382) by pin and by hand; (-0.377, 0.130, -0.259) by fkine
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check \
  roboticstoolbox-python==1.5.0 pin==4.1.0
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin
import roboticstoolbox as rtb

URDF = """<robot name="r"><link name="base"/><link name="leg"/><link name="foot"/>
<joint name="hip" type="revolute"><parent link="base"/><child link="leg"/><origin xyz="0 .1 0"/>
<axis xyz="{}"/><limit lower="-1" upper="2" effort="7" velocity="3"/></joint>
<joint name="sole" type="fixed"><parent link="leg"/><child link="foot"/>
<origin xyz=".1 .2 -.4"/></joint></robot>"""
q = 0.7
for axis in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.6, 0.8]):
    path = Path.cwd() / "leg.urdf"
    path.write_text(URDF.format(" ".join(map(str, axis))))
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array([q]))
    by_pin = data.oMf[model.getFrameId("foot")].translation
    by_hand = np.array([0.0, 0.1, 0.0]) + pin.exp3(q * np.array(axis)) @ [0.1, 0.2, -0.4]
    seen = rtb.Robot.URDF(str(path)).fkine([q], end="foot").t
    off = np.linalg.norm(seen - by_hand)
    print("axis", axis, "pin", by_pin.round(4), "fkine", seen.round(4), f"off {off:.4f} m")
    assert np.allclose(by_pin, by_hand)
    assert off < 1e-12 if 1.0 in axis else off > 0.2
PY
