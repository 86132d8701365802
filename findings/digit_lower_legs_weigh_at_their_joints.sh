#!/usr/bin/env bash
# Version:  Agility Digit of gym-jiminy-zoo 1.8.13 (the environments of the simulator Jiminy; digit.urdf), pin 4.1.0
# Does:     the centre of mass of each lower leg (tarsus, 1.32 kg, 0.45 m long) has x = 0.000932 m, which is its moment ixx to the
#           last digit: the centre lies in the upper joint. Its mesh, in the same package, has its middle at 0.135 m. Both
#           forearms have izz = -0.000009 kg·m², where iyy is 0.0096. Pinocchio reads all of this
#           without a word. The other links of legs and trunk have centres like those of their meshes.
# Guess:    what a simulator ships with its walking environments is the robot; moments of inertia are positive.
# Means:    the leg below the knee swings as if it were 2.4 times as easy to turn and does not weigh about its joint: torques of
#           the knee, step times and gains are for another robot. The forearm turns with less than nothing about its
#           own centre. Set x and izz (the mirror images have the same mistakes, so comparing left and right shows nothing),
#           or take centres and moments from the meshes.
# Seen:     lower leg: centre 0.000932 m along it, middle of the surface of its mesh 0.135 m; about its joint 0.0176 kg·m², with that
#           middle 0.0416; weight held out level 0.01 and 1.75 N·m; forearm: principal moments -0.0012, 0.0017, 0.0096; other
#           links of legs and trunk at most 0.026 m from their middles
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0 2>/dev/null
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" gym-jiminy-zoo==1.8.13 2>/dev/null
cd "$work"
"$work/env/bin/python" - <<'PY'
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin

(path,) = Path("robots").rglob("digit/digit.urdf")
model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
off, least = {}, {}
for link in ET.parse(path).getroot().findall("link"):
    inertial, shape = link.find("inertial"), link.find("visual/geometry/mesh")
    name, mass = link.get("name"), float(inertial.find("mass").get("value"))
    centre = np.array(inertial.find("origin").get("xyz").split(), dtype=float)
    moments = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
    tensor = np.array([[moments["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    lines = (path.parent / shape.get("filename").removeprefix("package://")).read_text().splitlines()
    corners = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
    corners *= np.array((shape.get("scale") or "1 1 1").split(), dtype=float)
    faces = [[int(part.split("/")[0]) - 1 for part in line.split()[1:]] for line in lines if line.startswith("f ")]
    triangles = np.array([(face[0], one, two) for face in faces for one, two in zip(face[1:], face[2:])])
    a, b, c = corners[triangles].swapaxes(0, 1)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    middle, reach = areas @ (a + b + c) / 3.0 / areas.sum(), np.ptp(corners, axis=0)  # the middle of the surface
    off[name] = abs(centre - middle).max()
    least[name] = np.linalg.eigvalsh(tensor)[0]
    (body,) = [frame for frame in model.frames if frame.name == name and frame.type == pin.FrameType.BODY]
    read = model.inertias[body.parentJoint]
    if "tarsus" in name or "elbow" in name:
        # nothing corrected, and no complaint
        assert np.allclose(read.lever, centre) and np.allclose(read.inertia, tensor) and np.isclose(read.mass, mass)
        print(f"{name}: {mass} kg, centre {centre} m, its mesh {reach.round(3)} m with its middle at {middle.round(4)}, "
              f"moments {tensor.diagonal()}, smallest principal {least[name]:.6f} kg·m²")
    if "tarsus" in name:

        def about_joint(where):
            return moments["izz"] + mass * (where[0] ** 2 + where[1] ** 2)

        right = np.array([middle[0], centre[1], centre[2]])
        print(f"    about its joint {about_joint(centre):.4f} kg·m² ({about_joint(right):.4f} with the middle of the mesh), "
              f"weight held out level {9.81 * mass * centre[0]:.3f} N·m ({9.81 * mass * right[0]:.2f})")
        assert centre[0] == moments["ixx"] and about_joint(right) > 2.0 * about_joint(centre)
    if "elbow" in name:
        assert moments["izz"] == -9e-06 and moments["iyy"] > 0.009
legs = [name for name in off if not any(part in name for part in ("tarsus", "shoulder", "waist", "elbow"))]
print(f"other links of legs and trunk: centre at most {max(off[name] for name in legs):.3f} m from the middle of the mesh")
assert max(off[name] for name in legs) < 0.03 and min(off["left_tarsus"], off["right_tarsus"]) > 0.12
assert sorted(name for name, value in least.items() if value <= 0.0) == ["left_elbow", "right_elbow"]
PY
