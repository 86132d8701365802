#!/usr/bin/env bash
# Version:  trimesh 5.2.0
# Does:     with a density set, primitives.Cylinder and primitives.Sphere have the mass of that density and the moments of
#           density 1: an aluminium shank turns like one of air, a little lighter than air even. Box and Capsule have
#           both right, and so have the same shapes as meshes (to_mesh()) or as parts of a Scene.
# Guess:    mass and moment_inertia of one object are of one density; all primitives do alike.
# Means:    links drawn with the cylinders and spheres of URDF get masses that look right and inertias 2700 times
#           too small, so that legs swing for nothing and ankles have the armature alone. Compare
#           sqrt(moment / mass) with the size of the shape, or take to_mesh().
# Seen:     radius 0.05 m, length 0.4 m, 2700 kg/m³: 8.4 kg and 4.38e-5 kg·m² for 0.118 by hand; sphere of 0.05 m: 1.4 kg
#           and 5.24e-7 for 1.41e-3; box 0.1 x 0.1 x 0.4 m and capsule as by hand; all four in a scene as by hand
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 numpy==2.4.6 scipy==1.17.1
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
import trimesh

DENSITY, R, L = 2700.0, 0.05, 0.4
PI = np.pi
tube, ball = PI * R**2 * L, 4 / 3 * PI * R**3
half = ball / 2  # each cap, its centre of mass at 3/8 R and 83/320 m R^2 across it
caps = 2 * (83 / 320 * half * R**2 + half * (L / 2 + 3 / 8 * R) ** 2)
by_hand = {
    "Cylinder": tube * (R**2 / 4 + L**2 / 12),
    "Sphere": ball * 2 / 5 * R**2,
    "Box": 0.1 * 0.1 * L * (0.1**2 + L**2) / 12,
    "Capsule": tube * (R**2 / 4 + L**2 / 12) + caps,
}
shapes = {
    "Cylinder": trimesh.primitives.Cylinder(radius=R, height=L),
    "Sphere": trimesh.primitives.Sphere(radius=R),
    "Box": trimesh.primitives.Box(extents=[0.1, 0.1, L]),
    "Capsule": trimesh.primitives.Capsule(radius=R, height=L),
}
for name, shape in shapes.items():
    shape.density = DENSITY
    mesh = shape.to_mesh()
    mesh.density = DENSITY
    found, same, right = shape.moment_inertia[0, 0], mesh.moment_inertia[0, 0], DENSITY * by_hand[name]
    print(f"{name}: {shape.mass:.4g} kg, moment {found:.4g}, as a mesh {same:.4g}, by hand {right:.4g} kg m^2")
    assert np.isclose(same, right, rtol=0.02) and np.isclose(shape.mass, DENSITY * shape.volume, rtol=0.01)
    wrong = DENSITY if name in ("Cylinder", "Sphere") else 1.0
    assert np.isclose(found * wrong, right, rtol=0.02)
    in_scene = trimesh.Scene(shape).moment_inertia[0, 0]
    print(f"   as the only part of a scene {in_scene:.4g}")
    assert np.isclose(in_scene, right, rtol=0.02)
PY
