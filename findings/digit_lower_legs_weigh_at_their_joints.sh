#!/usr/bin/env bash
# Version:  Agility Digit of gym-jiminy-zoo 1.8.13 (the environments of the simulator Jiminy; digit.urdf), pin 4.1.0, trimesh 5.2.0
# Does:     the centre of mass of each lower leg (tarsus, 1.32 kg, 0.45 m long) has x = 0.000932 m, which is its moment ixx to the
#           last digit: the centre lies in the upper joint. Its mesh, in the same package, has its middle at 0.159 m. Both
#           forearms have izz = -0.000009 kg·m², where iyy is 0.0096. Pinocchio, and Jiminy with it, read all of this
#           without a word. The other links of legs and trunk have centres and moments like those of their meshes.
# Guess:    what a simulator ships with its walking environments is the robot; moments of inertia are positive.
# Means:    the leg below the knee swings as if it were 2.9 times as easy to turn and does not weigh about its joint: torques of
#           the knee, step times and gains are for another robot. The forearm turns with less than nothing about its
#           own centre. Set x and izz (the mirror images have the same mistakes, so comparing left and right shows nothing),
#           or take centres and moments from the meshes.
# Seen:     lower leg: centre 0.000932 m along it, hull of its mesh 0.1586 m; about its joint 0.0176 for 0.0509 kg·m², weight held
#           out level 0.01 for 2.06 N·m; forearm: principal moment -0.0012, hull 0.00044; other links of legs and trunk
#           at most 0.035 m from their hulls
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0 trimesh==5.2.0 scipy==1.17.1 2>/dev/null
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" gym-jiminy-zoo==1.8.13 2>/dev/null
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
import trimesh

(path,) = Path("robots").rglob("digit/digit.urdf")
model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
off, least = {}, {}
for link in ET.parse(path).getroot().findall("link"):
    inertial, shape = link.find("inertial"), link.find("visual/geometry/mesh")
    name, mass = link.get("name"), float(inertial.find("mass").get("value"))
    centre = np.array(inertial.find("origin").get("xyz").split(), dtype=float)
    moments = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
    tensor = np.array([[moments["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    mesh = trimesh.load(path.parent / shape.get("filename").removeprefix("package://"), force="mesh")
    mesh.apply_scale(np.array((shape.get("scale") or "1 1 1").split(), dtype=float))
    hull = mesh.convex_hull
    hull.density = mass / hull.volume
    off[name] = np.linalg.norm(centre - hull.center_mass)
    least[name] = np.linalg.eigvalsh(tensor)[0]
    if "tarsus" in name or "elbow" in name:
        print(f"{name}: {mass} kg, centre {centre} m (hull {hull.center_mass.round(4)}), moments {tensor.diagonal()} "
              f"(hull {hull.moment_inertia.diagonal().round(6)}), smallest principal {least[name]:.6f} kg·m²")
    if "tarsus" in name:
        assert centre[0] == moments["ixx"] and abs(hull.center_mass[0] - 0.1586) < 1e-3
        reach = np.ptp(mesh.bounds, axis=0)[0]

        def about_joint(where):
            return moments["izz"] + mass * (where[0] ** 2 + where[1] ** 2)

        right = np.array([hull.center_mass[0], centre[1], centre[2]])
        print(f"    {reach:.2f} m long; about its joint {about_joint(centre):.4f} kg·m² for {about_joint(right):.4f}, "
              f"weight held out level {9.81 * mass * centre[0]:.3f} N·m for {9.81 * mass * right[0]:.2f}")
        assert about_joint(right) > 2.5 * about_joint(centre)
        (body,) = [frame for frame in model.frames if frame.name == name and frame.type == pin.FrameType.BODY]
        read = model.inertias[body.parentJoint]  # nothing corrected, and no complaint
        assert np.allclose(body.placement.act(centre), read.lever) or read.mass > mass
    if "elbow" in name:
        assert moments["izz"] == -9e-06 and hull.moment_inertia[2, 2] > 0.006
legs = [name for name in off if "tarsus" not in name and "shoulder" not in name and "waist" not in name and "elbow" not in name]
print(f"other links of legs and trunk: centre at most {max(off[name] for name in legs):.3f} m from that of the hull")
assert max(off[name] for name in legs) < 0.04 and min(off["left_tarsus"], off["right_tarsus"]) > 0.15
assert sorted(name for name, value in least.items() if value <= 0.0) == ["left_elbow", "right_elbow"]
PY
