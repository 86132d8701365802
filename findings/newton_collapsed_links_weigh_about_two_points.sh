#!/usr/bin/env bash
# Version:  newton 1.8.0, warp-lang 1.19.0, pin 4.1.0 to compare
# Does:     with collapse_fixed_joints=True (add_urdf; the builder's collapse_fixed_joints does it) a link behind a fixed joint
#           is merged into its parent. Mass and centre of mass are right. The tensor, which Newton takes about the centre
#           of mass, is a sum of tensors about other points: the child's is moved by the whole offset of the link, the
#           parent's is not moved at all. Without the option each part has the file's.
# Guess:    merging what is fixed changes no motion; Pinocchio does it for every URDF.
# Means:    feet, soles, batteries and covers hang on fixed joints in most URDFs, and this is the option that makes a model of
#           them fast: the limbs turn too slowly, the more the heavier the part that is merged. Gravity torques do not
#           show it. Compare the mass matrix with and without, or merge the links in the file. (A reviewer of its pull request
#           2692, closed, says so of a copy of this code.)
# Seen:     shin of 1 kg with a foot of 2 kg fixed 0.37 m off: moment about an axis through the centre 0.370, 0.410,
#           0.360 for 0.197, 0.277, 0.293 kg·m² by hand and by Pinocchio; a foot fixed in the origin of the
#           shin with its centre there right
set -euo pipefail
work=$(mktemp -d)
export WARP_CACHE_PATH="$work/cache"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check newton==1.8.0 warp-lang==1.19.0 pin==4.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
import pinocchio as pin
import warp as wp

wp.config.quiet = True
import newton

SHIN, FOOT, FOOT_TENSOR = 1.0, 2.0, np.diag([0.1, 0.2, 0.25])


def read(place):
    Path("leg.urdf").write_text(f"""<robot name="leg"><link name="trunk"/><link name="shin"><inertial><mass value="{SHIN}"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<link name="foot"><inertial><mass value="{FOOT}"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/></inertial></link>
<joint name="knee" type="revolute"><parent link="trunk"/><child link="shin"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
<joint name="fixed" type="fixed"><parent link="shin"/><child link="foot"/><origin xyz="{' '.join(map(str, place))}"/></joint>
</robot>""")
    parts = newton.ModelBuilder()
    parts.add_urdf("leg.urdf", floating=False)
    tensors = {name.split("/")[-1]: np.array(one).reshape(3, 3) for name, one in zip(parts.body_label, parts.body_inertia)}
    assert np.allclose(tensors["shin"], 0.01 * np.eye(3)) and np.allclose(tensors["foot"], FOOT_TENSOR)
    builder = newton.ModelBuilder()
    builder.add_urdf("leg.urdf", floating=False, collapse_fixed_joints=True)
    (merged,) = [i for i, mass in enumerate(builder.body_mass) if mass > 0.0]
    other = pin.buildModelFromUrdf("leg.urdf").inertias[1]
    lever = FOOT / (SHIN + FOOT) * np.array(place)

    def moved(mass, d):
        return mass * (d @ d * np.eye(3) - np.outer(d, d))

    by_hand = 0.01 * np.eye(3) + moved(SHIN, lever) + FOOT_TENSOR + moved(FOOT, np.array(place) - lever)
    assert np.allclose(other.inertia, by_hand) and np.allclose(other.lever, lever)
    assert np.isclose(builder.body_mass[merged], SHIN + FOOT) and np.allclose(builder.body_com[merged], lever, atol=1e-6)
    said = np.array(builder.body_inertia[merged]).reshape(3, 3)
    print("foot at", place, "moments", np.diag(said).round(4), "by hand", np.diag(by_hand).round(4))
    return said, by_hand, 0.01 * np.eye(3) + FOOT_TENSOR + moved(FOOT, np.array(place))


said, by_hand, _ = read([0.0, 0.0, 0.0])
assert np.allclose(said, by_hand, atol=1e-6)
said, by_hand, unmoved = read([0.1, 0.2, 0.3])
assert np.allclose(said, unmoved, atol=1e-6) and abs(said - by_hand).max() > 0.1
PY
