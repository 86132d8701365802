#!/usr/bin/env bash
# Version:  rockit-meco 0.6.7, casadi 3.8.2
# Does:     SplineMethod takes an objective made of ocp.integral and minimises 0 in its place. ocp.integral(.., grid="control") and ocp.sum
#           are kept. What is found then is any point that keeps the constraints, solved without a word.
# Guess:    the methods transcribe one problem; SplineMethod refuses what it cannot do, as it does for dynamics that are not linear.
# Means:    splines are taken where limits shall hold between the grid points; least effort or jerk, written as everywhere else
#           in rockit, gives a motion that waits until the last steps and then jerks. An integral that shall be kept
#           under a bound is free as well. Write the integral on the control grid. No report was found.
# Seen:     unit mass from rest to rest, 1 m in 1 s, ten intervals: MultipleShooting 12.12 (exact for a held force), SplineMethod objective
#           0.00 with a force of 0 for 0.7 s and then 100 and -100 N; with grid="control" both 12.12. "integral <= 13" is kept by
#           MultipleShooting, while SplineMethod exceeds it by far
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check rockit-meco==0.6.7 casadi==3.8.2 networkx==3.6.1 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - > out 2>&1 <<'PY' || { tail -20 out; exit 1; }
import numpy as np
from rockit import MultipleShooting, Ocp, SplineMethod

N = 10
LEAST = 12 / (1 - 1 / N**2)  # of a force that is held over each of N intervals; 12 of any force


def solve(method, objective=None, bound=None):
    ocp = Ocp(t0=0, T=1.0)
    x, v, u = ocp.state(), ocp.state(), ocp.control()
    ocp.set_der(x, v)
    ocp.set_der(v, u)
    if objective is not None:
        ocp.add_objective(objective(ocp, u))
    if bound is not None:
        ocp.subject_to(ocp.integral(u**2) <= bound)
    for end, place in ((ocp.at_t0, 0), (ocp.at_tf, 1)):
        ocp.subject_to(end(x) == place)
        ocp.subject_to(end(v) == 0)
    ocp.solver("ipopt", {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes"})
    ocp.method(method)
    solution = ocp.solve()
    assert solution.stats["success"]
    place, force = (solution.sample(s, grid="control")[1] for s in (x, u))
    assert np.allclose(place[[0, -1]], [0, 1], atol=1e-6)
    return solution.value(ocp.objective) if objective else 0.0, np.sum(force[:-1] ** 2) / N, force


for words, objective in (
    ("integral", lambda ocp, u: ocp.integral(u**2)),
    ("integral on the control grid", lambda ocp, u: ocp.integral(u**2, grid="control")),
    ("sum / N", lambda ocp, u: ocp.sum(u**2) / N),
):
    for method in (MultipleShooting, SplineMethod):
        value, effort, force = solve(method(N=N), objective)
        print(f"SEEN {words}, {method.__name__}: objective {value:.2f}, effort {effort:.2f} of {LEAST:.2f}, force {np.round(force, 1)}")
        if method is SplineMethod and words == "integral":
            assert abs(value) < 1e-6 and effort > 1000
        else:
            assert abs(value - LEAST) < 1e-3 and abs(effort - LEAST) < 1e-3
for method in (MultipleShooting, SplineMethod):
    _, effort, _ = solve(method(N=N), bound=13)
    print(f"SEEN integral <= 13, {method.__name__}: effort {effort:.2f}")
    assert effort < 13.01 if method is MultipleShooting else effort > 1000
PY
grep SEEN out
