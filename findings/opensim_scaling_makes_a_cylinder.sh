#!/usr/bin/env bash
# Version:  opensim 4.6
# Does:     scaling a body alike in x, y and z scales its inertia exactly. With factors that differ by as
#           little as a thousandth the body is taken for a cylinder about the axis of its smallest moment
#           (x, y or z of the body), and one of the two other moments, here that about x, stands for both:
#           a body of a pelvis' size becomes as hard to turn about y as about x, 18 % more than it was,
#           and a stretch along x gives the same moments as one along y. Nothing says so.
# Guess:    inertia scales with the lengths (each product of two coordinates by its two factors), and a
#           factor that tends to 1 changes nothing.
# Means:    trunks, pelves and feet, which no cylinder resembles, get another inertia as soon as a subject is
#           scaled by markers; compare the moments before and after with one factor for all axes, or set
#           the tensor after scaling.
# Seen:     moments (0.1028, 0.0871, 0.0579) kg·m² scaled by (1, 1, 1.001), mass kept: 0.1029, 0.1029, 0.0579,
#           exactly 0.1029, 0.0872, 0.0579; by (1.2, 1, 1) and (1, 1.2, 1) alike 0.1086, 0.1086, 0.0695,
#           exactly 0.1028, 0.0964, 0.0672 and 0.1190, 0.0871, 0.0741
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check opensim==4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import numpy as np
import opensim

opensim.Logger.setLevelString("Warn")
MASS, MOMENTS = 11.777, np.array([0.1028, 0.0871, 0.0579])


def scaled(factors):
    """The moments of the pelvis by OpenSim, of the same mass in the scaled lengths."""
    model = opensim.Model()
    pelvis = opensim.Body("pelvis", MASS, opensim.Vec3(0), opensim.Inertia(*MOMENTS))
    model.addBody(pelvis)
    model.addJoint(opensim.FreeJoint("free", model.getGround(), pelvis))
    state = model.initSystem()
    scale = opensim.Scale()
    scale.setSegmentName("pelvis")
    scale.setScaleFactors(opensim.Vec3(*factors))
    scale.setApply(True)
    scales = opensim.ScaleSet()
    scales.cloneAndAppend(scale)
    assert model.scale(state, scales, True)  # True keeps the masses
    body = model.getBodySet().get("pelvis")
    assert np.isclose(body.getMass(), MASS)
    moments = body.getInertia().getMoments()
    return np.array([moments[k] for k in range(3)])


def exact(factors):
    """From the second moments of the mass: the integral of x² goes with the square of its factor."""
    spread = (MOMENTS.sum() / 2 - MOMENTS) * np.square(factors)
    return spread.sum() - spread


seen = {}
for factors in ((1, 1, 1), (1.2, 1.2, 1.2), (1, 1, 1.001), (1.2, 1, 1), (1, 1.2, 1)):
    seen[factors] = scaled(factors)
    print(factors, "OpenSim", seen[factors].round(4), "exact", exact(factors).round(4))
for factors in ((1, 1, 1), (1.2, 1.2, 1.2)):
    assert np.allclose(seen[factors], exact(factors))
assert np.allclose(seen[1, 1, 1.001], [0.1029, 0.1029, 0.0579], atol=1e-4)
assert np.allclose(exact((1, 1, 1.001)), [0.1029, 0.0872, 0.0579], atol=1e-4)
assert np.allclose(seen[1.2, 1, 1], seen[1, 1.2, 1])
PY
