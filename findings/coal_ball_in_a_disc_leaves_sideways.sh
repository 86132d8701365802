#!/usr/bin/env bash
# Version:  coal 3.0.3
# Does:     where the centre of a Sphere has sunk into a Cylinder, distance and collide push it out through the round side,
#           also where a flat face is nearer, and say so with the depth to the side. On the axis the normal is
#           (0, 0, 0). With the centre outside all is right, and so it is for an Ellipsoid of three equal radii
#           in place of the Sphere, which goes another way.
# Guess:    the depth is the least by which the two must be moved apart, as for every other pair of shapes.
# Means:    a ball under the toe that sinks into a round stepping stone by more than its radius is thrown off sideways,
#           at a right angle to the ground and by the radius of the stone. Contact springs and the derivatives of an
#           optimiser get that normal, and a zero normal in the middle of the stone. Draw the ball as an Ellipsoid,
#           or the stone as a Box or a Convex. (Its issue 779, closed, has the definition above; 351, closed, suspects the same
#           function elsewhere; of this no report was found.)
# Seen:     ball of 10 mm, sunk by 12 mm into a disc of 300 mm across and 60 mm thick: depth 160 mm and normal 0 on the axis,
#           110 mm and a sideways normal 50 mm beside it, for 12 mm and upward by hand and with the Ellipsoid; sunk
#           by 9 mm it is 9 mm and upward
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check coal==3.0.3
cd "$work"
"$work/env/bin/python" - <<'PY'
import coal
import numpy as np

BALL, ACROSS, THICK = 0.010, 0.150, 0.060  # radius of the ball; radius and thickness of the disc, metres
stone = coal.Cylinder(ACROSS, THICK)
here = coal.Transform3s(np.eye(3), np.zeros(3))


def apart(shape, centre):
    """Signed distance and normal by distance, depth and normal by collide."""
    there = coal.Transform3s(np.eye(3), np.array(centre))
    asked, found = coal.DistanceRequest(), coal.DistanceResult()
    asked.enable_signed_distance = True
    said = coal.distance(stone, here, shape, there, asked, found)
    request, contacts = coal.CollisionRequest(), coal.CollisionResult()
    request.enable_contact = True
    coal.collide(stone, here, shape, there, request, contacts)
    contact = contacts.getContact(0)
    assert np.isclose(contact.penetration_depth, said, atol=1e-6) and np.allclose(contact.normal, found.normal, atol=1e-6)
    return said, np.array(found.normal)


def by_hand(centre):
    """Signed distance of the ball and the disc, the centre anywhere."""
    side, face = np.hypot(centre[0], centre[1]) - ACROSS, abs(centre[2]) - THICK / 2
    if side <= 0 and face <= 0:
        return max(side, face) - BALL
    return np.hypot(max(side, 0.0), max(face, 0.0)) - BALL


round_ellipsoid = coal.Ellipsoid(BALL, BALL, BALL)
for beside, sunk, wrong in ((0.0, 0.009, False), (0.05, 0.009, False), (0.0, 0.012, True), (0.05, 0.012, True)):
    centre = [beside, 0.0, THICK / 2 + BALL - sunk]
    said, normal = apart(coal.Sphere(BALL), centre)
    other, upward = apart(round_ellipsoid, centre)
    print(f"{1e3 * beside:.0f} mm beside the axis, sunk by {1e3 * sunk:.0f} mm: depth {-1e3 * said:.1f} mm, normal {normal.round(3)};"
          f" by hand {-1e3 * by_hand(centre):.1f} mm; Ellipsoid {-1e3 * other:.1f} mm, normal {upward.round(3)}")
    assert np.isclose(by_hand(centre), -sunk)
    assert np.isclose(other, -sunk, atol=2e-5) and abs(upward[2]) > 0.99
    if wrong:
        assert np.isclose(said, beside - ACROSS - BALL, atol=1e-6) and abs(normal[2]) < 1e-6
        assert np.isclose(np.linalg.norm(normal), 1.0 if beside else 0.0, atol=1e-6)
    else:
        assert np.isclose(said, -sunk, atol=1e-6) and abs(normal[2]) > 0.999
PY
