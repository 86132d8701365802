#!/usr/bin/env bash
# Version:  qpsolvers 4.13.0 with pyqpmad 1.4.1, against daqp 0.11.0 and clarabel 0.11.1
# Does:     a variable whose lower and upper bound are equal gets the multiplier 0 where pyqpmad is asked for, whatever
#           presses on it. The point is right to the last digit. Where the program has equality rows, too, their
#           multipliers are fitted to what is left of the gradient, so that they take up a share of the lost one and
#           are wrong as well. With bounds a thousandth apart all is right. Solution.dual_residual() shows it, and no flag.
# Guess:    what is found satisfies the optimality conditions, as with the other solvers of the package.
# Means:    joints are locked by equal bounds: the torque that the lock takes reads 0, and ground forces or loads of a
#           linkage, which are the multipliers of equality rows, are those of another program. A sensitivity or a
#           certificate made of them is void. Lock by an equality row, or look at the dual residual. No report was found.
# Seen:     60 programs of six variables, one locked: multiplier of the lock 0 for 0.3 to 22, dual residual as much, points alike to
#           1e-8 (daqp); with two equality rows those are off by up to 72, by more than 0.5 in 75 % of the programs;
#           bounds 1e-3 apart: all right
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check qpsolvers==4.13.0 pyqpmad==1.4.1 daqp==0.11.0 \
  clarabel==0.11.1 numpy==2.4.6 scipy==1.17.1
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
import numpy as np
import qpsolvers

rng = np.random.default_rng(0)
OTHERS = "daqp", "clarabel"
found = {(rows, apart): [] for rows in (0, 2) for apart in (0.0, 1e-3)}
for _ in range(60):
    half = rng.normal(size=(6, 6))
    P, q, inside = half @ half.T + 0.1 * np.eye(6), 3 * rng.normal(size=6), rng.normal(size=6)
    A = rng.normal(size=(2, 6))
    for rows, apart in found:
        low, high = inside - 0.2, inside + 0.3
        low[0], high[0] = inside[0], inside[0] + apart
        equal = dict(A=A, b=A @ inside) if rows else {}
        problem = qpsolvers.Problem(P, q, lb=low, ub=high, **equal)
        mine = qpsolvers.solve_problem(problem, "pyqpmad")
        assert mine.found
        for name in OTHERS:
            theirs = qpsolvers.solve_problem(problem, name)
            assert theirs.found and theirs.dual_residual() < 1e-4, name
            assert np.allclose(mine.x, theirs.x, atol=1e-4 if name == "clarabel" else 1e-8), name
        reference = qpsolvers.solve_problem(problem, "daqp")
        off = abs(mine.y - reference.y).max() if rows else 0.0
        found[rows, apart].append((mine.dual_residual(), off, mine.z_box[0], reference.z_box[0]))
for (rows, apart), runs in found.items():
    residual, off, zero, true = (np.array(column) for column in zip(*runs))
    print(f"{rows} equality rows, bounds {apart} apart: dual residual {residual.min():.2g} to {residual.max():.2g}, multipliers of rows"
          f" off by up to {off.max():.2g}, {(off > 0.5).mean():.0%} by more than 0.5; of the bound {abs(zero).max():.3g} for {abs(true).max():.3g}")
    if apart:
        assert residual.max() < 1e-6 and off.max() < 1e-3 and abs(zero - true).max() < 1e-3
    else:
        assert not zero.any() and abs(true).min() > 1e-3
        if not rows:
            assert np.allclose(residual, abs(true), atol=1e-6)  # what lacks is the multiplier of the lock
        else:
            assert (residual > 1e-3).mean() > 0.9 and off.max() > 5 and (off > 0.5).mean() > 0.4
PY
