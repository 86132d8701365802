#!/usr/bin/env bash
# Version:  coal 3.0.3
# Does:     the contact patch of a round foot (Cylinder) that stands flat on a large Box is a single point
#           where the foot is the first of the two shapes, and the whole disc where it is the second. The
#           normal and the depth are right both ways. On a Halfspace and for a square foot (Box) the
#           patch is whole in either order; a Cone on a Box or a disc on a disc is a point, too.
# Guess:    what two bodies have in common does not depend on which is named first.
# Means:    a support polygon made from patches has no area under a round sole, and a balance test says
#           that the robot falls, or not, by the order of a pair. Name the round shape second, or compare the
#           patch with that of the swapped pair.
# Seen:     radius 0.05 m, 12 samples: 1 point with the foot first, 12 points and 75.0 cm² with the
#           ground first (a regular 12-gon: 75.0 cm²); Halfspace 75.0 cm² both ways; tilted by 1e-4 rad
#           the one point is on the rim
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check coal==3.0.3
"$work/env/bin/python" - <<'PY'
import coal
import numpy as np

RADIUS, HEIGHT, DEPTH, SAMPLES = 0.05, 0.04, 0.001, 12


def at(height, tilt=0.0):
    place = coal.Transform3s()
    place.setTranslation(np.array([0.0, 0.0, height]))
    c, s = np.cos(tilt), np.sin(tilt)
    place.setRotation(np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]))
    return place


def patch(first, second):
    """Corners of the contact patch of two (shape, place)."""
    request = coal.CollisionRequest(coal.CollisionRequestFlag.CONTACT, 1)
    result = coal.CollisionResult()
    coal.collide(*first, *second, request, result)
    assert np.isclose(result.getContact(0).penetration_depth, -DEPTH, atol=1e-5)
    assert np.isclose(abs(result.getContact(0).normal[2]), 1, atol=1e-6)
    wanted, patches = coal.ContactPatchRequest(), coal.ContactPatchResult()
    wanted.setNumSamplesCurvedShapes(SAMPLES)
    coal.computeContactPatch(*first, *second, result, wanted, patches)
    found = patches.getContactPatch(0)
    return np.array([found.getPoint(k) for k in range(found.size())])


def area(points):
    x, y = points[:, 0], points[:, 1]
    return 1e4 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


polygon = 1e4 * SAMPLES / 2 * RADIUS**2 * np.sin(2 * np.pi / SAMPLES)
round_foot, square_foot = coal.Cylinder(RADIUS, HEIGHT), coal.Box(0.1, 0.1, HEIGHT)
grounds = {
    "Box": (coal.Box(4, 4, 2), at(-1.0)),
    "Halfspace": (coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0), at(0.0)),
}
print(f"12-gon {polygon:.1f} cm²")
for name, ground in grounds.items():
    for shape in (round_foot, square_foot):
        foot = (shape, at(HEIGHT / 2 - DEPTH))
        seen = [patch(foot, ground), patch(ground, foot)]
        kind = type(shape).__name__
        print(f"{kind} on {name}: foot first {len(seen[0])} points, {area(seen[0]):.1f} cm²; "
              f"ground first {len(seen[1])} points, {area(seen[1]):.1f} cm²")
        whole = polygon if shape is round_foot else 100.0
        assert np.isclose(area(seen[1]), whole, rtol=1e-4)
        if shape is round_foot and name == "Box":
            assert len(seen[0]) == 1 and len(seen[1]) == SAMPLES
        else:
            assert np.isclose(area(seen[0]), whole, rtol=1e-4)
tilted = patch((round_foot, at(HEIGHT / 2 - DEPTH, 1e-4)), grounds["Box"])
print("tilted, foot first:", tilted.round(4))
assert len(tilted) == 1 and np.isclose(np.linalg.norm(tilted[0, :2]), RADIUS, rtol=1e-3)
PY
