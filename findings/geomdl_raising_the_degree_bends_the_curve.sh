#!/usr/bin/env bash
# Version:  geomdl 5.4.0 (NURBS-Python), scipy 1.17.1 to compare
# Does:     operations.degree_operations(curve, [1]) raises the degree, and operations.remove_knot takes out a knot that
#           insert_knot has just put in. Neither changes a curve, by definition. A curve of one piece keeps its shape when
#           its degree is raised; one with knots inside becomes another curve, with knots at even places instead
#           of its own. A knot put in once and taken out again leaves another curve as well. Nothing is said. (Issues 125 and
#           135 of NURBS-Python, both closed, tell of such curves.)
# Guess:    the same curve with more control points, as in the book that the library follows (The NURBS Book, 5.4 and 5.5).
# Means:    a phase or path of a foot is raised in degree to join it to another, or to have one more derivative. The swing
#           foot then passes 62 mm from where it was planned. Fit the curve anew at the higher degree: with each
#           knot once more it is exact.
# Seen:     a swing of 0.6 m, cubic, knots at 0.3 and 0.6: off by 62.3 mm, knots at 1/3 and 2/3; one piece: 0; knot 0.45 put in and
#           taken out: off by 22.7 mm; SciPy with the knots doubled: 2e-13 mm
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check geomdl==5.4.0 scipy==1.17.1 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import copy

import numpy as np
from geomdl import BSpline, operations
from scipy import interpolate

# a foot goes 0.6 m ahead, 8 mm to the side and 0.12 m up
SWING = np.array([[0, 0, 0], [0.02, 0.003, 0.09], [0.2, 0.008, 0.14], [0.42, 0.008, 0.12], [0.57, 0.003, 0.02], [0.6, 0, 0]])
phase = np.linspace(0, 1, 201)


def curve(points, inner):
    made = BSpline.Curve()
    made.degree, made.ctrlpts, made.knotvector = 3, points.tolist(), [0] * 4 + inner + [1] * 4
    return made


def apart(one, other):
    """Largest distance in mm at the same phase."""
    places = [np.array(each.evaluate_list(list(phase))) for each in (one, other)]
    return 1e3 * np.linalg.norm(places[0] - places[1], axis=1).max()


foot, piece = curve(SWING, [0.3, 0.6]), curve(SWING[[0, 1, 4, 5]], [])
raised = operations.degree_operations(copy.deepcopy(foot), [1])
one_piece = apart(operations.degree_operations(copy.deepcopy(piece), [1]), piece)
more = operations.insert_knot(copy.deepcopy(foot), [0.45], [1])
less = operations.remove_knot(copy.deepcopy(more), [0.45], [1])
print(f"degree raised: off by {apart(raised, foot):.1f} mm, knots inside {np.round(raised.knotvector[5:-5], 3)}; one piece:"
      f" {one_piece:.0e} mm")
print(f"knot put in: off by {apart(more, foot):.0e} mm, taken out again: {apart(less, foot):.1f} mm")

cubic = interpolate.BSpline(foot.knotvector, SWING, 3)
assert np.allclose(cubic(phase), foot.evaluate_list(list(phase)), atol=1e-12)
knots = np.array([0.0] * 5 + [0.3] * 2 + [0.6] * 2 + [1.0] * 5)
at = np.array([knots[k + 1 : k + 5].mean() for k in range(len(knots) - 5)])
quartic = interpolate.make_interp_spline(at, cubic(at), k=4, t=knots)
print(f"SciPy, degree 4, each knot once more: off by {1e3 * abs(quartic(phase) - cubic(phase)).max():.0e} mm")
assert np.allclose(quartic(phase), cubic(phase), atol=1e-12)
assert raised.degree == 4 and one_piece < 1e-9 and apart(more, foot) < 1e-9 and len(less.ctrlpts) == len(foot.ctrlpts)
assert np.allclose(raised.knotvector[5:-5], [1 / 3, 2 / 3]) and apart(raised, foot) > 20 and apart(less, foot) > 10
PY
