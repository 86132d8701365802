#!/usr/bin/env bash
# Version:  drake 1.51.1 (SNOPT, IPOPT, OSQP, Clarabel inside)
# Does:     two bounding boxes on one variable share the lower bound -1, which is active. GetDualSolution
#           gives the whole multiplier, 4, to each of them with SNOPT and IPOPT, and 2 to each with OSQP
#           and Clarabel.
# Guess:    the multipliers of all constraints balance the gradient of the cost, with every solver.
# Means:    joint ranges are often stated twice, by the model and by the task. With SNOPT or IPOPT the sum
#           of the multipliers is then twice the gradient: sensitivities to the range and stationarity
#           checks made from them are wrong by 2. Merge bounds on a variable before solving.
# Seen:     gradient 4; sum of the two duals 8 (SNOPT, IPOPT), 4 (OSQP, Clarabel)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check drake==1.51.1
"$work/env/bin/python" - <<'PY'
import numpy as np
from pydrake.all import ClarabelSolver, IpoptSolver, MathematicalProgram, OsqpSolver, SnoptSolver

sums = {}
for kind in (SnoptSolver, IpoptSolver, OsqpSolver, ClarabelSolver):
    program = MathematicalProgram()
    (q,) = program.NewContinuousVariables(1)
    program.AddQuadraticCost((q + 3.0) * (q + 3.0))
    boxes = [program.AddBoundingBoxConstraint(-1.0, upper, q) for upper in (1.0, 5.0)]
    result = kind().Solve(program)
    assert result.is_success() and np.isclose(result.GetSolution(q), -1.0, atol=1e-5)
    duals = [result.GetDualSolution(box).item() for box in boxes]
    sums[kind.__name__] = sum(duals)
    print(f"{kind.__name__}: duals {np.round(duals, 5)}, gradient of the cost {2 * (-1 + 3)}")
wanted = {"SnoptSolver": 8.0, "IpoptSolver": 8.0, "OsqpSolver": 4.0, "ClarabelSolver": 4.0}
assert all(np.isclose(sums[name], wanted[name], atol=1e-4) for name in wanted)
PY
