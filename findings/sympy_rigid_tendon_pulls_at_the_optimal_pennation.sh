#!/usr/bin/env bash
# Version:  SymPy 1.14.0 (sympy.physics.biomechanics)
# Does:     MusculotendonDeGroote2016 with a rigid tendon, its default, lets the fibre turn as it shortens (constant height, in
#           length and velocity) and takes the force along the tendon as fibre force times cos(alpha_opt), the
#           angle at optimal length, at every length. So it is not fibre force times the slope of the fibre's length, and the
#           tendon does more work than the fibre. The two elastic formulations divide by the cosine of the angle that is.
#           (Pull request 25744 put the cosine in; none that was found says that it is held.)
# Guess:    one angle in lengths and forces; work of tendon and fibre equal, as nothing lies between them.
# Means:    soleus, gastrocnemius and vasti stand at 20 to 50 degrees when short, as at push-off: their torque is a quarter too
#           large there, and an optimiser gains work that no muscle does. Divide the force by cos(alpha_opt) and
#           multiply it by (l_MT - l_T)/l_M, or take an elastic tendon.
# Seen:     fibre 0.05 m, alpha_opt 25 degrees, activation 0.8: at 0.6 of the optimal length 700 N for 548 N, at 1.0 equal,
#           at 1.3 less by 4 %; shortening slowly from 1.2 to 0.6 the tendon works 72.2 J, the fibre 69.7 J
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check sympy==1.14.0 numpy==2.4.6 mpmath==1.3.0
"$work/env/bin/python" - <<'PY'
import numpy as np
import sympy as sm
from sympy.physics.biomechanics import (
    FiberForceLengthActiveDeGroote2016,
    FiberForceLengthPassiveDeGroote2016,
    FiberForceVelocityDeGroote2016,
    FirstOrderActivationDeGroote2016,
    MusculotendonDeGroote2016,
)
from sympy.physics.mechanics import LinearPathway, Point, ReferenceFrame, dynamicsymbols

STRENGTH, OPTIMAL, SLACK, ANGLE, ACTIVATION = 3500.0, 0.05, 0.25, np.radians(25.0), 0.8
length, ground = dynamicsymbols("q", positive=True), ReferenceFrame("N")
origin, insertion = Point("O"), Point("I")
insertion.set_pos(origin, length * ground.x)
muscle = MusculotendonDeGroote2016.with_defaults(
    "m", LinearPathway(origin, insertion), FirstOrderActivationDeGroote2016.with_defaults("m"),
    peak_isometric_force=STRENGTH, optimal_fiber_length=OPTIMAL, tendon_slack_length=SLACK,
    optimal_pennation_angle=ANGLE)  # the rigid tendon is the default
still = muscle.force.doit().subs({length.diff(): 0, muscle.a: ACTIVATION})
tension = sm.lambdify(length, -still.doit())

x = sm.Symbol("x")
active, passive, speed = (sm.lambdify(x, curve.with_defaults(x).doit()) for curve in (
    FiberForceLengthActiveDeGroote2016, FiberForceLengthPassiveDeGroote2016, FiberForceVelocityDeGroote2016))


def fibre(whole):
    """Length of the fibre [m] in a muscle of constant height, tendon at its slack length."""
    return np.hypot(whole - SLACK, OPTIMAL * np.sin(ANGLE))


def fibre_force(whole):
    share = fibre(whole) / OPTIMAL
    return STRENGTH * (ACTIVATION * active(share) * speed(0.0) + passive(share))


def whole_length(share):
    return SLACK + np.sqrt((share * OPTIMAL) ** 2 - (OPTIMAL * np.sin(ANGLE)) ** 2)


for share in (0.6, 0.8, 1.0, 1.3):
    whole = whole_length(share)
    slope = (fibre(whole + 1e-6) - fibre(whole - 1e-6)) / 2e-6
    own, right = float(tension(whole)), float(fibre_force(whole) * slope)
    print(f"fibre {share} of optimal: tendon {own:.0f} N, by virtual work {right:.0f} N, ratio {own / right:.3f}")
    assert np.isclose(slope, (whole - SLACK) / fibre(whole))  # the cosine of the angle that is
    assert np.isclose(own, fibre_force(whole) * np.cos(ANGLE), rtol=1e-9)
    assert np.isclose(own / right, np.cos(ANGLE) / slope, rtol=1e-6)
    assert np.isclose(own, right, rtol=1e-6) == (share == 1.0)

wholes = np.linspace(whole_length(0.6), whole_length(1.2), 2001)
of_tendon = np.trapezoid([float(tension(w)) for w in wholes], wholes)
of_fibre = np.trapezoid([float(fibre_force(w)) for w in wholes], fibre(wholes))
print(f"work of a slow shortening from 1.2 to 0.6: tendon {of_tendon:.2f} J, fibre {of_fibre:.2f} J")
assert of_tendon > 1.03 * of_fibre
PY
