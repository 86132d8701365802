#!/usr/bin/env bash
# Version:  urdf-to-mjcf 0.1.1, mujoco 4.0.0
# Does:     the <mimic> of a URDF joint is written with the two joints changed about: of "knee = 2 hip + 0.1" the
#           MJCF says "hip = 2 knee + 0.1". With multiplier 1 or -1 and no offset nothing is to be seen. The
#           products of inertia (ixy, ixz, iyz) of every link are left out, too. Neither is said; the equality
#           compiles and holds.
# Guess:    the joint that has the <mimic> follows the one that it names, in a converter as in a reader.
# Means:    a leg whose linkage bends the knee twice as far as the hip bends it half as far: the foot is
#           somewhere else at every instant, and torques meant for the leader act through a quarter of the gear.
#           Swap joint1 and joint2 in the file, or let MuJoCo read the URDF itself.
# Seen:     hip at 0.3 rad: knee at 0.1 rad for 0.7 (0.7 where MuJoCo reads the URDF itself); ixz of the thigh
#           0 for 0.03 kg·m²
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check urdf-to-mjcf==0.1.1 mujoco==4.0.0
cd "$work"
PATH="$work/env/bin:$PATH" "$work/env/bin/python" - <<'PY'
import subprocess
from pathlib import Path

import mujoco
import numpy as np

LINK = """<link name="{0}"><inertial><origin xyz="0 0 -0.2"/><mass value="{1}"/>
<inertia ixx="0.2" ixy="0" ixz="{2}" iyy="0.2" iyz="0" izz="0.1"/></inertial>
<collision><origin xyz="0 0 -0.2"/><geometry><box size="0.1 0.1 0.4"/></geometry></collision></link>"""
JOINT = """<joint name="{0}" type="revolute"><origin xyz="0 0 {1}"/><parent link="{2}"/><child link="{3}"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="100" velocity="10"/>{4}</joint>"""
robot = "".join(
    [
        '<robot name="leg">',
        *(LINK.format(*one) for one in (("trunk", 10, 0), ("thigh", 4, 0.03), ("shin", 2, 0))),
        JOINT.format("hip", "-0.1", "trunk", "thigh", ""),
        JOINT.format("knee", "-0.4", "thigh", "shin", '<mimic joint="hip" multiplier="2" offset="0.1"/>'),
        "</robot>",
    ]
)
Path("leg.urdf").write_text(robot)
subprocess.run(["urdf-to-mjcf", "leg.urdf"], check=True, capture_output=True)
(written,) = Path("output_mjcf").glob("*.xml")
tied, product = {}, {}
for name, path in (("MuJoCo", Path("leg.urdf")), ("urdf-to-mjcf", written)):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    hip, knee = (model.joint(joint).qposadr[0] for joint in ("hip", "knee"))
    gap = []  # of the tie, at two angles of the knee: it is linear between them
    for angle in (0.0, 1.0):
        data.qpos[:] = model.qpos0
        data.qpos[hip], data.qpos[knee] = 0.3, angle
        mujoco.mj_forward(model, data)
        assert model.neq == 1 and data.efc_type[0] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        gap.append(float(data.efc_pos[0]))
    tied[name] = gap[0] / (gap[0] - gap[1])
    body = model.body("thigh").id
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    turn = turn.reshape(3, 3)
    product[name] = float((turn @ np.diag(model.body_inertia[body]) @ turn.T)[0, 2])
    print(f"{name}: hip 0.3 rad, knee {tied[name]:.3f} rad; ixz of the thigh {product[name]:.3f} kg·m²")
assert abs(tied["MuJoCo"] - 0.7) < 1e-6 and abs(product["MuJoCo"] - 0.03) < 1e-6
assert abs(tied["urdf-to-mjcf"] - 0.1) < 1e-6 and abs(product["urdf-to-mjcf"]) < 1e-6
PY
