#!/usr/bin/env bash
# Version:  qpsolvers 4.13.0 with proxsuite 0.8.0, against daqp 0.11.0, osqp 1.1.3, piqp 0.7.0,
#           clarabel 0.11.1, quadprog 0.1.14
# Does:     a quadratic program with one negative curvature, bounded by a box, is "solved" by proxqp at
#           the point that is highest along that direction. The others say it is not convex, or that
#           they found nothing.
# Guess:    either a corner of the box (the minimum), or no solution.
# Means:    an SQP that hands an exact Hessian to proxqp without convexifying it steps to where the
#           model is largest and is told that all is well. Compare the model's value with that at 0.
# Seen:     proxqp found=True x=(0, 0.01) value +5e-5; the minimum is -0.51 at (0, -1)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check qpsolvers==4.13.0 \
  proxsuite==0.8.0 daqp==0.11.0 osqp==1.1.3 piqp==0.7.0 clarabel==0.11.1 quadprog==0.1.14
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
from qpsolvers import Problem, solve_problem

P, q = np.diag([1.0, -1.0]), np.array([0.0, 0.01])
box = np.ones(2)
found = {}
for name in ("proxqp", "daqp", "osqp", "piqp", "clarabel", "quadprog"):
    try:
        answer = solve_problem(Problem(P, q, lb=-box, ub=box), solver=name)
        found[name] = bool(answer.found)
        print(name, "found" if answer.found else "nothing found", answer.x)
    except Exception as error:
        found[name] = False
        print(name, "refuses:", type(error).__name__)
    if name == "proxqp":
        x = answer.x
value, lowest = 0.5 * x @ P @ x + q @ x, -0.51
print(f"value at proxqp's answer {value:.2e}, at (0, -1) {lowest}")
assert found.pop("proxqp") and not any(found.values())
assert value > 0.0 > lowest and np.allclose(x, [0.0, 0.01], atol=1e-4)
PY
