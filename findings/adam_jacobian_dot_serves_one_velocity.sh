#!/usr/bin/env bash
# Version:  adam-robotics 0.5.0 with numpy 2.4.6
# Does:     jacobian_dot gives a matrix that, times the velocity that it was made for, is the acceleration it should be, and
#           that is not the derivative of jacobian: entries differ by as much as they are large. The Jacobian of the
#           base is (1 0) whatever the robot does, and its "derivative" is not 0. So in mixed, in body-fixed and in
#           inertial velocities alike. (Its issue 27, closed, asks for J dot, "or at least" J dot nu; that it is the
#           second alone is said nowhere that was found.)
# Guess:    "the Jacobian derivative": the derivative of what jacobian gives, along the motion.
# Means:    J dot times nu is right, which is what a check compares and what a task of acceleration needs. Anything else made
#           of it is not: the rate of J M^-1 J', of a null-space projector, of a velocity that another rate would
#           have, or one column alone. Take difference quotients, or differentiate jacobian by CasADi or JAX.
# Seen:     trunk, thigh and foot, turning: base, entries of up to 0.74 for 0; foot off by 0.94 (body-fixed), 0.71 (mixed and
#           inertial) where the largest is 0.50 and 0.65; times the velocity itself right to 1e-9, times another one of
#           the same size off by 0.26 to 1.2
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check adam-robotics==0.5.0 numpy==2.4.6 scipy==1.17.1
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import numpy as np
from adam import Representations
from adam.numpy import KinDynComputations
from scipy.spatial.transform import Rotation

link = """<link name="{}"><inertial><origin xyz="0 0 0" rpy="0 0 0"/><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>
</inertial></link>"""
joint = """<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><origin xyz="0 0.1 -0.4" rpy="0 0 0"/><axis xyz="{}"/>
<limit lower="-2" upper="2" effort="9" velocity="9"/></joint>"""
Path("leg.urdf").write_text('<robot name="leg">' + "".join(map(link.format, ("trunk", "thigh", "foot")))
                            + joint.format("hip", "trunk", "thigh", "1 0 0") + joint.format("knee", "thigh", "foot", "0 1 0")
                            + "</robot>")
robot = KinDynComputations.from_urdf("leg.urdf", ["hip", "knee"])
rng, h = np.random.default_rng(1), 1e-6
base, s = np.eye(4), rng.normal(size=2)
base[:3, :3], base[:3, 3] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.normal(size=3)
velocity, rates, other = rng.normal(size=6), rng.normal(size=2), rng.normal(size=8)
nu = np.array([*velocity, *rates])


def moved(kind, time):
    """Base and joints after a time at this velocity, in first order."""
    linear, turn = velocity[:3], Rotation.from_rotvec(time * velocity[3:]).as_matrix()
    pose = base.copy()
    if kind == Representations.BODY_FIXED_REPRESENTATION:
        pose[:3, :3], pose[:3, 3] = base[:3, :3] @ turn, base[:3, 3] + time * base[:3, :3] @ linear
    else:
        pose[:3, :3], pose[:3, 3] = turn @ base[:3, :3], base[:3, 3] + time * linear
        if kind == Representations.INERTIAL_FIXED_REPRESENTATION:
            pose[:3, 3] += time * np.cross(velocity[3:], base[:3, 3])
    return pose, s + time * rates


for kind in Representations:
    robot.set_frame_velocity_representation(kind)
    for frame in ("trunk", "foot"):
        said = np.asarray(robot.jacobian_dot(frame, base, s, velocity, rates))
        ahead, behind = (np.asarray(robot.jacobian(frame, *moved(kind, time))) for time in (h, -h))
        true = (ahead - behind) / (2 * h)
        print(f"{kind.name:30} {frame:6} largest {abs(true).max():.2f}, said {abs(said).max():.2f}, off by {abs(said - true).max():.2f};"
              f" times its velocity off by {abs((said - true) @ nu).max():.1g}, times another {abs((said - true) @ other).max():.2f}")
        assert abs((said - true) @ nu).max() < 1e-6
        assert abs(said - true).max() > 0.5 and abs((said - true) @ other).max() > 0.2
        if kind == Representations.BODY_FIXED_REPRESENTATION and frame == "trunk":
            assert abs(true).max() < 1e-9 and np.allclose(ahead, np.eye(6, 8))
PY
