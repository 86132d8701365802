#!/usr/bin/env bash
# Version:  casadi 3.8.2 (with its fatrop, daqp and osqp)
# Does:     a quadratic program solved by qpsol(..., "fatrop", ...) has the right solution and multipliers, and its "f"
#           is the objective at x = 0, whatever the solution; conic(..., "fatrop", ...) has 0 as "cost". The other
#           solvers that CasADi brings return the value at the solution. Nothing is said.
# Guess:    "f" is the objective at "x".
# Means:    an MPC or SQP loop that watches this number (has the cost fallen, is a step acceptable, which foothold is
#           cheaper) sees a constant, so that every step looks accepted or none, once the solver is exchanged for
#           the faster one. Evaluate the objective at the solution.
# Seen:     three programs: f 8, 20 and 10 by fatrop, the values at 0, and 3.5, 11.5 and 2 at its own x; by daqp and
#           osqp 3.5, 11.5 and 2; x of all three alike within 1e-4, multipliers balance the gradient within 1e-4
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2
cd "$work"
"$work/env/bin/python" - > said <<'PY' || { cat said; exit 1; }
import casadi
import numpy as np

x = casadi.SX.sym("x", 2)
OPTIONS = {"fatrop": {}, "daqp": {}, "osqp": {"osqp": {"verbose": False, "eps_abs": 1e-9, "eps_rel": 1e-9}}}
programs = [((x[0] - 1) ** 2 + (x[1] + 2) ** 2 + 3, 0.0, 10.0),
            ((x[0] - 2) ** 2 + 2 * (x[1] - 2) ** 2 + x[0] * x[1] + 8, -5.0, 2.0),
            ((x[0] - 2) ** 2 + (x[1] - 2) ** 2 + 2, -np.inf, np.inf)]
for objective, low, high in programs:
    value = casadi.Function("value", [x], [objective])
    found = {}
    for solver, options in OPTIONS.items():
        program = {"x": x, "f": objective, "g": x[0] + x[1]}
        solve = casadi.qpsol("solve", solver, program, {"print_time": False, **options})
        found[solver] = solve(lbg=low, ubg=high, lbx=-5, ubx=5)
        answer = {key: np.array(entry).ravel() for key, entry in found[solver].items()}
        slope = np.array(casadi.Function("slope", [x], [casadi.gradient(objective, x)])(answer["x"])).ravel()
        assert abs(slope + answer["lam_g"] + answer["lam_x"]).max() < 1e-4
        at_x, at_zero = float(value(answer["x"])), float(value([0, 0]))
        print(f"SEEN {solver}: f {answer['f'][0]:.4f}, objective at its x {at_x:.4f}, at 0 {at_zero:.4f}")
        assert np.isclose(answer["f"][0], at_zero if solver == "fatrop" else at_x, atol=1e-4)
        assert at_zero - at_x > 1.0
        assert np.allclose(answer["x"], np.array(found["fatrop"]["x"]).ravel(), atol=1e-4)
PY
grep SEEN said
