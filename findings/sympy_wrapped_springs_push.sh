#!/usr/bin/env bash
# Version:  SymPy 1.14.0 (sympy.physics.mechanics and biomechanics)
# Does:     actuators have one sign by the documentation: a positive force pushes the two ends of a pathway apart, and springs,
#           dampers and musculotendons give a negative one where they pull. Straight pathways do so. WrappingPathway.to_loads
#           over a cylinder pulls the ends together for a positive force (its documentation calls the force expansile, and
#           its example shows the pull). So a stretched spring wrapped over a condyle stretches itself further, a damper
#           feeds, a muscle pushes. (Pull request 25071 turned the sign of pathways round, before this one came.)
# Guess:    the same actuator, put on another pathway, pulls as before.
# Means:    a knee with wrapped extensors flexes when they are excited, and a passive joint runs away. Straight and
#           wrapped muscles of one model differ in sign. Hand WrappingPathway the negative force, and check the power of
#           the loads against force times the rate of the length.
# Seen:     radius 30 mm, joint opening at 1 rad/s: spring of 1000 N/m stretched by 15 mm: loads do +450 mW where it takes up 450;
#           damper of 10 N·s/m +9 mW where it loses 9; muscle +904 mW where its tension takes 904; on a straight
#           pathway each -405, -7 and -814 mW, as by its energy
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check sympy==1.14.0 mpmath==1.3.0
"$work/env/bin/python" - <<'PY'
import math

import sympy as sm
from sympy.physics.biomechanics import FirstOrderActivationDeGroote2016, MusculotendonDeGroote2016
from sympy.physics.mechanics import (
    LinearDamper,
    LinearPathway,
    LinearSpring,
    Point,
    ReferenceFrame,
    WrappingCylinder,
    WrappingPathway,
    dynamicsymbols,
)

RADIUS, STIFFNESS, DAMPING, AT = sm.Rational(3, 100), 1000, 10, 0.9  # m, N/m, N·s/m, rad
ground, centre = ReferenceFrame("N"), Point("C")
centre.set_vel(ground, 0)
q, u = dynamicsymbols("q", positive=True), dynamicsymbols("u")
VALUES = {q.diff(): 1.0, u: 1.0, q: AT}

origin = centre.locatenew("O", RADIUS * ground.x)
origin.set_vel(ground, 0)
insertion = centre.locatenew("I", RADIUS * (sm.cos(q) * ground.x + sm.sin(q) * ground.y))
insertion.set_vel(ground, RADIUS * u * (-sm.sin(q) * ground.x + sm.cos(q) * ground.y))
PATHWAYS = {
    "straight": LinearPathway(origin, insertion),
    "cylinder": WrappingPathway(origin, insertion, WrappingCylinder(RADIUS, centre, ground.z)),
}


def number(expression):
    return float(expression.doit().subs(VALUES).doit())


for name, pathway in PATHWAYS.items():
    rest = number(pathway.length) - 0.015
    muscle = MusculotendonDeGroote2016.with_defaults(
        "m", pathway, FirstOrderActivationDeGroote2016.with_defaults("m"), peak_isometric_force=100.0,
        optimal_fiber_length=0.05, tendon_slack_length=number(pathway.length) - 0.05)
    VALUES[muscle.a] = 0.3
    actuators = {
        # Power by the energy that is stored, lost or made.
        "spring": (LinearSpring(STIFFNESS, pathway, equilibrium_length=rest), lambda rate: -STIFFNESS * 0.015 * rate),
        "damper": (LinearDamper(DAMPING, pathway), lambda rate: -DAMPING * rate**2),
        "muscle": (muscle, lambda rate: number(muscle.force) * rate),
    }
    for kind, (actuator, power) in actuators.items():
        own = number(sum(point.vel(ground).dot(load) for point, load in actuator.to_loads()))
        right = power(number(pathway.extension_velocity))
        print(f"{name}, {kind}: power {1e3 * own:+.1f} mW, by its energy {1e3 * right:+.1f} mW")
        assert right < -1e-3 and number(pathway.extension_velocity) > 0
        assert math.isclose(own, right if name == "straight" else -right, rel_tol=1e-9)
PY
