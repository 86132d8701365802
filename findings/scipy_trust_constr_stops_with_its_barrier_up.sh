#!/usr/bin/env bash
# Version:  scipy 1.17.1 (numpy 2.4.6)
# Does:     with a bound or any inequality, minimize(method="trust-constr") ends as soon as the gradient of the Lagrangian
#           and the violation are below gtol, wherever its barrier parameter is: at 8e-4 or 0.1 for a barrier_tol
#           of 1e-8. It says success, status 1, optimality 1e-9. The documentation says that it terminates only when
#           the barrier parameter is less than barrier_tol.
# Guess:    an answer that is optimal to 1e-8 lies on the bound that it presses on, to about that.
# Means:    on the way along the barrier's path that gradient is zero everywhere, so the test is passed at the first stop.
#           Joints, torques and feet stay off limits that are active, by 2e-4 in a well-scaled problem and by 7e-2
#           where the cost is in mega-units; multiplier times distance is the barrier's, not zero. Compare
#           barrier_parameter of the result with barrier_tol, and lower gtol until it is reached.
# Seen:     minimum of s (x + 3)^2 over x >= -1: x = -0.99980 (s = 1), -0.99599 (s = 0.01), -0.93012 (s = 1e-6), with barrier
#           parameters 8e-4, 1.6e-4, 2.6e-7; s = 1000 stops at 0.1. SLSQP and L-BFGS-B
#           return -1 (all but the last s, below their tolerance)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.4.6
"$work/env/bin/python" - <<'PY'
import numpy as np
from scipy.optimize import Bounds, LinearConstraint, minimize

BARRIER_TOL = 1e-8  # the default, given all the same
off = {}
for scale in (1e3, 1.0, 1e-2, 1e-6):
    cost = {
        "fun": lambda x, s=scale: s * (x[0] + 3.0) ** 2,
        "x0": [2.0],
        "jac": lambda x, s=scale: 2.0 * s * (x + 3.0),
    }
    limits = {"bounds": Bounds(-1.0, np.inf)}, {"constraints": LinearConstraint([[1.0]], -1.0, np.inf)}
    for limit in limits:
        result = minimize(**cost, **limit, method="trust-constr", hess=lambda x, s=scale: 2.0 * s * np.eye(1),
                          options={"gtol": 1e-8, "barrier_tol": BARRIER_TOL})
        assert result.success and result.status == 1 and result.optimality < 1e-8
        x, barrier = result.x[0], result.barrier_parameter
        # by hand: what minimises the cost with the barrier, s (x + 3)^2 - barrier log(x + 1), not the cost
        by_hand = -2.0 + np.sqrt(1.0 + barrier / (2.0 * scale))
        assert np.isclose(x + 1.0, by_hand + 1.0, rtol=0.15)
        print(f"s = {scale:g}, {next(iter(limit))}: x = {x:.5f}, optimality {result.optimality:.1e}, barrier {barrier:.1e},"
              f" multiplier times distance {abs(result.v[0][0]) * (x + 1.0):.1e}")
        off[scale] = x + 1.0
        assert barrier > 10 * BARRIER_TOL
    for method in ("SLSQP", "L-BFGS-B") if scale > 1e-3 else ():
        assert np.isclose(minimize(**cost, bounds=Bounds(-1.0, np.inf), method=method).x[0], -1.0, atol=1e-9)
assert 1e-4 < off[1.0] < 3e-4 and 3e-3 < off[1e-2] < 5e-3 and 0.06 < off[1e-6] < 0.08 and 2e-5 < off[1e3] < 3e-5
PY
