#!/usr/bin/env bash
# Version:  SymPy 1.14.0 (sympy.physics.mechanics)
# Does:     WrappingCylinder.geodesic_length of points with an angle in symbols takes the arc from the ratio of sine to cosine,
#           so half turns are lost: an insertion at pi - q from the origin has the arc 2 pi - q, one at pi + q has q.
#           With numbers for q the same points give the arc that the documentation defines (positive by the
#           right-hand rule). Nothing is said.
# Guess:    a length in symbols, with numbers put in, is the length of the numbers.
# Means:    a muscle behind the knee, whose arc shrinks from half a turn as the knee bends, is longer by pi times the
#           radius: 94 mm at 30 mm, two lengths of its fibre. The slope over the angle is right, so a check of the moment arm
#           passes. Compare one posture in numbers, or write r (pi - q) into a pathway of your own.
# Seen:     radius 30 mm, knee at 0.3 pi: insertion at pi - q 160.2 mm in symbols, 66.0 mm in numbers and by hand; at pi + q 28.3 for
#           122.5 mm; at q 28.3 mm both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check sympy==1.14.0 mpmath==1.3.0
"$work/env/bin/python" - <<'PY'
import math

import sympy as sm
from sympy.physics.mechanics import Point, ReferenceFrame, WrappingCylinder, WrappingPathway, dynamicsymbols

RADIUS = sm.Rational(3, 100)  # m
ground, centre = ReferenceFrame("N"), Point("C")
q = dynamicsymbols("q")


def path(angle):
    """A pathway over the condyle from angle 0 to `angle`."""
    origin = centre.locatenew("O", RADIUS * ground.x)
    insertion = centre.locatenew("I", RADIUS * (sm.cos(angle) * ground.x + sm.sin(angle) * ground.y))
    return WrappingPathway(origin, insertion, WrappingCylinder(RADIUS, centre, ground.z))


knee = 3 * sm.pi / 10
for angle, right in ((sm.pi - q, sm.pi - knee), (sm.pi + q, sm.pi + knee), (q, knee)):
    in_symbols = float(path(angle).length.subs(q, knee))
    in_numbers = float(path(angle.subs(q, knee)).length)
    by_hand = float(RADIUS * right)
    print(f"insertion at {angle}: {1e3 * in_symbols:.1f} mm in symbols, {1e3 * in_numbers:.1f} in numbers, "
          f"{1e3 * by_hand:.1f} by hand")
    assert math.isclose(in_numbers, by_hand, rel_tol=1e-12)
    if angle == q:
        assert math.isclose(in_symbols, by_hand, rel_tol=1e-12)
    else:
        assert math.isclose(abs(in_symbols - by_hand), math.pi * float(RADIUS), rel_tol=1e-9)
PY
