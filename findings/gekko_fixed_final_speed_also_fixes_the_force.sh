#!/usr/bin/env bash
# Version:  gekko 1.3.3 with its own solver program (remote=False), ipopt
# Does:     fix_final(v, 0), "Fix the final condition of a variable so the solver cannot adjust it", also holds the derivative of v at
#           zero in the last step, and so does the Connection that it is made of. What pushes v in the last step is lost to the
#           solver. Docstring and manual say nothing; an answer of the maintainer on a forum does.
# Guess:    a final condition is a condition on the value, as the same equation with a parameter that is 1 at the end is.
# Means:    the end of a step or of a stride, fixed like this, is one without acceleration: the cost is too high by the
#           cube of the steps that are left, the last torques are zero, and a cyclic motion gets a rest it was not asked for.
#           Use m.Equation(last * (v - value) == 0).
# Seen:     unit mass from rest to rest, 1 m in 1 s: least effort of a held force 12.12 for 10 steps, 12.00 for 50; with fix_final 16.67 and
#           12.76 with a last force of 0, those of one step less; with the equation 12.12 and 12.00
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check gekko==1.3.3 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - > out 2>&1 <<'PY' || { tail -20 out; exit 1; }
import numpy as np
from gekko import GEKKO


def least(steps, free):
    """Effort of the force, held over each of so many equal steps of one second, that ends 1 m further at rest; the first `free` may push."""
    length = 1 / steps
    moves = [length * (1 - (k + 0.5) * length) if k < free else 0.0 for k in range(steps)]
    rows = np.array([moves, [length if k < free else 0.0 for k in range(steps)]])
    force = np.linalg.lstsq(rows, [1.0, 0.0])[0]
    return length * force @ force


def solve(steps, fixed):
    m = GEKKO(remote=False)
    m.time = np.linspace(0, 1, steps + 1)
    x, v, effort = m.Var(0), m.Var(0), m.Var(0)
    u = m.MV(0, lb=-50, ub=50, fixed_initial=False)
    u.STATUS = 1
    m.Equations([x.dt() == v, v.dt() == u, effort.dt() == u**2])
    last = m.Param(np.r_[np.zeros(steps), 1.0])
    m.Equation(last * (x - 1) == 0)
    if fixed:
        m.fix_final(v, 0)
    else:
        m.Equation(last * v == 0)
    m.Minimize(last * effort)
    m.options.IMODE, m.options.NODES, m.options.SOLVER = 6, 2, 3
    m.solve(disp=False)
    assert m.options.APPSTATUS == 1 and abs(x.value[-1] - 1) < 1e-6 and abs(v.value[-1]) < 1e-6
    return effort.value[-1], u.value[-1]


for steps in (10, 50):
    for fixed in (False, True):
        effort, force = solve(steps, fixed)
        print(f"SEEN {steps} steps, {'fix_final' if fixed else 'equation'}: effort {effort:.2f}, least {least(steps, steps):.2f}, least with an idle "
              f"last step {least(steps, steps - 1):.2f}, last force {force:.2f}")
        assert abs(effort - least(steps, steps - fixed)) < 1e-3
        assert abs(force) < 1e-6 if fixed else force < -5
PY
grep SEEN out
