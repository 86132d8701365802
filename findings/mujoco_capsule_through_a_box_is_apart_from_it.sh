#!/usr/bin/env bash
# Version:  mujoco 4.0.0, coal 3.0.3 to compare
# Does:     how far a capsule is from a box is judged by the ends of the capsule as soon as its axis is inside the box.
#           One that sticks right through a board is "apart", by as much as its ends stand out, and has no contact;
#           one that lies across a box with its axis below the face is pushed sideways, out of the faces that it crosses,
#           and not up. So for mj_geomDistance, the sensors distance and fromto, and the contacts alike. A cylinder in the
#           place of the capsule is right, and so are capsules that are in by less than their radius.
# Guess:    "the smallest signed distance between two geoms"; the documentation says that the native pipeline (the default)
#           computes the correct values at all distances. Boxes with capsules have a collider of their own.
# Means:    limbs are capsules, and feet, steps and beams are boxes: a search for postures that keeps distances positive finds a
#           shin inside a beam, or a leg through the other foot, with clearance; an optimiser that starts there is pulled
#           deeper. Ask for the distance of a cylinder or mesh, or from a library of its own. No report was found
#           (closed issue 2206 is this for spheres).
# Seen:     shin of 5 cm radius, 0.5 m long, through a board of 2 cm: +0.19 m, no contact, for -0.31 m by coal and by hand (cylinder
#           -0.26, right); across a box of 0.2 m: +0.10 for -0.20 m; lying on it 2 cm below its face: normals along itself
#           only, 0.05 for 0.07 m; with the axis 2 cm above the face 0.03 m, upward, right
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 coal==3.0.3 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import coal
import mujoco
import numpy as np

RADIUS, HALF = 0.05, 0.25
ACROSS = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # the capsule's axis z along the box's x
XML = """<mujoco><worldbody><geom name="box" type="box" size="{box}"/>
<body pos="{place}" euler="0 90 0"><freejoint/><geom name="limb" type="{kind}" size="0.05 0.25"/></body></worldbody>
<sensor><distance geom1="box" geom2="limb" cutoff="1"/></sensor></mujoco>"""


def by_mujoco(box, place, kind="capsule"):
    """Distance, and the contacts' distances and normals."""
    text = XML.format(box=" ".join(map(str, box)), place=" ".join(map(str, place)), kind=kind)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    said = mujoco.mj_geomDistance(model, data, 0, 1, 1.0, np.zeros(6))
    assert np.isclose(said, data.sensordata[0])
    return said, [(one.dist, one.frame[:3].copy()) for one in data.contact]


def by_coal(box, place):
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    poses = coal.Transform3s(np.eye(3), np.zeros(3)), coal.Transform3s(ACROSS, np.array(place, dtype=float))
    return coal.distance(coal.Box(*(2 * np.array(box))), poses[0], coal.Capsule(RADIUS, 2 * HALF), poses[1], request, result)


def by_hand(box, place, ends=RADIUS):
    """Axes are parallel to the box's, so the least push that parts them is along one of three axes."""
    reach = np.array([HALF + ends, RADIUS, RADIUS])
    return -(np.array(box) + reach - np.abs(place)).min()


for name, box, place, seen in (
    ("through a board", [0.01, 0.3, 0.3], [0, 0, 0], 0.19),
    ("across a box", [0.1, 0.15, 0.2], [0, 0, 0], 0.10),
    ("lying, axis below the face", [0.1, 0.15, 0.2], [0, 0, 0.18], -0.05),
    ("lying, axis above the face", [0.1, 0.15, 0.2], [0, 0, 0.22], -0.03),
):
    said, contacts = by_mujoco(box, place)
    right = by_hand(box, place)
    print(f"{name}: {said:+.4f} m, coal {by_coal(box, place):+.4f}, by hand {right:+.4f};", "contacts:",
          [(round(dist, 4), normal.round(2).tolist()) for dist, normal in contacts])
    assert np.isclose(by_coal(box, place), right, atol=1e-6)
    assert np.isclose(said, seen, atol=1e-6)
    if seen > 0:
        assert not contacts and right < -0.19
        cylinder, touching = by_mujoco(box, place, "cylinder")
        assert np.isclose(cylinder, by_hand(box, place, ends=0.0), atol=1e-4) and touching
    elif "below" in name:
        assert right < -0.069 and all(abs(normal[0]) > 0.999 for _, normal in contacts) and len(contacts) == 2
    else:
        assert np.isclose(said, right) and all(abs(normal[2]) > 0.999 for _, normal in contacts)
PY
