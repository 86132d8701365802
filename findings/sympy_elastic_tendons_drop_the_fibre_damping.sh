#!/usr/bin/env bash
# Version:  SymPy 1.14.0 (sympy.physics.biomechanics)
# Does:     MusculotendonDeGroote2016 takes fiber_damping_coefficient ("the damping element in the muscle fiber model",
#           recommended 0.1) in every formulation and lists it among the constants. Both elastic ones, with
#           fibre length or tendon force as the state, leave it out: rates are the same for 0, 0.1 and 10. Only the
#           rigid tendon has it. Nothing is said.
# Guess:    one muscle in three formulations: a parameter that is taken is used, or refused.
# Means:    the damping is what keeps the fibre's speed finite at low activation: a muscle of the swing leg at 0.05 gets
#           843 times its largest speed where the equilibrium with damping has 1.03. Integrators stop or step at
#           nanoseconds, and raising the damping, as one is told to, changes nothing. Keep the activation up, or
#           solve the equilibrium for the speed yourself.
# Seen:     fibre at 0.95 of its optimal length, tendon force 0.17: activation 0.6, speed -0.39 of the largest for every damping;
#           by the equilibrium -0.39 (0), -0.33 (0.1) and -0.03 (10)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check sympy==1.14.0 numpy==2.4.6 scipy==1.17.1 mpmath==1.3.0
"$work/env/bin/python" - <<'PY'
import numpy as np
import sympy as sm
from scipy.optimize import brentq
from sympy.physics.biomechanics import (
    FiberForceLengthActiveDeGroote2016,
    FiberForceLengthPassiveDeGroote2016,
    FiberForceVelocityDeGroote2016,
    FirstOrderActivationDeGroote2016,
    MusculotendonDeGroote2016,
    MusculotendonFormulation,
)
from sympy.physics.mechanics import LinearPathway, Point, ReferenceFrame, dynamicsymbols

STRENGTH, OPTIMAL, SLACK, FASTEST, ANGLE = 1000.0, 0.1, 0.2, 1.0, 0.4
WHOLE, SHARE, STRETCHING = 0.29, 0.95, 0.05  # m, of the optimal length, m/s
length, ground = dynamicsymbols("q", positive=True), ReferenceFrame("N")
origin, insertion = Point("O"), Point("I")
insertion.set_pos(origin, length * ground.x)


def muscle(formulation, damping):
    return MusculotendonDeGroote2016.with_defaults(
        "m", LinearPathway(origin, insertion), FirstOrderActivationDeGroote2016.with_defaults("m"),
        musculotendon_dynamics=formulation, peak_isometric_force=STRENGTH, optimal_fiber_length=OPTIMAL,
        tendon_slack_length=SLACK, maximal_fiber_velocity=FASTEST, optimal_pennation_angle=ANGLE,
        fiber_damping_coefficient=damping)


def number(expression, activation, state=None):
    values = {} if state is None else {dynamicsymbols(state[0]): state[1]}
    return float(expression.doit().subs({length.diff(): STRETCHING}).subs(
        {length: WHOLE, dynamicsymbols("a_m"): activation, **values}).doit())


x = sm.Symbol("x")
active, passive, speed = (sm.lambdify(x, curve.with_defaults(x).doit()) for curve in (
    FiberForceLengthActiveDeGroote2016, FiberForceLengthPassiveDeGroote2016, FiberForceVelocityDeGroote2016))
along = np.sqrt((SHARE * OPTIMAL) ** 2 - (OPTIMAL * np.sin(ANGLE)) ** 2)
cosine = along / (SHARE * OPTIMAL)


def by_equilibrium(activation, damping, tendon):
    """Fibre speed, of the largest, at which the fibre pulls as the tendon does."""
    return brentq(lambda v: activation * active(SHARE) * speed(v) + passive(SHARE) + damping * v
                  - tendon / cosine, -1e6, 1e6, xtol=1e-12)


kinds = MusculotendonFormulation
for activation in (0.6, 0.05):
    rates = {}
    for damping in (0.0, 0.1, 10.0):
        by_length = muscle(kinds.FIBER_LENGTH_EXPLICIT, damping)
        tendon = -number(by_length.force, activation, ("l_M_tilde_m", SHARE)) / STRENGTH
        own = number(by_length.rhs()[0], activation, ("l_M_tilde_m", SHARE)) * OPTIMAL / FASTEST
        rising = number(muscle(kinds.TENDON_FORCE_EXPLICIT, damping).rhs()[0], activation, ("F_T_tilde_m", tendon))
        right = by_equilibrium(activation, damping, tendon) if damping else float("nan")
        rates[damping] = own, rising
        print(f"activation {activation}, damping {damping}: fibre speed {own:.6g} of the largest, by the "
              f"equilibrium {right:.4g}; rate of tendon force {rising:.6g}")
        if damping:
            assert abs(own - right) > 0.05
    assert rates[0.0] == rates[0.1] == rates[10.0]
    # What is solved is the equilibrium without damping.
    assert np.isclose(activation * active(SHARE) * speed(own) + passive(SHARE), tendon / cosine, rtol=1e-6)
rigid = [-number(muscle(kinds.RIGID_TENDON, damping).force, 0.6) for damping in (0.0, 0.1)]
print(f"rigid tendon: {rigid[0]:.2f} N, with damping 0.1 {rigid[1]:.2f} N")
assert rigid[1] > rigid[0] + 0.5
PY
